-- Searches over the settings of a generator: their trials and how far they have come, as v1.SearchRecord. Each rung is a
-- study like all others.
CREATE TABLE searches (
  name TEXT PRIMARY KEY CHECK (name <> ''),
  record BLOB NOT NULL
) STRICT, WITHOUT ROWID;
