-- A study's own receiver of notices. Apart from its text, because the address may be a secret.
CREATE TABLE study_receivers (
  study_id INTEGER PRIMARY KEY REFERENCES studies(id),
  url TEXT NOT NULL CHECK (url <> ''),
  events TEXT NOT NULL                   -- Those that it wants, each between commas: ',done,failed,'. Empty: all.
) STRICT;

-- As before, with the event 'waits' and the target 'study'.
ALTER TABLE notices RENAME TO old_notices;
CREATE TABLE notices (
  id INTEGER PRIMARY KEY,
  target TEXT NOT NULL,                  -- Who is told: 'webhook', 'command', or 'study': the study's own receiver.
  study_id INTEGER NOT NULL REFERENCES studies(id),
  event TEXT NOT NULL CHECK (event IN ('done', 'failed', 'stalled', 'waits')),
  since_unix_s REAL NOT NULL,            -- When it first happened.
  raised INTEGER NOT NULL DEFAULT 1,     -- How often it has happened.
  tries INTEGER NOT NULL DEFAULT 0,      -- Deliveries that failed.
  due_unix_s REAL NOT NULL,              -- Not before.
  UNIQUE (target, study_id, event)
) STRICT;
INSERT INTO notices SELECT * FROM old_notices;
DROP TABLE old_notices;

-- What was done to one study, its comments among it: an endless study adds entries for ever.
DROP INDEX comments_of_study;
CREATE INDEX audit_of_study ON audit(study_id) WHERE study_id IS NOT NULL;
