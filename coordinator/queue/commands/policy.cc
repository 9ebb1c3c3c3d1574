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

FailureVerdict JudgeLoss(const RetryPolicy& policy, const FailureHistory& history) {
  const bool to_blame = !history.lost_without_it && !history.lost_with_another;
  if ((history.workers_lost >= policy.quarantine_losses && to_blame) ||
      history.infra_losses >= policy.max_infra_losses) {
    return FailureVerdict::kQuarantine;
  }
  return FailureVerdict::kRetryNow;
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
  for (size_t i = 0; i < candidates.size(); ++i) {
    const JobCandidate& candidate = candidates[i];
    const bool leave =
        other_workers && candidate.last_worker == worker && candidate.ready_s < kElsewhereS;
    if (!leave) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace parallax
