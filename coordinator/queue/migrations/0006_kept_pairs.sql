-- Attempts at scenes' jobs go on from earlier ones, too: their folders stay until no job of the scene
-- is open. Jobs of one scene are divided, so work_key of such a row is that of all its pairs.
ALTER TABLE kept_folders ADD COLUMN variant_id INTEGER;  -- NULL: of a job without a scene.
ALTER TABLE kept_folders ADD COLUMN ordinal INTEGER;
CREATE INDEX kept_folders_of_scene ON kept_folders(variant_id, ordinal) WHERE variant_id IS NOT NULL;
