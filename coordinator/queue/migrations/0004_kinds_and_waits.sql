-- Kinds of jobs are rows and not words in this schema: what the tables must know of a kind stands in
-- job_kinds, which each start brings up to date. Results of all stages are in one table. Jobs may
-- wait for other jobs and for a variant's pairs.
CREATE TABLE job_kinds (
  name TEXT PRIMARY KEY,
  of_scene INTEGER NOT NULL CHECK (of_scene IN (0, 1)),       -- Its jobs stand for pairs of a scene.
  may_reject INTEGER NOT NULL CHECK (may_reject IN (0, 1)),
  has_output INTEGER NOT NULL CHECK (has_output IN (0, 1)),   -- Attempts write into the store.
  can_split INTEGER NOT NULL CHECK (can_split IN (0, 1)),
  shares_part INTEGER NOT NULL CHECK (shares_part IN (0, 1))  -- See coordinator/queue/job_kind.h.
) STRICT, WITHOUT ROWID;
INSERT INTO job_kinds(name, of_scene, may_reject, has_output, can_split, shares_part)
VALUES ('solve', 1, 1, 0, 0, 1), ('render', 1, 0, 1, 1, 0);

-- Results by content. First committed wins; none ever changes.
CREATE TABLE results (
  work_key BLOB PRIMARY KEY,
  stage TEXT NOT NULL,   -- 'layout', 'recipe', 'scene', 'frame', or another kind's name.
  bytes BLOB,            -- The kind's own, most of them zstd.
  rejected TEXT,         -- Why there is no such thing.
  job_id INTEGER,        -- Whose attempt made it, and which; NULL of results older than this table.
  fence INTEGER,
  CHECK ((bytes IS NULL) <> (rejected IS NULL)),
  CHECK ((job_id IS NULL) = (fence IS NULL))
) STRICT;
INSERT INTO results(work_key, stage, bytes, rejected)
SELECT layout_key, 'layout', layout_z, rejected FROM layout_results;
INSERT INTO results(work_key, stage, bytes) SELECT scene_hash, 'recipe', scene_z FROM recipes;
INSERT INTO results(work_key, stage, bytes, rejected)
SELECT scene_key, 'scene', scene_hash, rejected FROM scene_results;
INSERT INTO results(work_key, stage, bytes, job_id, fence)
SELECT frame_key, 'frame', frame_z, job_id, fence FROM frame_results;

CREATE TABLE new_frames (
  cursor INTEGER PRIMARY KEY,      -- The order of publication.
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  ordinal INTEGER NOT NULL,
  rig INTEGER NOT NULL,
  frame_key BLOB NOT NULL REFERENCES results(work_key),
  reused INTEGER NOT NULL CHECK (reused IN (0, 1)),
  UNIQUE (variant_id, ordinal, rig)
) STRICT;
INSERT INTO new_frames SELECT * FROM frames;
DROP TABLE frames;
ALTER TABLE new_frames RENAME TO frames;
CREATE INDEX frames_of_study ON frames(study_id, cursor);
DROP TABLE frame_results;
DROP TABLE scene_results;
DROP TABLE layout_results;
DROP TABLE recipes;
CREATE TRIGGER frames_are_final BEFORE UPDATE ON frames
BEGIN SELECT RAISE(ABORT, 'a published frame never changes'); END;
CREATE TRIGGER results_are_final BEFORE UPDATE ON results
BEGIN SELECT RAISE(ABORT, 'a published result never changes'); END;

-- Jobs outside of scenes whose newest generation ended without a result.
ALTER TABLE variants ADD COLUMN others_lost INTEGER NOT NULL DEFAULT 0 CHECK (others_lost >= 0);

CREATE TABLE new_jobs (
  id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  kind TEXT NOT NULL REFERENCES job_kinds(name),
  ordinal INTEGER NOT NULL,                -- Of its scene; of a kind without scenes: its number.
  rigs TEXT NOT NULL DEFAULT '',           -- Pairs of the scene that it stands for: "0-19".
  rig_count INTEGER NOT NULL DEFAULT 0,
  generation INTEGER NOT NULL DEFAULT 1,   -- A manual retry is a new one.
  state TEXT NOT NULL,
  work_key BLOB NOT NULL,                  -- Equal for equal work.
  group_key BLOB NOT NULL,                 -- Equal for what is better done by one worker.
  fence INTEGER,                           -- The newest attempt's; of a job that ended by a report, the winner's.
  worker TEXT,                             -- Who holds it (LEASED) or had it last.
  attempts INTEGER NOT NULL DEFAULT 0,
  app_failures INTEGER NOT NULL DEFAULT 0,
  infra_losses INTEGER NOT NULL DEFAULT 0,
  part_given INTEGER NOT NULL DEFAULT 0,   -- The newest lease carried its group's part, made elsewhere.
  reused INTEGER NOT NULL DEFAULT 0,       -- SUCCEEDED or REJECTED by somebody else's result.
  awaits_job INTEGER,                      -- BLOCKED: who is leased the same work.
  not_before_unix_s REAL,
  ready_unix_s REAL NOT NULL,
  finished_unix_s REAL,
  error TEXT NOT NULL DEFAULT '',          -- The last failure, loss or rejection.
  input BLOB NOT NULL DEFAULT x'',         -- The kind's own.
  waits_open INTEGER NOT NULL DEFAULT 0 CHECK (waits_open >= 0),  -- BLOCKED: its OPEN rows of `waits`.
  -- Which states there are, and what is set in each: whom it awaits, until when it waits, since when it is over.
  CHECK (CASE state
    WHEN 'READY' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                      AND finished_unix_s IS NULL
    WHEN 'LEASED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                       AND finished_unix_s IS NULL
                       AND fence IS NOT NULL AND worker IS NOT NULL AND attempts > 0
    WHEN 'SUCCEEDED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                          AND finished_unix_s IS NOT NULL
    WHEN 'BLOCKED' THEN (awaits_job IS NULL) = (waits_open > 0) AND not_before_unix_s IS NULL
                        AND finished_unix_s IS NULL
    WHEN 'RETRY_WAIT' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NOT NULL
                           AND finished_unix_s IS NULL
    WHEN 'REJECTED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                         AND finished_unix_s IS NOT NULL
    WHEN 'FAILED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                       AND finished_unix_s IS NOT NULL
    WHEN 'QUARANTINED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                            AND finished_unix_s IS NOT NULL
    WHEN 'CANCELLED' THEN awaits_job IS NULL AND waits_open = 0 AND not_before_unix_s IS NULL
                          AND finished_unix_s IS NOT NULL
    ELSE 0 END),
  CHECK ((rigs = '') = (rig_count = 0))
) STRICT;
INSERT INTO new_jobs SELECT *, x'', 0 FROM jobs;
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
CREATE TRIGGER jobs_reject BEFORE UPDATE OF state ON jobs
WHEN NEW.state = 'REJECTED' AND NOT (SELECT may_reject FROM job_kinds WHERE name = NEW.kind)
BEGIN SELECT RAISE(ABORT, 'this kind of job is never rejected'); END;
-- A job may leave its table only into the archive.
CREATE TRIGGER jobs_stay BEFORE DELETE ON jobs
WHEN NOT EXISTS (SELECT 1 FROM archived_jobs AS a WHERE a.id = OLD.id)
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;

ALTER TABLE archived_jobs RENAME COLUMN layout_given TO part_given;
ALTER TABLE archived_jobs ADD COLUMN input BLOB NOT NULL DEFAULT x'';
ALTER TABLE archived_jobs ADD COLUMN waits_open INTEGER NOT NULL DEFAULT 0;
CREATE VIEW all_jobs AS SELECT * FROM jobs UNION ALL SELECT * FROM archived_jobs;

-- What a job waits for: another job's success, or a variant's first `pairs` published pairs. A row is
-- OPEN until what it names has happened (MET), or can't happen any more or isn't needed (DROPPED).
-- That is entered in the transaction in which it happens; the last MET releases the job, and a
-- DROPPED one cancels it.
CREATE TABLE waits (
  job_id INTEGER NOT NULL REFERENCES jobs(id),
  on_job INTEGER,
  on_variant INTEGER REFERENCES variants(id),
  pairs INTEGER,
  state TEXT NOT NULL CHECK (state IN ('OPEN', 'MET', 'DROPPED')),
  CHECK ((on_job IS NULL) <> (on_variant IS NULL)),
  CHECK ((on_variant IS NULL) = (pairs IS NULL)),
  CHECK (pairs IS NULL OR pairs > 0)
) STRICT;
CREATE INDEX waits_of_job ON waits(job_id);
CREATE INDEX waits_on_job ON waits(on_job) WHERE state = 'OPEN';
CREATE INDEX waits_on_variant ON waits(on_variant) WHERE state = 'OPEN';
CREATE TRIGGER waits_move BEFORE UPDATE ON waits WHEN OLD.state <> 'OPEN'
BEGIN SELECT RAISE(ABORT, 'a wait that is over never changes'); END;
