-- The core-seconds that making a result took, where its own bytes don't say: layouts and scenes, whose bytes are the same
-- whoever makes them. 0 of results that are older than this column.
ALTER TABLE results ADD COLUMN core_s REAL NOT NULL DEFAULT 0 CHECK (core_s >= 0);
