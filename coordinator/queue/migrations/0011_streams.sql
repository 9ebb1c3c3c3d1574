-- Endless studies whose pairs are delivered to trainings: how far their consumers have come, as v1.StreamRecord. What
-- makes their pairs are studies like all others.

CREATE TABLE streams (
  name TEXT PRIMARY KEY CHECK (name <> ''),
  record BLOB NOT NULL
) STRICT, WITHOUT ROWID;
