// The table `scenes`: how far the scenes of variants are. It makes no decisions: machine_jobs.cc
// decides how a scene changes when its jobs end. Used only by the writing thread, inside a
// transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <optional>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// A row of `scenes`: numbers of its rigs and of its unfinished jobs, and the hash of its recipe.
struct SceneRow {
  uint32_t rigs = 0;
  uint32_t rigs_lost = 0;
  uint32_t rigs_done = 0;
  uint32_t jobs_open = 0;
  std::optional<Sha256Digest> scene_hash;
};

class SceneTable {
 public:
  // `db` must outlive the table.
  explicit SceneTable(SqliteConnection& db) : db_(db) {}

  // Insert, read and overwrite the row of a scene. Errors: kNotFound if there is no row to read.
  absl::Status Insert(int64_t variant, uint32_t ordinal, const SceneRow& row);
  absl::StatusOr<SceneRow> Find(int64_t variant, uint32_t ordinal);
  absl::Status Write(int64_t variant, uint32_t ordinal, const SceneRow& row);
  // Returns the ordinal of the highest scene that has not lost all its rigs.
  absl::StatusOr<std::optional<uint32_t>> HighestLiving(int64_t variant);

 private:
  SqliteConnection& db_;
};

}  // namespace parallax
