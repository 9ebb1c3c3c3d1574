// The tables of results: `results` by their keys, whoever made them, and the lists `frames` and
// `study_results`, by which studies refer to them. Used only by the writing thread, inside a
// transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

class ResultTable {
 public:
  // `db` must outlive the table.
  explicit ResultTable(SqliteConnection& db) : db_(db) {}

  // Returns the result with this key, if there is one; Has reads less.
  // Sets `stage` to the result's unless it is null.
  absl::StatusOr<std::optional<StoredResult>> Find(const Sha256Digest& key,
                                                   std::string* stage = nullptr);
  absl::StatusOr<bool> Has(const Sha256Digest& key);
  // Inserts a result, made by the attempt `fence` of `job`. The first one committed wins: leaves an
  // existing result alone. Returns true if it is new.
  absl::StatusOr<bool> Insert(const Sha256Digest& key, std::string_view stage,
                              const StoredResult& result, int64_t job, uint64_t fence);
  // Publishes a pair of the job's scene.
  absl::Status InsertFrame(const JobFacts& scene_of, const FrameLink& frame);
  // Notes that a job without a scene has succeeded and has files.
  absl::Status InsertStudyResult(const JobFacts& job);

 private:
  SqliteConnection& db_;
};

}  // namespace parallax
