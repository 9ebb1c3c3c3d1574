-- Which store has the files of the results; what of it was found damaged and is made again; how far the last look at it came.

CREATE TABLE store (
  one INTEGER PRIMARY KEY CHECK (one = 1),
  store_id TEXT NOT NULL CHECK (store_id <> ''),  -- The id in the store's marker.
  since_unix_s REAL NOT NULL
) STRICT;

-- Pairs that were published and taken back, because files of theirs were not what they had been.
CREATE TABLE repairs (
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  ordinal INTEGER NOT NULL,
  rig INTEGER NOT NULL,
  cursor INTEGER NOT NULL,         -- In `frames`; never given again.
  since_unix_s REAL NOT NULL,
  reason TEXT NOT NULL,
  PRIMARY KEY (variant_id, ordinal, rig)
) STRICT, WITHOUT ROWID;
CREATE INDEX repairs_by_cursor ON repairs(cursor);

CREATE TABLE scrub (
  one INTEGER PRIMARY KEY CHECK (one = 1),
  position BLOB NOT NULL,          -- The last result that was looked at, by key; empty: none yet.
  began_unix_s REAL NOT NULL,
  ended_unix_s REAL,               -- NULL while it is under way.
  files INTEGER NOT NULL,
  bytes INTEGER NOT NULL,
  damaged INTEGER NOT NULL         -- Results.
) STRICT;

-- Jobs of a study that is repaired leave the archive for their table again.
DROP TRIGGER archived_jobs_stay;
CREATE TRIGGER archived_jobs_stay BEFORE DELETE ON archived_jobs
WHEN (SELECT forgotten FROM studies WHERE id = OLD.study_id) = 0
  AND NOT EXISTS (SELECT 1 FROM jobs AS j WHERE j.id = OLD.id)
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;
