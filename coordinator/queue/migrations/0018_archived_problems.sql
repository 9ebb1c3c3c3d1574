-- Status and page show the problems of old studies, too, and must not look at each of their jobs for that.
CREATE INDEX archived_jobs_problem ON archived_jobs(variant_id, finished_unix_s) WHERE state IN ('FAILED', 'QUARANTINED');
