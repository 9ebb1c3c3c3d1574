// Ends leases: by results, failures and losses of workers. Used by the writing thread only.
// Errors of all functions: those of the database; kInternal for a mistake in the program.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/commands/loss_evidence.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/moves/scheduler.h"

namespace parallax {

// The answer to a reported result.
struct ReportVerdict {
  v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;
  // Why the result does not belong to the job, for which the attempt has failed; else empty.
  std::string invalid;
};

class Reports {
 public:
  // All arguments must outlive the object.
  Reports(Tables& tables, JobMoves& jobs, Waiters& waiters, Scheduler& scheduler)
      : tables_(tables), jobs_(jobs), waiters_(waiters), scheduler_(scheduler) {}

  // Sets the function that says how far a leased job has come, in a measure that grows; 0 if nobody
  // knows. By default nobody does.
  void SetProgress(std::function<double(int64_t job)> progress_of) {
    progress_of_ = std::move(progress_of);
  }

  // The commands of JobQueue, which documents them.
  absl::StatusOr<ReportVerdict> Complete(const CheckedReport& report);
  // Errors: kInvalidArgument if another worker holds the lease.
  absl::StatusOr<v1::ReportOutcome> Fail(const v1::FailRequest& request);
  absl::StatusOr<v1::ReportOutcome> HandBack(const std::string& worker,
                                             const v1::AttemptId& attempt, std::string_view reason);
  absl::StatusOr<std::vector<v1::AttemptId>> Adopt(const std::string& worker,
                                                   const std::vector<v1::AttemptId>& holding,
                                                   bool same_process);
  absl::StatusOr<int> WorkerLost(const std::string& worker);
  absl::StatusOr<int> WorkerLeft(const std::string& worker);
  // Ends leases that an earlier start gave, when the stages of the jobs had other versions: what
  // comes of them would be taken for results of these versions.
  absl::Status EndEarlier(const std::vector<int64_t>& jobs);
  // Ends leases that were not heard of in time.
  absl::Status Expire(const std::vector<LeaseRef>& leases);

  // Takes the leases that have begun or ended as evidence about jobs that lose their workers.
  void TakeEvidence(const Effects& effects);

 private:
  struct Holding {
    JobRow job;
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;  // OK if the attempt holds the job.
  };
  absl::StatusOr<Holding> HoldingOf(const v1::AttemptId& attempt);
  absl::Status StoreResult(const JobRow& job, const CheckedReport& report);
  absl::StatusOr<std::string> WhyNotOf(const JobRow& job, const CheckedReport& report);
  std::string WhyNotHolder(const JobRow& job, const std::string& worker) const;
  struct AppFailure {
    std::string worker, error, fingerprint;
    bool retryable = true;
    std::string log_tail;
  };
  // What becomes of a job that ran out of memory.
  struct MemoryRaise {
    int64_t needs_mb = 0;  // Its need from now on; 0: as before.
    std::string said;      // For its error.
  };
  absl::StatusOr<MemoryRaise> RaiseMemory(const JobRow& job, const std::string& worker);
  absl::Status FailAttempt(const JobRow& job, const AppFailure& failure);
  enum class LossKind { kLost, kReturned };
  // Returns whether the job is to blame for the loss of its worker.
  absl::StatusOr<bool> IsToBlame(const JobRow& job, double progress, double now);
  double ProgressOf(const JobRow& job) const;
  // `now` must be the same for all attempts that a worker loses at one time.
  absl::Status LoseAttempt(const JobRow& job, LossKind kind, const std::string& reason, bool stop,
                           double now);
  // Ends all leases of a worker that is gone.
  absl::StatusOr<int> LoseAll(const std::string& worker, LossKind kind, const std::string& reason);
  absl::Status EndAttempt(const JobRow& job, const LossUpdate& update);
  absl::Status LitterOfLate(const JobRow& job, const CheckedReport& report);

  Tables& tables_;
  JobMoves& jobs_;
  Waiters& waiters_;
  Scheduler& scheduler_;
  LossEvidence evidence_;
  std::function<double(int64_t job)> progress_of_;
  // Jobs and fences of workers that were given up, by worker. Forgotten at a restart, so it is only
  // a guess, which may spare jobs a loss.
  std::map<std::string, std::vector<std::pair<int64_t, uint64_t>>> given_up_;
  std::set<uint64_t> adopted_;  // Fences, in the group that is being committed.
};

}  // namespace parallax
