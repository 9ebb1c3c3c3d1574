// Jobs that wait for other jobs or for a variant's pairs: what an end means for them.
#include <fmt/core.h>

#include <limits>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"

namespace parallax {

// Returns whether a wait is met, open or in vain, as seen within this command.
absl::StatusOr<Machine::Outlook> Machine::OutlookOf(const JobWait& wait) {
  if (wait.on_job != 0) {
    const std::string name = fmt::format("job {}", wait.on_job);
    ASSIGN_OR_RETURN(std::optional<JobRow> job, store_.Find(wait.on_job));
    if (!job) {
      ASSIGN_OR_RETURN(job, store_.FindArchived(wait.on_job));
    }
    if (!job) return Internal("a wait on {}: no such", name);
    if (job->state == JobState::kSucceeded) return Outlook{Prospect::kMet, ""};
    if (!IsTerminal(job->state)) return Outlook{Prospect::kOpen, ""};
    return Outlook{Prospect::kVain, name + ", which it waits for, is " + NameOf(job->state)};
  }
  ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(wait.on_variant));
  ASSIGN_OR_RETURN(const Study* study, ledger_.FindStudy(variant->study));
  const std::string name = "variant " + variant->name + " of study " + study->name;
  if (wait.pairs < 1 || wait.pairs > variant->pairs_wanted) {
    return InvalidArgument("a wait for {} pairs of {}, which is to have {}", wait.pairs, name,
                           variant->pairs_wanted);
  }
  if (variant->tally.pairs_done >= wait.pairs) return Outlook{Prospect::kMet, ""};
  if (study->tally.cancelled) {
    return Outlook{Prospect::kVain, name + ", whose pairs it waits for, is cancelled"};
  }
  if (!variant->tally.problem.empty()) {
    return Outlook{Prospect::kVain, name + ", whose pairs it waits for, gave up"};
  }
  return Outlook{Prospect::kOpen, ""};
}

absl::StatusOr<std::vector<const char*>> Machine::PlanWaits(const std::vector<JobWait>& waits,
                                                            JobRow& job) {
  std::vector<const char*> states;
  std::string vain;
  for (const JobWait& wait : waits) {
    ASSIGN_OR_RETURN(const Outlook outlook, OutlookOf(wait));
    if (outlook.prospect == Prospect::kOpen) ++job.waits_open;
    if (outlook.prospect == Prospect::kVain && vain.empty()) vain = outlook.why;
    states.push_back(outlook.prospect == Prospect::kMet    ? "MET"
                     : outlook.prospect == Prospect::kOpen ? "OPEN"
                                                           : "DROPPED");
  }
  if (!vain.empty()) {
    job.state = JobState::kCancelled;
    job.error = OneLine(vain);
    job.waits_open = job.awaits_job = 0;
    for (const char*& state : states) state = "DROPPED";
  } else if (job.waits_open > 0) {
    job.state = JobState::kBlocked;
    job.awaits_job = 0;
  }
  return states;
}

absl::Status Machine::SettleWaiters() {
  // Settling one may end others.
  while (!ended_jobs_.empty() || !changed_variants_.empty()) {
    if (!ended_jobs_.empty()) {
      const auto [id, state] = ended_jobs_.back();
      ended_jobs_.pop_back();
      ASSIGN_OR_RETURN(const std::vector<int64_t> waiters, waits_.OnJob(id));
      if (waiters.empty()) continue;
      if (state != JobState::kSucceeded) {
        RETURN_IF_ERROR(CancelWaiters(
            waiters, fmt::format("job {}, which it waits for, is {}", id, NameOf(state))));
        continue;
      }
      RETURN_IF_ERROR(waits_.MeetJob(id));
      for (const int64_t waiter : waiters) RETURN_IF_ERROR(Release(waiter));
      continue;
    }
    const int64_t id = *changed_variants_.begin();
    changed_variants_.erase(changed_variants_.begin());
    constexpr int64_t kAny = std::numeric_limits<int64_t>::max();
    ASSIGN_OR_RETURN(std::vector<int64_t> waiters, waits_.OnPairs(id, kAny));
    if (waiters.empty()) continue;
    ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(id));
    ASSIGN_OR_RETURN(waiters, waits_.OnPairs(id, variant->tally.pairs_done));
    if (!waiters.empty()) {
      RETURN_IF_ERROR(waits_.MeetPairs(id, variant->tally.pairs_done));
      for (const int64_t waiter : waiters) RETURN_IF_ERROR(Release(waiter));
    }
    ASSIGN_OR_RETURN(const Outlook rest, OutlookOf(JobWait::OnPairs(id, variant->pairs_wanted)));
    if (rest.prospect != Prospect::kVain) continue;
    ASSIGN_OR_RETURN(waiters, waits_.OnPairs(id, kAny));
    RETURN_IF_ERROR(CancelWaiters(waiters, rest.why));
  }
  return absl::OkStatus();
}

absl::Status Machine::Release(int64_t waiter) {
  ASSIGN_OR_RETURN(const int64_t open, waits_.OpenOf(waiter));
  return open > 0 ? store_.SetWaitsOpen(waiter, open) : SettleJob(waiter, /*waits_met=*/true);
}

absl::Status Machine::CancelWaiters(const std::vector<int64_t>& waiters, const std::string& why) {
  for (const int64_t id : waiters) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.Find(id));
    if (job && !IsTerminal(job->state)) RETURN_IF_ERROR(CancelJob(*job, OneLine(why)));
  }
  return absl::OkStatus();
}

}  // namespace parallax
