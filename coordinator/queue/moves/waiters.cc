#include "coordinator/queue/moves/waiters.h"

#include <fmt/core.h>

#include <limits>

#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/moves/job_moves.h"

namespace parallax {

absl::StatusOr<Waiters::Outlook> Waiters::OutlookOf(const JobWait& wait) {
  if (wait.on_job != 0) {
    const std::string name = fmt::format("job {}", wait.on_job);
    ASSIGN_OR_RETURN(std::optional<JobRow> job, tables_.jobs.Find(wait.on_job));
    if (!job) {
      ASSIGN_OR_RETURN(job, tables_.jobs.FindArchived(wait.on_job));
    }
    if (!job) return Internal("a wait on {}: no such", name);
    if (job->state == JobState::kSucceeded) return Outlook{Prospect::kMet, ""};
    if (!IsTerminal(job->state)) return Outlook{Prospect::kOpen, ""};
    return Outlook{Prospect::kVain, name + ", which it waits for, is " + NameOf(job->state)};
  }
  ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(wait.on_variant));
  ASSIGN_OR_RETURN(const Study* study, tables_.ledger.FindStudy(variant->study));
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

absl::StatusOr<std::vector<const char*>> Waiters::Plan(const std::vector<JobWait>& waits,
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

absl::StatusOr<std::vector<JobWait>> Waiters::WaitsAgain(const JobRow& job) {
  ASSIGN_OR_RETURN(std::vector<JobWait> waits, tables_.waits.Of(job.id));
  if (waits.empty()) waits = tables_.kinds[job.kind].WaitsOf(job.input);
  for (JobWait& wait : waits) {
    if (wait.on_job == 0) continue;
    ASSIGN_OR_RETURN(const std::optional<JobRow> newest, tables_.jobs.FindNewest(wait.on_job));
    if (newest) wait.on_job = newest->id;
  }
  return waits;
}

absl::StatusOr<bool> Waiters::HasWhatItWaitedFor(const JobRow& job) {
  if (tables_.kinds[job.kind].traits().of_scene) return true;
  ASSIGN_OR_RETURN(const std::vector<JobWait> waits, tables_.waits.Of(job.id));
  for (const JobWait& wait : waits) {
    if (wait.on_job == 0) {
      ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(wait.on_variant));
      if (variant->tally.pairs_done < wait.pairs) return false;
      continue;
    }
    ASSIGN_OR_RETURN(const std::optional<JobRow> awaited, tables_.jobs.FindNewest(wait.on_job));
    if (!awaited || !tables_.kinds[awaited->kind].traits().has_output) continue;
    ASSIGN_OR_RETURN(const bool has, tables_.results.Has(awaited->work_key));
    if (!has) return false;
  }
  return true;
}

absl::Status Waiters::Settle(JobMoves& jobs) {
  // Settling one may end others.
  while (!tables_.ended_jobs.empty() || !tables_.changed_variants.empty()) {
    if (!tables_.ended_jobs.empty()) {
      const auto [id, state] = tables_.ended_jobs.back();
      tables_.ended_jobs.pop_back();
      ASSIGN_OR_RETURN(const std::vector<int64_t> waiters, tables_.waits.OnJob(id));
      if (waiters.empty()) continue;
      if (state != JobState::kSucceeded) {
        const auto why = fmt::format("job {}, which it waits for, is {}", id, NameOf(state));
        RETURN_IF_ERROR(Cancel(waiters, why, jobs));
        continue;
      }
      RETURN_IF_ERROR(tables_.waits.MeetJob(id));
      RETURN_IF_ERROR(Release(waiters, jobs));
      continue;
    }
    const int64_t id = *tables_.changed_variants.begin();
    tables_.changed_variants.erase(tables_.changed_variants.begin());
    constexpr int64_t kAny = std::numeric_limits<int64_t>::max();
    ASSIGN_OR_RETURN(std::vector<int64_t> waiters, tables_.waits.OnPairs(id, kAny));
    if (waiters.empty()) continue;
    ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(id));
    ASSIGN_OR_RETURN(waiters, tables_.waits.OnPairs(id, variant->tally.pairs_done));
    if (!waiters.empty()) {
      RETURN_IF_ERROR(tables_.waits.MeetPairs(id, variant->tally.pairs_done));
      RETURN_IF_ERROR(Release(waiters, jobs));
    }
    ASSIGN_OR_RETURN(const Outlook rest, OutlookOf(JobWait::OnPairs(id, variant->pairs_wanted)));
    if (rest.prospect != Prospect::kVain) continue;
    ASSIGN_OR_RETURN(waiters, tables_.waits.OnPairs(id, kAny));
    RETURN_IF_ERROR(Cancel(waiters, rest.why, jobs));
  }
  return absl::OkStatus();
}

absl::Status Waiters::Release(const std::vector<int64_t>& waiters, JobMoves& jobs) {
  if (tables_.options.unsafe_for_test.keep_waiters) return absl::OkStatus();
  for (const int64_t id : waiters) {
    ASSIGN_OR_RETURN(const int64_t open, tables_.waits.OpenOf(id));
    RETURN_IF_ERROR(open > 0 ? tables_.jobs.SetWaitsOpen(id, open)
                             : jobs.Settle(id, /*waits_met=*/true));
  }
  return absl::OkStatus();
}

absl::Status Waiters::Cancel(const std::vector<int64_t>& waiters, const std::string& why,
                             JobMoves& jobs) {
  for (const int64_t id : waiters) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, tables_.jobs.Find(id));
    if (job && !IsTerminal(job->state)) RETURN_IF_ERROR(jobs.Cancel(*job, OneLine(why)));
  }
  return absl::OkStatus();
}

}  // namespace parallax
