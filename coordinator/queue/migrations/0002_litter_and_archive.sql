-- Folders in the store that no result will ever name: of attempts that ended without winning, and of
-- frames that another attempt published first. A row comes in the transaction that decides so, and a
-- fence that has lost once never wins, so the janitor may remove what stands here at any time later.
CREATE TABLE litter (
  path TEXT PRIMARY KEY,           -- "<2 hex>/<64 hex>/.attempt-<fence>", or a frame's folder in it.
  since_unix_s REAL NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX litter_by_age ON litter(since_unix_s);

INSERT OR IGNORE INTO litter(path, since_unix_s)
SELECT lower(substr(hex(j.work_key), 1, 2)) || '/' || lower(hex(j.work_key)) || '/.attempt-' || l.fence,
       l.unix_s
FROM attempt_losses AS l JOIN jobs AS j ON j.id = l.job_id WHERE j.kind = 'render';

-- Jobs of studies that are finished for long: out of the way of those at work, but still there for
-- whoever asks. Columns as in `jobs`, in the same order; only ended jobs come here, whole studies at
-- a time (in several transactions, `archived` = 1 from the first).
ALTER TABLE studies ADD COLUMN archived INTEGER NOT NULL DEFAULT 0 CHECK (archived IN (0, 1));

CREATE TABLE archived_jobs (
  id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  kind TEXT NOT NULL,
  ordinal INTEGER NOT NULL,
  rigs TEXT NOT NULL,
  rig_count INTEGER NOT NULL,
  generation INTEGER NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')),
  work_key BLOB NOT NULL,
  group_key BLOB NOT NULL,
  fence INTEGER,
  worker TEXT,
  attempts INTEGER NOT NULL,
  app_failures INTEGER NOT NULL,
  infra_losses INTEGER NOT NULL,
  layout_given INTEGER NOT NULL,
  reused INTEGER NOT NULL,
  awaits_job INTEGER,
  not_before_unix_s REAL,
  ready_unix_s REAL NOT NULL,
  finished_unix_s REAL,
  error TEXT NOT NULL
) STRICT;
CREATE INDEX archived_jobs_of_variant ON archived_jobs(variant_id, ordinal);

CREATE TABLE archived_losses (
  job_id INTEGER NOT NULL REFERENCES archived_jobs(id),
  fence INTEGER NOT NULL,
  ledger TEXT NOT NULL,
  worker TEXT NOT NULL,
  fingerprint TEXT NOT NULL,
  error TEXT NOT NULL,
  unix_s REAL NOT NULL,
  PRIMARY KEY (job_id, fence)
) STRICT, WITHOUT ROWID;

CREATE VIEW all_jobs AS SELECT * FROM jobs UNION ALL SELECT * FROM archived_jobs;
CREATE VIEW all_losses AS SELECT * FROM attempt_losses UNION ALL SELECT * FROM archived_losses;

-- A job may leave its table only into the archive.
DROP TRIGGER jobs_stay;
CREATE TRIGGER jobs_stay BEFORE DELETE ON jobs
WHEN NOT EXISTS (SELECT 1 FROM archived_jobs AS a WHERE a.id = OLD.id)
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;
CREATE TRIGGER archived_jobs_are_final BEFORE UPDATE ON archived_jobs
BEGIN SELECT RAISE(ABORT, 'a job that has ended never changes'); END;
CREATE TRIGGER archived_jobs_stay BEFORE DELETE ON archived_jobs
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;
