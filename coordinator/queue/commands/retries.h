// New attempts at jobs that failed: a manual retry gives lost jobs a new generation, and the end of
// a back-off makes them READY again. Used by the writing thread only.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/status.h"
#include "coordinator/queue/commands/work_limits.h"
#include "coordinator/queue/moves/job_moves.h"
#include "coordinator/queue/moves/waiters.h"

namespace parallax {

class Retries {
 public:
  // All arguments must outlive the object.
  Retries(Tables& tables, JobMoves& jobs, Waiters& waiters, WorkLimits& limits)
      : tables_(tables), jobs_(jobs), waiters_(waiters), limits_(limits) {}

  // Retries a study; see JobQueue::Retry. Errors: kNotFound; kFailedPrecondition for a cancelled or
  // archived study or one over its user's limits; those of JobMoves::AddJob.
  absl::StatusOr<int64_t> Retry(int64_t study, std::string_view reason, std::string_view actor);
  // Retries one job of a study; see JobQueue::RetryJob. Errors: those of Retry; kNotFound for a job
  // that is not the study's; kFailedPrecondition for one that has nothing to retry.
  absl::Status RetryJob(int64_t study, int64_t job, std::string_view reason,
                        std::string_view actor);
  // Ends back-offs that are due. Errors: those of JobMoves::Settle.
  absl::Status Wake();

 private:
  // Returns the study, if its failed jobs may be retried. Errors: those of Retry.
  absl::StatusOr<Study*> FindRetryable(int64_t study);
  // Retries a job that has ended in vain. Errors: those of RetryJob.
  absl::Status RetryLost(const JobRow& job);
  absl::StatusOr<bool> RetryOfScene(Variant& variant, const JobRow& job);
  absl::StatusOr<bool> RetryOther(Variant& variant, const JobRow& job);

  Tables& tables_;
  JobMoves& jobs_;
  Waiters& waiters_;
  WorkLimits& limits_;
};

}  // namespace parallax
