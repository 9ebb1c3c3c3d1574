-- Workers whose leases this start of the coordinator has found and that have not said hello since, with the first such
-- start. A lease ends as if the coordinator had run since then: starts in quick succession prolong none.

CREATE TABLE unheard_workers (
  worker TEXT PRIMARY KEY CHECK (worker <> ''),
  since_unix_s REAL NOT NULL
) STRICT, WITHOUT ROWID;
