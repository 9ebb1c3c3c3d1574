-- How much of the farm a study and its user may take, and how the farm did of late.

-- As in audit: role and name of who submitted it; 'local' without a certificate.
ALTER TABLE studies ADD COLUMN user TEXT NOT NULL DEFAULT 'local';
UPDATE studies SET user = coalesce(
  (SELECT CASE WHEN a.actor GLOB '* * *'
               THEN substr(a.actor, 1, instr(a.actor, ' ')
                           + instr(substr(a.actor, instr(a.actor, ' ') + 1), ' ') - 1)
               ELSE 'local' END
   FROM audit AS a WHERE a.study_id = studies.id AND a.action = 'submit' ORDER BY a.id LIMIT 1), 'local');
-- At most so many of its jobs are LEASED at a time; 0: no limit of its own.
ALTER TABLE studies ADD COLUMN max_running INTEGER NOT NULL DEFAULT 0 CHECK (max_running >= 0);

-- A sample of the farm's figures a minute; the oldest go.
CREATE TABLE farm_history (
  unix_s REAL PRIMARY KEY,
  pairs_per_hour REAL NOT NULL,
  ready INTEGER NOT NULL,    -- Jobs.
  running INTEGER NOT NULL,
  waiting INTEGER NOT NULL,  -- BLOCKED or RETRY_WAIT.
  workers INTEGER NOT NULL,
  slots INTEGER NOT NULL,
  busy INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
