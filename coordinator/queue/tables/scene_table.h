// The table `scenes`: how far the scenes of variants are. It makes no decisions:
// Tables::ChangeScene says how a scene changes when its jobs end. A command sees one scene after
// another, so the scene that it looks at is kept in memory and written once. Used only by the
// writing thread, inside a transaction. Errors: those of the database.
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

  // Returns the scene as the current command sees it. With `change`, it is written by Flush, which
  // opening another scene calls. The pointer is valid until then. Errors: kNotFound if it is not
  // there.
  absl::StatusOr<SceneRow*> Open(int64_t variant, uint32_t ordinal, bool change);
  // Opens a new scene with this number of rigs.
  absl::Status Add(int64_t variant, uint32_t ordinal, uint32_t rigs);
  absl::Status Flush();
  // Forgets the open scene with its changes, at the begin of a command or when one is undone.
  void Close() { open_.variant = 0; }
  // Returns the ordinal of the highest scene that has not lost all its rigs.
  absl::StatusOr<std::optional<uint32_t>> HighestLiving(int64_t variant);

 private:
  absl::StatusOr<SceneRow> Find(int64_t variant, uint32_t ordinal);

  SqliteConnection& db_;
  struct {
    int64_t variant = 0;  // 0: none is open.
    uint32_t ordinal = 0;
    SceneRow row;
    bool is_new = false;
    bool changed = false;
  } open_;
};

}  // namespace parallax
