-- The same machine, said so that SQLite checks it quickly. `x IN (three or more)` makes it build a
-- table each time the check is run, and a CHECK or trigger is run with each change of a job: five
-- tables a change, a fifth of the queue's time. A CASE builds none. And one trigger looks at a change
-- where there were two.

CREATE TABLE new_jobs (
  id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  kind TEXT NOT NULL,
  ordinal INTEGER NOT NULL,
  rigs TEXT NOT NULL DEFAULT '',           -- Of a render job: "0-19".
  rig_count INTEGER NOT NULL DEFAULT 0,
  generation INTEGER NOT NULL DEFAULT 1,   -- A manual retry is a new one.
  state TEXT NOT NULL,
  work_key BLOB NOT NULL,                  -- Equal for equal work: scene key or render key.
  group_key BLOB NOT NULL,                 -- Solve: layout key. Render: hash of the scene (locality).
  fence INTEGER,                           -- The newest attempt's; of a job that ended by a report, the winner's.
  worker TEXT,                             -- Who holds it (LEASED) or had it last.
  attempts INTEGER NOT NULL DEFAULT 0,
  app_failures INTEGER NOT NULL DEFAULT 0,
  infra_losses INTEGER NOT NULL DEFAULT 0,
  layout_given INTEGER NOT NULL DEFAULT 0, -- The newest lease carried a layout solved elsewhere.
  reused INTEGER NOT NULL DEFAULT 0,       -- SUCCEEDED or REJECTED by somebody else's result.
  awaits_job INTEGER,
  not_before_unix_s REAL,
  ready_unix_s REAL NOT NULL,
  finished_unix_s REAL,
  error TEXT NOT NULL DEFAULT '',          -- The last failure, loss or rejection.
  -- Which states there are, and what is set in each: whom it awaits, until when it waits, since when it is over.
  CHECK (CASE state
    WHEN 'READY' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NULL
    WHEN 'LEASED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NULL
                       AND fence IS NOT NULL AND worker IS NOT NULL AND attempts > 0
    WHEN 'SUCCEEDED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NOT NULL
    WHEN 'BLOCKED' THEN awaits_job IS NOT NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NULL
    WHEN 'RETRY_WAIT' THEN awaits_job IS NULL AND not_before_unix_s IS NOT NULL AND finished_unix_s IS NULL
    WHEN 'REJECTED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NOT NULL
    WHEN 'FAILED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NOT NULL
    WHEN 'QUARANTINED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NOT NULL
    WHEN 'CANCELLED' THEN awaits_job IS NULL AND not_before_unix_s IS NULL AND finished_unix_s IS NOT NULL
    ELSE 0 END),
  CHECK (CASE kind
    WHEN 'render' THEN rig_count > 0 AND state <> 'REJECTED'
    WHEN 'solve' THEN rig_count = 0
    ELSE 0 END)
) STRICT;
INSERT INTO new_jobs SELECT * FROM jobs;
DROP VIEW all_jobs;
DROP TABLE jobs;
ALTER TABLE new_jobs RENAME TO jobs;

CREATE UNIQUE INDEX jobs_of_scene ON jobs(variant_id, ordinal, kind, rigs, generation);
-- The hot sets. A job that has ended is in none of them.
CREATE INDEX jobs_ready ON jobs(study_id, kind, ordinal, variant_id) WHERE state = 'READY';
CREATE INDEX jobs_ready_group ON jobs(group_key) WHERE state = 'READY';
CREATE INDEX jobs_leased ON jobs(worker) WHERE state = 'LEASED';
CREATE INDEX jobs_leased_group ON jobs(group_key) WHERE state = 'LEASED';
CREATE INDEX jobs_blocked ON jobs(awaits_job) WHERE state = 'BLOCKED';
CREATE INDEX jobs_retry_wait ON jobs(not_before_unix_s) WHERE state = 'RETRY_WAIT';
CREATE INDEX jobs_problem ON jobs(variant_id, finished_unix_s) WHERE state IN ('FAILED', 'QUARANTINED');

-- Only these changes of a job exist; none of one that has ended, and of a lease only its end.
CREATE TRIGGER jobs_move BEFORE UPDATE ON jobs
WHEN NOT (CASE OLD.state
  WHEN 'READY' THEN NEW.state <> 'RETRY_WAIT' AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  WHEN 'LEASED' THEN NEW.state <> 'LEASED' AND NEW.state <> 'BLOCKED'
  WHEN 'BLOCKED' THEN NEW.state <> 'LEASED' AND NEW.state <> 'RETRY_WAIT'
                      AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  WHEN 'RETRY_WAIT' THEN NEW.state <> 'LEASED' AND NEW.state <> 'RETRY_WAIT'
                         AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  ELSE 0 END)
BEGIN SELECT CASE WHEN OLD.finished_unix_s IS NULL THEN RAISE(ABORT, 'no such move of a job')
                  ELSE RAISE(ABORT, 'a job that has ended never changes') END;
END;
-- A job may leave its table only into the archive.
CREATE TRIGGER jobs_stay BEFORE DELETE ON jobs
WHEN NOT EXISTS (SELECT 1 FROM archived_jobs AS a WHERE a.id = OLD.id)
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;

CREATE VIEW all_jobs AS SELECT * FROM jobs UNION ALL SELECT * FROM archived_jobs;
