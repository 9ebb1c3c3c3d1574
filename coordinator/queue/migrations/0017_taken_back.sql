-- Jobs whose results were taken back from their studies, because files of theirs were not what they had been. Another
-- generation of the job makes the result again, unless the study was cancelled. `repairs` are the pairs.
CREATE TABLE taken_back (
  job_id INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  since_unix_s REAL NOT NULL,  -- 0 of those that are older than this table.
  reason TEXT NOT NULL
) STRICT;
INSERT INTO taken_back(job_id, study_id, since_unix_s, reason)
SELECT j.id, j.study_id, 0, '' FROM all_jobs AS j JOIN job_kinds AS k ON k.name = j.kind
JOIN studies AS s ON s.id = j.study_id
WHERE k.of_scene = 0 AND k.has_output = 1 AND j.state = 'SUCCEEDED' AND s.forgotten = 0
AND NOT EXISTS (SELECT 1 FROM study_results AS r WHERE r.job_id = j.id)
AND (s.cancelled = 1 OR EXISTS (SELECT 1 FROM all_jobs AS n WHERE n.variant_id = j.variant_id
  AND n.ordinal = j.ordinal AND n.kind = j.kind AND n.generation > j.generation));
