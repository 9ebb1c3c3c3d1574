// The archive of old jobs: the tables `archived_jobs` and `archived_losses`, which keep the hot
// tables small. Archived jobs are still listed and their results are still reused, but they can't
// be retried. Used only by the writing thread, inside a transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <optional>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/tables/loss_table.h"

namespace parallax {

class JobArchive {
 public:
  // `db` and `losses` must outlive the archive. `newest_too`: see UnsafeForTest::archive_newest.
  JobArchive(SqliteConnection& db, LossTable& losses, bool newest_too)
      : db_(db), losses_(losses), past_newest_(newest_too ? 1 : 0) {}

  // Returns a study that finished before `finished_before`, in seconds since 1970, and still has
  // jobs outside of the archive.
  absl::StatusOr<std::optional<int64_t>> StudyToArchive(double finished_before);
  // Moves up to `limit` ended jobs of the study to the archive, with their losses. Returns their
  // number.
  absl::StatusOr<int> Add(int64_t study, int limit);
  // Moves all jobs of the study back from the archive.
  absl::Status Restore(int64_t study);
  // Removes up to `limit` archived jobs of a forgotten study, with their losses. Returns their
  // number.
  absl::StatusOr<int> Remove(int64_t study, int limit);

 private:
  SqliteConnection& db_;
  LossTable& losses_;
  const int past_newest_;  // Jobs are archived whose numbers are below the newest's plus this.
};

}  // namespace parallax
