-- Only attempts that were lost with their worker count as losses of a job; those that were handed back or never arrived do not.
DROP TRIGGER jobs_move;
DROP TRIGGER archived_jobs_are_final;
UPDATE jobs SET infra_losses = (SELECT count(*) FROM attempt_losses AS l WHERE l.job_id = jobs.id AND l.ledger = 'lost')
WHERE infra_losses > 0;
UPDATE archived_jobs SET infra_losses = (SELECT count(*) FROM archived_losses AS l
                                         WHERE l.job_id = archived_jobs.id AND l.ledger = 'lost')
WHERE infra_losses > 0;
CREATE TRIGGER archived_jobs_are_final BEFORE UPDATE ON archived_jobs
BEGIN SELECT RAISE(ABORT, 'a job that has ended never changes'); END;

-- As before, and a loss may be taken back while its job goes on: neither its lease nor its back-off changes by that.
CREATE TRIGGER jobs_move BEFORE UPDATE ON jobs
WHEN NOT (CASE OLD.state
  WHEN 'READY' THEN NEW.state <> 'RETRY_WAIT' AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  WHEN 'LEASED' THEN (NEW.state <> 'LEASED' OR NEW.fence = OLD.fence) AND NEW.state <> 'BLOCKED'
  WHEN 'BLOCKED' THEN NEW.state <> 'LEASED' AND NEW.state <> 'RETRY_WAIT'
                      AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  WHEN 'RETRY_WAIT' THEN NEW.state <> 'LEASED'
                         AND (NEW.state <> 'RETRY_WAIT' OR NEW.not_before_unix_s = OLD.not_before_unix_s)
                         AND NEW.state <> 'FAILED' AND NEW.state <> 'QUARANTINED'
  ELSE 0 END)
BEGIN SELECT CASE WHEN OLD.finished_unix_s IS NULL THEN RAISE(ABORT, 'no such move of a job')
                  ELSE RAISE(ABORT, 'a job that has ended never changes') END;
END;
