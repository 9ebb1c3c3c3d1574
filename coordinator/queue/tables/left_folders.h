// The folders that attempts without a result left in the store, as the tables `litter` and
// `kept_folders`. The janitor removes litter. Later attempts at the same work may continue from a
// kept folder; when no attempt can any more, it becomes litter. Used only by the writing thread,
// inside a transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// The scene whose jobs may continue from a kept folder.
struct KeptFor {
  int64_t variant = 0;
  uint32_t ordinal = 0;
};

// Paths are those of the store. `now` is in seconds since 1970.
class LeftFolders {
 public:
  // `db` must outlive the object.
  explicit LeftFolders(SqliteConnection& db) : db_(db) {}

  // Add a path to the litter, or remove those that the janitor has removed.
  absl::Status InsertLitter(const std::string& path, double now);
  absl::Status DeleteLitter(const std::vector<std::string>& paths);

  // Keeps a folder from which later attempts may continue. `scene` is set for jobs of scenes.
  absl::Status Keep(const std::string& path, const Sha256Digest& keep_key,
                    const std::optional<KeptFor>& scene, double now);
  // Returns kept folders, the newest first.
  absl::StatusOr<std::vector<std::string>> Kept(const Sha256Digest& keep_key, int limit);
  absl::StatusOr<bool> IsKept(const std::string& path);

  // Makes litter of the folders kept for work that is done.
  absl::Status SweepDone(const Sha256Digest& work_key, double now);
  // Makes litter of the folders kept for a scene without open jobs.
  absl::Status SweepScene(const KeptFor& scene, double now);
  // Makes litter of the folders kept for work without a scene that no study wants any more: all its
  // jobs are cancelled or archived.
  absl::Status SweepUnwanted(double now);

 private:
  SqliteConnection& db_;
};

}  // namespace parallax
