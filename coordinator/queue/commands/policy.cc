#include "coordinator/queue/commands/policy.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace parallax {

double BackoffSeconds(const RetryPolicy& policy, int failures, double uniform) {
  const double high =
      std::min(policy.backoff_max_s, policy.backoff_min_s * std::pow(4.0, std::max(failures, 0)));
  return policy.backoff_min_s + uniform * std::max(0.0, high - policy.backoff_min_s);
}

FailureVerdict JudgeAppFailure(const RetryPolicy& policy, const FailureHistory& history) {
  if (history.workers_with_fingerprint >= policy.quarantine_workers) {
    return FailureVerdict::kQuarantine;
  }
  if (!history.retryable || history.app_failures >= policy.max_app_failures) {
    return FailureVerdict::kFail;
  }
  return FailureVerdict::kRetryLater;
}

bool SaysOutOfMemory(std::string_view fingerprint) {
  const auto says = [&](const char* words) { return fingerprint.find(words) != fingerprint.npos; };
  // The second line: renderer and layout (worker/render, CheckMemory).
  const bool memory = says("out of memory") || says("memory is exhausted") ||
                      says("not fit in memory") || says("not enough memory") ||
                      says("MB in use; the limit is") || says("structure needs more than");
  return memory && !says("CUDA") && !says("GPU");
}

int64_t MoreMemory(int64_t had_mb, int64_t largest_mb) {
  const int64_t more_mb = std::min(had_mb + had_mb / 2, largest_mb);
  return more_mb > had_mb ? more_mb : 0;
}

double ChanceOfLosses(const LossHistory& history) {
  if (history.losses <= 0 || history.all <= 0) return 1;
  const double all = static_cast<double>(std::max<int64_t>(history.all, history.losses));
  const double seen = history.losses / all;
  const double expected = std::clamp(history.share, 1e-9, 1.0);
  if (seen <= expected) return 1;
  double divergence = seen * std::log(seen / expected);
  if (seen < 1) divergence += (1 - seen) * std::log((1 - seen) / (1 - expected));
  return std::exp(-all * divergence);
}

FailureVerdict JudgeLoss(const RetryPolicy& policy, const LossHistory& history) {
  const int machines = std::min(policy.quarantine_machines, std::max(1, history.machines_all));
  const bool blame = history.machines >= machines && !history.with_another &&
                     ChanceOfLosses(history) < policy.most_chance;
  return blame ? FailureVerdict::kQuarantine : FailureVerdict::kRetryNow;
}

bool Fits(const StudyShare& study, const WorkerCapacity& worker) {
  if (worker.memory_mb < study.needs_memory_mb) return false;
  return std::all_of(study.needs_tags.begin(), study.needs_tags.end(), [&](const std::string& tag) {
    return std::find(worker.tags.begin(), worker.tags.end(), tag) != worker.tags.end();
  });
}

std::vector<int64_t> OrderStudies(std::span<const StudyShare> studies,
                                  const WorkerCapacity& worker) {
  std::vector<const StudyShare*> open;
  for (const StudyShare& study : studies) {
    if (study.open && Fits(study, worker)) open.push_back(&study);
  }
  const auto rank = [](const StudyShare* s) {
    const double aged = s->priority + std::floor(std::max(0.0, s->waiting_s) / kAgeingStepS);
    return std::make_tuple(-aged, s->pass, s->study);
  };
  std::sort(open.begin(), open.end(),
            [&](const StudyShare* a, const StudyShare* b) { return rank(a) < rank(b); });
  std::vector<int64_t> ids;
  ids.reserve(open.size());
  for (const StudyShare* study : open) ids.push_back(study->study);
  return ids;
}

uint32_t PartsToSplitInto(const SplitFacts& facts) {
  const int64_t ready = std::max<int64_t>(1, facts.ready_jobs);
  const int64_t idle = std::max<int64_t>(0, facts.idle_slots - facts.ready_others);
  const int64_t soon = facts.only_these_left ? facts.slots : 0;
  const int64_t parts = std::max((idle + ready - 1) / ready, soon / ready);
  return static_cast<uint32_t>(std::clamp<int64_t>(parts, 1, std::max(1u, facts.rigs)));
}

int PickJob(std::span<const JobCandidate> candidates, const std::string& worker,
            bool other_workers) {
  int own = -1;  // The first that this worker failed or lost last.
  for (size_t i = 0; i < candidates.size(); ++i) {
    const JobCandidate& candidate = candidates[i];
    const int at = static_cast<int>(i);
    if (candidate.last_worker != worker) return at;
    if (own < 0 && (!other_workers || candidate.ready_s >= kElsewhereS)) own = at;
  }
  return own;
}

}  // namespace parallax
