// The table `attempt_losses`: a row for each attempt that ended without a result. It makes no
// decisions: commands/reports.cc decides what a loss means for its job. Used only by the writing
// thread, inside a transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// An attempt that ended without a result.
struct AttemptLoss {
  int64_t job = 0;
  uint64_t fence = 0;
  const char* ledger = "app";  // "app", "lost" or "returned".
  std::string worker;
  std::string fingerprint;  // What failures of one cause have in common; empty but for "app".
  std::string error;
  double unix_s = 0;     // The same for all attempts that a worker loses at one time.
  std::string log_tail;  // The last lines of the attempt's log; may be empty.
};

class LossTable {
 public:
  // `db` must outlive the table. `most_logs` bounds the number of logs of failed attempts, in the
  // hot table and again in the archive; the oldest are dropped.
  LossTable(SqliteConnection& db, int most_logs) : db_(db), most_logs_(most_logs) {}

  absl::Status Insert(const AttemptLoss& loss);
  // Changes a loss into a return, because the attempt's worker lives and was only away. The job no
  // longer counts the loss, unless it has ended.
  absl::Status MoveLostToReturned(int64_t job, uint64_t fence);
  // Drops the oldest logs of the archive.
  absl::Status DropArchivedLogs();

  // Return whether the attempt is in any ledger of losses, or in this one.
  absl::StatusOr<bool> WasLost(int64_t job, uint64_t fence);
  absl::StatusOr<bool> Has(int64_t job, uint64_t fence, const char* ledger);
  // Returns the number of different workers that reported the fingerprint of the job.
  absl::StatusOr<int> WorkersWithFingerprint(int64_t job, const std::string& fingerprint);
  // Returns whether there is another job that every worker lost with this job also held, including
  // the worker that is lost now.
  absl::StatusOr<bool> AlwaysLostWithAnother(int64_t job, const std::string& worker, double now);

 private:
  SqliteConnection& db_;
  const int most_logs_;
};

}  // namespace parallax
