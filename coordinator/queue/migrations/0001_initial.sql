-- The job machine. Words as everywhere: study > variant > scene > job > attempt (named by its fence).
--
--   BLOCKED -> READY -> LEASED -> SUCCEEDED | REJECTED | FAILED | QUARANTINED | CANCELLED
--                ^         `---> RETRY_WAIT -> READY
--
-- BLOCKED: the same work is LEASED to somebody else (awaits_job); when that lease ends, however it ends, the job moves on
-- in the same transaction. Times are Unix seconds. Keys and hashes are raw SHA-256. Blobs named *_z are zstd.

CREATE TABLE epochs (
  epoch INTEGER PRIMARY KEY,       -- The upper half of every fence issued by that start of the coordinator.
  started_unix_s REAL NOT NULL,
  program TEXT NOT NULL
) STRICT;

CREATE TABLE studies (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  spec_z BLOB NOT NULL,
  spec_hash BLOB NOT NULL,
  idempotency_key TEXT UNIQUE,
  seed INTEGER NOT NULL,
  priority INTEGER NOT NULL,
  needs_memory_mb INTEGER NOT NULL,
  needs_tags TEXT NOT NULL,        -- One a line.
  submitted_unix_s REAL NOT NULL,
  finished_unix_s REAL,            -- Set while nothing is left to do.
  paused INTEGER NOT NULL DEFAULT 0 CHECK (paused IN (0, 1)),
  cancelled INTEGER NOT NULL DEFAULT 0 CHECK (cancelled IN (0, 1))
) STRICT;
CREATE INDEX studies_unfinished ON studies(id) WHERE finished_unix_s IS NULL;

-- With the counters that a status page shows. pairs_planned = sum over its scenes of rigs - rigs_lost.
CREATE TABLE variants (
  id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  name TEXT NOT NULL,
  config_z BLOB NOT NULL,
  pairs_wanted INTEGER NOT NULL CHECK (pairs_wanted > 0),
  rigs_per_scene INTEGER NOT NULL CHECK (rigs_per_scene > 0),
  next_ordinal INTEGER NOT NULL DEFAULT 0,  -- The cursor: scenes from here on do not exist yet.
  pairs_planned INTEGER NOT NULL DEFAULT 0 CHECK (pairs_planned BETWEEN 0 AND pairs_wanted),
  pairs_done INTEGER NOT NULL DEFAULT 0 CHECK (pairs_done BETWEEN 0 AND pairs_planned),
  scenes_open INTEGER NOT NULL DEFAULT 0 CHECK (scenes_open >= 0),
  solves_reused INTEGER NOT NULL DEFAULT 0,
  layouts_reused INTEGER NOT NULL DEFAULT 0,
  frames_reused INTEGER NOT NULL DEFAULT 0,
  scenes_rejected INTEGER NOT NULL DEFAULT 0,
  tally_solved INTEGER NOT NULL DEFAULT 0,    -- Since submit or the last retry; they decide about giving up.
  tally_rejected INTEGER NOT NULL DEFAULT 0,
  tally_lost INTEGER NOT NULL DEFAULT 0,
  problem TEXT NOT NULL DEFAULT '',           -- Why it gave up.
  UNIQUE (study_id, name)
) STRICT;

CREATE TABLE job_counts (
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  kind TEXT NOT NULL,
  state TEXT NOT NULL,
  jobs INTEGER NOT NULL CHECK (jobs >= 0),
  PRIMARY KEY (variant_id, kind, state)
) STRICT, WITHOUT ROWID;

CREATE TABLE scenes (
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  ordinal INTEGER NOT NULL,
  rigs INTEGER NOT NULL CHECK (rigs > 0),              -- Pairs that it is to give.
  rigs_lost INTEGER NOT NULL DEFAULT 0 CHECK (rigs_lost BETWEEN 0 AND rigs),  -- Rejected, failed, cancelled.
  rigs_done INTEGER NOT NULL DEFAULT 0 CHECK (rigs_done BETWEEN 0 AND rigs - rigs_lost),
  jobs_open INTEGER NOT NULL DEFAULT 0 CHECK (jobs_open >= 0),
  scene_hash BLOB,                                     -- Once it is solved.
  PRIMARY KEY (variant_id, ordinal)
) STRICT, WITHOUT ROWID;

CREATE TABLE jobs (
  id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  kind TEXT NOT NULL CHECK (kind IN ('solve', 'render')),
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
  CHECK (state IN ('BLOCKED', 'READY', 'LEASED', 'RETRY_WAIT',
                   'SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')),
  CHECK ((state = 'BLOCKED') = (awaits_job IS NOT NULL)),
  CHECK ((state = 'RETRY_WAIT') = (not_before_unix_s IS NOT NULL)),
  CHECK (state <> 'LEASED' OR (fence IS NOT NULL AND worker IS NOT NULL AND attempts > 0)),
  CHECK ((state IN ('SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED'))
         = (finished_unix_s IS NOT NULL)),
  CHECK ((kind = 'render') = (rig_count > 0)),
  CHECK (kind = 'solve' OR state <> 'REJECTED')
) STRICT;
CREATE UNIQUE INDEX jobs_of_scene ON jobs(variant_id, ordinal, kind, rigs, generation);
-- The hot sets. A job that has ended is in none of them.
CREATE INDEX jobs_ready ON jobs(study_id, kind, ordinal, variant_id) WHERE state = 'READY';
CREATE INDEX jobs_ready_group ON jobs(group_key) WHERE state = 'READY';
CREATE INDEX jobs_leased ON jobs(worker) WHERE state = 'LEASED';
CREATE INDEX jobs_leased_group ON jobs(group_key) WHERE state = 'LEASED';
CREATE INDEX jobs_blocked ON jobs(awaits_job) WHERE state = 'BLOCKED';
CREATE INDEX jobs_retry_wait ON jobs(not_before_unix_s) WHERE state = 'RETRY_WAIT';
CREATE INDEX jobs_problem ON jobs(variant_id, finished_unix_s) WHERE state IN ('FAILED', 'QUARANTINED');

CREATE TRIGGER jobs_terminal_is_final BEFORE UPDATE ON jobs
WHEN OLD.state IN ('SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')
BEGIN SELECT RAISE(ABORT, 'a job that has ended never changes'); END;

CREATE TRIGGER jobs_stay BEFORE DELETE ON jobs
BEGIN SELECT RAISE(ABORT, 'jobs are never deleted'); END;

-- Only these moves exist.
CREATE TRIGGER jobs_move BEFORE UPDATE OF state ON jobs
WHEN NOT (CASE OLD.state
  WHEN 'READY' THEN NEW.state <> 'RETRY_WAIT' AND NEW.state NOT IN ('FAILED', 'QUARANTINED')
  WHEN 'LEASED' THEN NEW.state NOT IN ('LEASED', 'BLOCKED')
  WHEN 'BLOCKED' THEN NEW.state IN ('READY', 'BLOCKED', 'SUCCEEDED', 'REJECTED', 'CANCELLED')
  WHEN 'RETRY_WAIT' THEN NEW.state IN ('READY', 'BLOCKED', 'SUCCEEDED', 'REJECTED', 'CANCELLED')
  ELSE 1 END)  -- Terminal: forbidden above.
BEGIN SELECT RAISE(ABORT, 'no such move of a job'); END;

-- An attempt that ended without a result: a row of one of the two ledgers.
CREATE TABLE attempt_losses (
  job_id INTEGER NOT NULL REFERENCES jobs(id),
  fence INTEGER NOT NULL,
  ledger TEXT NOT NULL CHECK (ledger IN ('app', 'lost', 'returned')),  -- Failed; worker lost; handed back.
  worker TEXT NOT NULL,
  fingerprint TEXT NOT NULL,
  error TEXT NOT NULL,
  unix_s REAL NOT NULL,
  PRIMARY KEY (job_id, fence)
) STRICT, WITHOUT ROWID;

-- Results by content. First committed wins; none ever changes.
CREATE TABLE layout_results (
  layout_key BLOB PRIMARY KEY,
  layout_z BLOB,
  rejected TEXT,
  CHECK ((layout_z IS NULL) <> (rejected IS NULL))
) STRICT;
CREATE TABLE scene_results (
  scene_key BLOB PRIMARY KEY,
  scene_hash BLOB REFERENCES recipes(scene_hash),
  rejected TEXT,
  CHECK ((scene_hash IS NULL) <> (rejected IS NULL))
) STRICT;
CREATE TABLE recipes (
  scene_hash BLOB PRIMARY KEY,
  scene_z BLOB NOT NULL
) STRICT;
CREATE TABLE frame_results (
  frame_key BLOB PRIMARY KEY,
  frame_z BLOB NOT NULL,
  job_id INTEGER NOT NULL,         -- Whose attempt published it, and which.
  fence INTEGER NOT NULL
) STRICT;

-- A frame of a study's dataset; `cursor` is the order of publication.
CREATE TABLE frames (
  cursor INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  variant_id INTEGER NOT NULL REFERENCES variants(id),
  ordinal INTEGER NOT NULL,
  rig INTEGER NOT NULL,
  frame_key BLOB NOT NULL REFERENCES frame_results(frame_key),
  reused INTEGER NOT NULL CHECK (reused IN (0, 1)),
  UNIQUE (variant_id, ordinal, rig)
) STRICT;
CREATE INDEX frames_of_study ON frames(study_id, cursor);

CREATE TRIGGER frames_are_final BEFORE UPDATE ON frames
BEGIN SELECT RAISE(ABORT, 'a published frame never changes'); END;
CREATE TRIGGER frame_results_are_final BEFORE UPDATE ON frame_results
BEGIN SELECT RAISE(ABORT, 'a published result never changes'); END;

-- Who did what. Append only.
CREATE TABLE audit (
  id INTEGER PRIMARY KEY,
  unix_s REAL NOT NULL,
  actor TEXT NOT NULL,
  action TEXT NOT NULL,
  study_id INTEGER,
  detail TEXT NOT NULL
) STRICT;
CREATE TRIGGER audit_is_final BEFORE UPDATE ON audit
BEGIN SELECT RAISE(ABORT, 'the audit table is append-only'); END;
CREATE TRIGGER audit_stays BEFORE DELETE ON audit
BEGIN SELECT RAISE(ABORT, 'the audit table is append-only'); END;
