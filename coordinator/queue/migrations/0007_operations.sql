-- What operators do: workers that take nothing new, logs of failed attempts that do not pile up, and
-- studies that are forgotten.

-- Workers whose names match the pattern get no leases, until the row goes.
CREATE TABLE drains (
  pattern TEXT PRIMARY KEY,
  reason TEXT NOT NULL,
  actor TEXT NOT NULL,
  since_unix_s REAL NOT NULL
) STRICT, WITHOUT ROWID;

-- The oldest logs are dropped. A later attempt has a larger fence.
CREATE INDEX losses_with_log ON attempt_losses(fence) WHERE log_tail <> '';
CREATE INDEX archived_losses_with_log ON archived_losses(fence) WHERE log_tail <> '';

-- 1: its rows are being removed, in several transactions; 2: only this row is left, so that its
-- number is never given again. From 1 on nobody is told of it.
ALTER TABLE studies ADD COLUMN forgotten INTEGER NOT NULL DEFAULT 0 CHECK (forgotten IN (0, 1, 2));
CREATE INDEX studies_to_remove ON studies(id) WHERE forgotten = 1;
-- Who uses a result. The keys of these tables' rows refer to it, so its removal looks there.
CREATE INDEX frames_of_result ON frames(frame_key);
CREATE INDEX study_results_of_result ON study_results(work_key);
CREATE INDEX scenes_of_recipe ON scenes(scene_hash) WHERE scene_hash IS NOT NULL;

-- Jobs of forgotten studies leave the archive.
DROP TRIGGER archived_jobs_stay;
CREATE TRIGGER archived_jobs_stay BEFORE DELETE ON archived_jobs
WHEN (SELECT forgotten FROM studies WHERE id = OLD.study_id) = 0
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;
