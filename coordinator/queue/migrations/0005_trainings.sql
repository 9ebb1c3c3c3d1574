-- Trainings and evaluations: variants with seeds of their own, attempts that go on from what earlier
-- ones left, results with files that are no frames, and the last lines of a failed program.

-- What its scenes are drawn from.
ALTER TABLE variants ADD COLUMN seed INTEGER NOT NULL DEFAULT 0;
UPDATE variants SET seed = (SELECT s.seed FROM studies AS s WHERE s.id = study_id);

ALTER TABLE job_kinds ADD COLUMN resumes INTEGER NOT NULL DEFAULT 0 CHECK (resumes IN (0, 1));

-- Folders of attempts that ended without a win, of kinds whose later attempts go on from them. They
-- become litter in the transaction that ends the work, or in which the last job that wants it goes.
CREATE TABLE kept_folders (
  path TEXT PRIMARY KEY,           -- As in litter.
  work_key BLOB NOT NULL,
  since_unix_s REAL NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX kept_folders_of_work ON kept_folders(work_key);
-- Who wants a piece of work. Kinds that resume have an input; scenes' jobs have none.
CREATE INDEX jobs_of_work ON jobs(work_key) WHERE input <> x'';

-- Results of a study's jobs outside of scenes that have files; `cursor` is the order of their ends.
CREATE TABLE study_results (
  cursor INTEGER PRIMARY KEY,
  study_id INTEGER NOT NULL REFERENCES studies(id),
  job_id INTEGER NOT NULL UNIQUE,
  work_key BLOB NOT NULL REFERENCES results(work_key)
) STRICT;
CREATE INDEX study_results_of_study ON study_results(study_id, cursor);
CREATE TRIGGER study_results_are_final BEFORE UPDATE ON study_results
BEGIN SELECT RAISE(ABORT, 'a published result never changes'); END;

DROP VIEW all_losses;
ALTER TABLE attempt_losses ADD COLUMN log_tail TEXT NOT NULL DEFAULT '';
ALTER TABLE archived_losses ADD COLUMN log_tail TEXT NOT NULL DEFAULT '';
CREATE VIEW all_losses AS SELECT * FROM attempt_losses UNION ALL SELECT * FROM archived_losses;
