// The queue's decisions: which study is served next, which job a worker gets, and what a failure
// leads to. Pure functions of snapshots: they use no clock, no database and no state; everything
// that they depend on is an argument.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parallax {

// When a failed or lost job is retried, and when it is given up.
struct RetryPolicy {
  int max_app_failures = 3;  // A job is FAILED at this failure.
  // A job is quarantined when this many different workers report the same failure (fingerprint).
  int quarantine_workers = 2;
  // A job is quarantined when workers were lost with it on this many different machines (on all, if
  // the farm has fewer), and chance loses so many with one job less often than `most_chance`.
  int quarantine_machines = 3;
  double most_chance = 1e-5;
  double backoff_min_s = 5;
  double backoff_max_s = 600;
};

// Returns the seconds to wait after the app failure number `failures` (from 1). `uniform`, in [0,
// 1), spreads it over [backoff_min_s, min(backoff_max_s, backoff_min_s * 4^failures)], so that jobs
// that failed together don't return together.
double BackoffSeconds(const RetryPolicy& policy, int failures, double uniform);

// A job's record after a reported failure was entered in its ledger.
struct FailureHistory {
  int app_failures = 0;
  int workers_with_fingerprint = 0;  // Different workers that reported this failure's fingerprint.
  bool retryable = true;
};
enum class FailureVerdict { kRetryLater, kRetryNow, kFail, kQuarantine };
FailureVerdict JudgeAppFailure(const RetryPolicy& policy, const FailureHistory& history);

// Returns whether a failure with this fingerprint is for lack of the machine's memory. A GPU's is
// another one, which no worker's memory helps.
bool SaysOutOfMemory(std::string_view fingerprint);
// Returns the memory in MB to ask for after a job had too little with `had_mb`: half as much again,
// but at most `largest_mb`, what a worker has; 0 if no worker has more.
int64_t MoreMemory(int64_t had_mb, int64_t largest_mb);

// A job that has lost its worker, among the workers that the farm has lost since the job first did.
// That first loss is why the job is looked at, so it is in none of the numbers but `machines`.
struct LossHistory {
  int losses = 0;             // Workers that were lost while they held the job.
  int64_t all = 0;            // Workers that were lost, with the job or without it.
  double share = 1;           // The part of all living workers' time in which they held the job.
  int machines = 0;           // Different machines of the workers that were lost with the job.
  int machines_all = 0;       // Machines of the farm.
  bool with_another = false;  // Each of these workers also held the same other job.
};
// Returns an upper bound of the chance that `losses` or more of `all` losses, each of which hits a
// worker at random, fall on workers that hold the job; 1 if no more of them do than its share.
// Source: Chernoff's bound of the binomial distribution's tail.
double ChanceOfLosses(const LossHistory& history);
// The verdict on a job that has lost its worker: kRetryNow or kQuarantine.
//
// A lost worker proves nothing about its job: machines are stopped, moved and switched off. A job
// is blamed only if it is the job that kills: it loses worker after worker while those without it
// live. Where machines are killed all the time, or where there is one worker that does nothing but
// this job, it is never blamed. Two jobs that were always lost together must be leased apart before
// one of them is.
FailureVerdict JudgeLoss(const RetryPolicy& policy, const LossHistory& history);

// ---- Which study
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

// ---- Which job of it
struct JobCandidate {
  int64_t job = 0;
  std::string last_worker;  // Worker of its last failure or loss; empty for none.
  double ready_s = 0;       // Seconds that it has been READY.
};
// Returns the index of the candidate that `worker` should take; -1 for none. A job that this worker
// failed or lost last is left to other workers while there are any, but for at most kElsewhereS
// seconds; where there are none, it comes after the other candidates, which then show whether the
// worker or the job is at fault.
inline constexpr double kElsewhereS = 30;
int PickJob(std::span<const JobCandidate> candidates, const std::string& worker,
            bool other_workers);

}  // namespace parallax
