// The queue's decisions: which study is served next, which job a worker gets, and what a failure
// leads to. Pure functions of snapshots: they use no clock, no database and no state; everything
// that they depend on is an argument.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace parallax {

// When a failed or lost job is retried, and when it is given up.
struct RetryPolicy {
  int max_app_failures = 3;   // A job is FAILED at this failure.
  int max_infra_losses = 10;  // A job is quarantined at this loss.
  // A job is quarantined when this many different workers report the same failure (fingerprint).
  int quarantine_workers = 2;
  // A job is quarantined when this many different workers were lost while they held it, and none
  // was lost without it meanwhile.
  int quarantine_losses = 3;
  double backoff_min_s = 5;
  double backoff_max_s = 600;
};

// Returns the seconds to wait after the app failure number `failures` (from 1). `uniform`, in [0,
// 1), spreads it over [backoff_min_s, min(backoff_max_s, backoff_min_s * 4^failures)], so that jobs
// that failed together don't return together.
double BackoffSeconds(const RetryPolicy& policy, int failures, double uniform);

// A job's record after a failure or loss was entered in its ledgers.
struct FailureHistory {
  int app_failures = 0;
  int infra_losses = 0;
  int workers_with_fingerprint = 0;  // Different workers that reported this failure's fingerprint.
  int workers_lost = 0;              // Different workers lost while they held the job.
  bool lost_without_it = false;      // A worker without the job was lost since the first of them.
  bool lost_with_another = false;    // All of them also held the same other job.
  bool retryable = true;
};
// The verdict on a job after an app failure or the loss of its worker.
//
// Losses never make a job FAILED, because a lost worker alone does not prove a fault of the job. A
// job that keeps losing its workers is quarantined, and sooner if no other job loses workers
// meanwhile: where machines are killed all the time, three lost workers prove nothing about a job.
// Two jobs that were always lost together must be leased apart before one of them is blamed.
enum class FailureVerdict { kRetryLater, kRetryNow, kFail, kQuarantine };
FailureVerdict JudgeAppFailure(const RetryPolicy& policy, const FailureHistory& history);
FailureVerdict JudgeLoss(const RetryPolicy& policy, const FailureHistory& history);

// ---- Which study ------------------------------------------------------------------------------
struct StudyShare {
  int64_t study = 0;
  int priority = 0;
  double pass = 0;       // Stride scheduling: grows by 1 / weight with each job served.
  double waiting_s = 0;  // Time with READY jobs since it was last served.
  bool open = true;      // Neither paused nor cancelled nor finished.
  int64_t needs_memory_mb = 0;
  std::span<const std::string> needs_tags;
};
struct WorkerCapacity {
  int64_t memory_mb = 0;
  std::span<const std::string> tags;
};

// Returns whether the worker has all the tags and the memory that the study needs.
bool Fits(const StudyShare& study, const WorkerCapacity& worker);

// Returns the ids of the studies that the worker may serve, the best first: by priority, which
// grows by one for each `kAgeingStepS` of waiting so that no study starves; then by pass, so that
// studies of equal priority share equally; then by id.
inline constexpr double kAgeingStepS = 300;
std::vector<int64_t> OrderStudies(std::span<const StudyShare> studies,
                                  const WorkerCapacity& worker);

// ---- Whether to split it
struct SplitFacts {
  uint32_t rigs = 0;             // Rigs of the job that is about to be leased.
  int64_t ready_jobs = 0;        // READY jobs of its kind, this one included.
  int64_t ready_others = 0;      // Other READY jobs that idle workers could do instead.
  int idle_slots = 0;            // Idle slots, the one that asks included.
  int slots = 0;                 // All slots of the farm.
  bool only_these_left = false;  // No other job will become READY.
};
// Returns the number of parts to split the job into; 1 leaves it whole. While more work will come,
// only slots that are idle now count. If these are the last jobs, all slots count, because they
// will be idle soon: so all workers share the end of a study instead of waiting for it.
uint32_t PartsToSplitInto(const SplitFacts& facts);

// ---- Which job of it --------------------------------------------------------------------------
struct JobCandidate {
  int64_t job = 0;
  std::string last_worker;  // Worker of its last failure or loss; empty for none.
  double ready_s = 0;       // Seconds that it has been READY.
};
// Returns the index of the first candidate that `worker` should take; -1 for none. A job that this
// worker failed or lost last is left to other workers while there are any, but for at most
// kElsewhereS seconds.
inline constexpr double kElsewhereS = 30;
int PickJob(std::span<const JobCandidate> candidates, const std::string& worker,
            bool other_workers);

}  // namespace parallax
