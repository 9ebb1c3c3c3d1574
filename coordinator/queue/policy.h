// The queue's decisions as pure functions over snapshots: which study is served next, which job a
// worker gets, what a failure leads to. No clock, no database, no state: what they depend on comes
// in.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace parallax {

struct RetryPolicy {
  int max_app_failures = 3;    // The failure that makes a job FAILED.
  int max_infra_losses = 10;   // The loss that quarantines it.
  int quarantine_workers = 2;  // As many workers with one fingerprint quarantine a job.
  int quarantine_losses = 3;  // As many different workers lost while they held it and none without.
  double backoff_min_s = 5;
  double backoff_max_s = 600;
};

// Seconds to wait after the `failures`-th (from 1) app failure: `uniform` in [0, 1) spreads it over
// [backoff_min_s, min(backoff_max_s, backoff_min_s * 4^failures)] so that jobs that failed together
// don't return together.
double BackoffSeconds(const RetryPolicy& policy, int failures, double uniform);

// What a job's ledgers say after a failure or loss was entered.
struct FailureHistory {
  int app_failures = 0;
  int infra_losses = 0;
  int workers_with_fingerprint = 0;  // Different workers that reported this failure's fingerprint.
  int workers_lost = 0;              // Different workers lost while they held the job.
  bool lost_without_it = false;      // And since the first of them one that did not hold it.
  bool lost_with_another = false;    // And all of them held the same other job too.
  bool retryable = true;
};
// Losses never fail a job: the work did nothing wrong. One that keeps losing its workers is
// quarantined; sooner if it is the only one that does. Two that went from worker to worker together
// must part before one is blamed. Where machines are killed all the time, three of them say nothing
// about a job.
enum class FailureVerdict { kRetryLater, kRetryNow, kFail, kQuarantine };
FailureVerdict JudgeAppFailure(const RetryPolicy& policy, const FailureHistory& history);
FailureVerdict JudgeLoss(const RetryPolicy& policy, const FailureHistory& history);

// ---- Which study ------------------------------------------------------------------------------
struct StudyShare {
  int64_t study = 0;
  int priority = 0;
  double pass = 0;       // Stride scheduling: grows by 1 / weight with each job served.
  double waiting_s = 0;  // Since it was last served while it had READY jobs.
  bool open = true;      // Neither paused nor cancelled nor finished.
  int64_t needs_memory_mb = 0;
  std::span<const std::string> needs_tags;
};
struct WorkerCapacity {
  int64_t memory_mb = 0;
  std::span<const std::string> tags;
};

// True if the worker has all tags and the memory asked for.
bool Fits(const StudyShare& study, const WorkerCapacity& worker);

// Ids of the studies that the worker may serve, best first: by priority, aged by one for each
// `kAgeingStepS` of waiting, so that nothing starves; then by pass, so that equals share equally;
// then by id.
inline constexpr double kAgeingStepS = 300;
std::vector<int64_t> OrderStudies(std::span<const StudyShare> studies,
                                  const WorkerCapacity& worker);

// ---- Whether to split it
struct SplitFacts {
  uint32_t rigs = 0;             // Of the job that is about to be leased.
  int64_t ready_jobs = 0;        // Of its kind, this one included.
  int64_t ready_others = 0;      // That the idle workers could do instead.
  int idle_slots = 0;            // The one that asks included.
  int slots = 0;                 // All of the farm.
  bool only_these_left = false;  // Nothing else will become READY.
};
// In how many parts; 1: leave it whole. While more work will come, only slots
// that idle now count. When these jobs are the last, every slot will idle
// soon: so the end of a study is shared by all, rather than waited for.
uint32_t PartsToSplitInto(const SplitFacts& facts);

// ---- Which job of it --------------------------------------------------------------------------
struct JobCandidate {
  int64_t job = 0;
  std::string last_worker;  // Who had it when it failed or was lost; empty for none.
  double ready_s = 0;       // How long it has been READY.
};
// Index of the candidate (in the order given) that `worker` should take, -1 for none. One that this
// worker has just failed or lost is left to others while there are others, but not for longer than
// kElsewhereS.
inline constexpr double kElsewhereS = 30;
int PickJob(std::span<const JobCandidate> candidates, const std::string& worker,
            bool other_workers);

}  // namespace parallax
