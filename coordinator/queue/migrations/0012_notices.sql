-- What happened to a study and is not yet told to a receiver of the operator's. One row for each, however often it happens.
CREATE TABLE notices (
  id INTEGER PRIMARY KEY,
  target TEXT NOT NULL,                  -- Who is told: 'webhook', 'command'.
  study_id INTEGER NOT NULL REFERENCES studies(id),
  event TEXT NOT NULL CHECK (event IN ('done', 'failed', 'stalled')),
  since_unix_s REAL NOT NULL,            -- When it first happened.
  raised INTEGER NOT NULL DEFAULT 1,     -- How often it has happened.
  tries INTEGER NOT NULL DEFAULT 0,      -- Deliveries that failed.
  due_unix_s REAL NOT NULL,              -- Not before.
  UNIQUE (target, study_id, event)
) STRICT;

-- Comments are entries of the audit; a study's are shown with it.
CREATE INDEX comments_of_study ON audit(study_id) WHERE action = 'comment';
