#include "coordinator/queue/commands/reports.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "common/base/rng.h"
#include "common/base/status.h"

namespace parallax {
namespace {

constexpr size_t kMostGivenUp = 10'000;  // Workers whose last leases are remembered.

}  // namespace

// Returns the job and whether the attempt holds it or, if not, the outcome to answer.
absl::StatusOr<Reports::Holding> Reports::HoldingOf(const v1::AttemptId& attempt) {
  Holding holding;
  holding.outcome = v1::REPORT_OUTCOME_STALE_FENCE;
  ASSIGN_OR_RETURN(std::optional<JobRow> job, tables_.jobs.Find(attempt.job_id()));
  if (!job) {
    ASSIGN_OR_RETURN(job, tables_.jobs.FindArchived(attempt.job_id()));
  }
  const bool any_fence =
      tables_.options.unsafe_for_test.ignore_fences && job && job->state == JobState::kLeased;
  if (job && (any_fence || job->fence == attempt.fence()) && attempt.fence() != 0) {
    if (job->state == JobState::kLeased) holding.outcome = v1::REPORT_OUTCOME_OK;
    if (job->state == JobState::kCancelled) holding.outcome = v1::REPORT_OUTCOME_CANCELLED;
    if (job->state == JobState::kSucceeded || job->state == JobState::kRejected) {
      holding.outcome = v1::REPORT_OUTCOME_ALREADY_DONE;
    }
  }
  if (job) holding.job = *std::move(job);
  if (holding.outcome == v1::REPORT_OUTCOME_STALE_FENCE) ++tables_.effects.stale;
  return holding;
}

// ---- Results
absl::StatusOr<ReportVerdict> Reports::Complete(const CheckedReport& report) {
  ASSIGN_OR_RETURN(const Holding holding, HoldingOf(report.attempt));
  ReportVerdict verdict{holding.outcome, ""};
  if (holding.outcome == v1::REPORT_OUTCOME_STALE_FENCE) {
    RETURN_IF_ERROR(LitterOfLate(holding.job, report));
  }
  if (holding.outcome != v1::REPORT_OUTCOME_OK) return verdict;
  const JobRow& job = holding.job;
  verdict.invalid = WhyNotHolder(job, report.worker);
  if (!verdict.invalid.empty()) return verdict;  // And the holder goes on.
  ASSIGN_OR_RETURN(verdict.invalid, WhyNotOf(job, report));
  if (!verdict.invalid.empty()) {
    verdict.invalid = fmt::format("job {}: {}", job.id, verdict.invalid);
    // Workers without their disk do not agree by that about the job.
    const std::string fingerprint =
        report.of_store ? "files of " + report.worker : "invalid-result";
    RETURN_IF_ERROR(
        FailAttempt(job, {report.worker, "invalid result: " + verdict.invalid, fingerprint, true}));
    return verdict;
  }
  RETURN_IF_ERROR(StoreResult(job, report));
  ++tables_.effects.completions;
  return verdict;
}

// A report in another's name, although it knows the fence.
std::string Reports::WhyNotHolder(const JobRow& job, const std::string& worker) const {
  if (worker.empty() || worker == job.worker || tables_.options.unsafe_for_test.ignore_fences)
    return "";
  return fmt::format("job {}: attempt {} reported by {}, but {} holds its lease", job.id,
                     job.attempts, worker, job.worker);
}

absl::StatusOr<std::string> Reports::WhyNotOf(const JobRow& job, const CheckedReport& report) {
  if (!report.invalid.empty()) return report.invalid;
  const JobKind& kind = tables_.kinds[job.kind];
  if (*report.kind != job.kind) {
    return "a " + tables_.kinds[*report.kind].name() + " result for a " + kind.name() + " job";
  }
  const std::string folder = AttemptFolder(job) + "/";
  for (const std::string& path : report.result->paths) {
    if (!kind.traits().has_output || (path + "/").compare(0, folder.size(), folder) != 0) {
      return "a result at '" + path + "', wanted a folder under '" + folder + "'";
    }
  }
  return kind.WhyNot(jobs_.desk(), job, *report.result);
}

absl::Status Reports::StoreResult(const JobRow& job, const CheckedReport& report) {
  const JobKind& kind = tables_.kinds[job.kind];
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  tables_.ending_fence = job.fence;
  auto stored = kind.Store(jobs_.desk(), job, *report.result);
  tables_.ending_fence = 0;
  ASSIGN_OR_RETURN(const Ending ending, std::move(stored));
  const JobState end = ending.rejected ? JobState::kRejected : JobState::kSucceeded;
  RETURN_IF_ERROR(
      tables_.jobs.MoveToResult(job.id, job.fence, end, OneLine(ending.reason), tables_.Now()));
  tables_.NoteMove(*variant, job, end);
  --tables_.leased_now;
  tables_.effects.ended.push_back({.job = job.id, .fence = job.fence, .worker = job.worker});
  if (job.part_given) ++tables_.ledger.Change(*variant).layouts_reused;
  RETURN_IF_ERROR(ending.rejected
                      ? jobs_.EnterLoss(job, *variant, end)
                      : jobs_.EnterSuccess(job, *variant, ending, /*by_own_attempt=*/true));
  return jobs_.ReleaseFollowers(job.id);
}

// ---- Failures and losses
absl::StatusOr<v1::ReportOutcome> Reports::Fail(const v1::FailRequest& request) {
  ASSIGN_OR_RETURN(const Holding holding, HoldingOf(request.attempt()));
  if (holding.outcome == v1::REPORT_OUTCOME_OK) {
    if (std::string why = WhyNotHolder(holding.job, request.worker()); !why.empty()) {
      return InvalidArgument("{}", why);
    }
    RETURN_IF_ERROR(
        FailAttempt(holding.job, {request.worker(), request.error(), request.fingerprint(),
                                  request.retryable(), LogTail(request.log_tail())}));
    return v1::REPORT_OUTCOME_OK;
  }
  ASSIGN_OR_RETURN(const bool known, tables_.losses.Has(request.attempt().job_id(),
                                                        request.attempt().fence(), "app"));
  return known ? v1::REPORT_OUTCOME_ALREADY_DONE : holding.outcome;
}

absl::StatusOr<Reports::MemoryRaise> Reports::RaiseMemory(const JobRow& job,
                                                          const std::string& worker) {
  const JobKind& kind = tables_.kinds[job.kind];
  ASSIGN_OR_RETURN(const Study* study, tables_.ledger.FindStudy(job.study));
  const ReadyKey key = ReadyKeyOf(job.study, {study->needs_memory_mb, study->needs_tags}, kind,
                                  kind.NeedsOf(job.input));
  const int64_t had_mb = key.memory_mb > 0 ? key.memory_mb : scheduler_.MemoryOf(worker);
  const int64_t largest_mb = scheduler_.LargestMemory(key);
  const int64_t needs_mb = MoreMemory(had_mb, largest_mb);
  const std::string input = kind.WithMemory(job.input, needs_mb);
  if (input.empty() || had_mb == 0 || largest_mb == 0) return MemoryRaise();
  if (needs_mb == 0) {
    return MemoryRaise{0, fmt::format("; no worker for it has more than {} MB", largest_mb)};
  }
  RETURN_IF_ERROR(tables_.jobs.SetInput(job.id, input));
  return MemoryRaise{needs_mb, fmt::format("; it needs a worker with {} MB now", needs_mb)};
}

absl::Status Reports::FailAttempt(const JobRow& job, const AppFailure& failure) {
  // If its input has been taken back meanwhile, the job is not at fault.
  ASSIGN_OR_RETURN(const bool complete, waiters_.HasWhatItWaitedFor(job));
  if (!complete) return LoseAttempt(job, LossKind::kReturned, failure.error, false, tables_.Now());
  const std::string worker = failure.worker.empty() ? job.worker : failure.worker;
  std::string error = OneLine(failure.error);
  std::string fingerprint =
      OneLine(failure.fingerprint.empty() ? failure.error : failure.fingerprint);
  if (failure.retryable && SaysOutOfMemory(fingerprint)) {
    ASSIGN_OR_RETURN(const MemoryRaise raise, RaiseMemory(job, worker));
    error += raise.said;
    // Workers that had less do not agree by that about the job.
    if (raise.needs_mb > 0) fingerprint += fmt::format("; with less than {} MB", raise.needs_mb);
  }
  RETURN_IF_ERROR(tables_.losses.Insert({.job = job.id,
                                         .fence = job.fence,
                                         .ledger = "app",
                                         .worker = worker,
                                         .fingerprint = fingerprint,
                                         .error = error,
                                         .unix_s = tables_.Now(),
                                         .log_tail = failure.log_tail}));
  RETURN_IF_ERROR(jobs_.Litter(job));
  ++tables_.effects.failures;

  FailureHistory history{.app_failures = job.app_failures + 1, .retryable = failure.retryable};
  ASSIGN_OR_RETURN(history.workers_with_fingerprint,
                   tables_.losses.WorkersWithFingerprint(job.id, fingerprint));
  LossUpdate update{
      .app_failures = history.app_failures, .infra_losses = job.infra_losses, .error = error};
  const FailureVerdict verdict = JudgeAppFailure(tables_.options.retry, history);
  if (verdict == FailureVerdict::kRetryLater) {
    Rng rng(SceneSeed{job.fence}, "queue/backoff");
    update.state = JobState::kRetryWait;
    update.not_before_unix_s =
        tables_.Now() + BackoffSeconds(tables_.options.retry, history.app_failures, rng.Uniform());
  } else if (verdict != FailureVerdict::kRetryNow) {
    update.state = verdict == FailureVerdict::kFail ? JobState::kFailed : JobState::kQuarantined;
  }
  tables_.effects.ended.push_back(
      {.job = job.id,
       .fence = job.fence,
       .worker = job.worker,
       .end = IsTerminal(update.state) ? LeaseEnd::kOver : LeaseEnd::kGivenBack,
       .progress = ProgressOf(job)});
  return EndAttempt(job, update);
}

absl::Status Reports::LoseAttempt(const JobRow& job, LossKind kind, const std::string& reason,
                                  bool stop, double now) {
  const std::string error = OneLine(reason);
  RETURN_IF_ERROR(tables_.losses.Insert({.job = job.id,
                                         .fence = job.fence,
                                         .ledger = kind == LossKind::kLost ? "lost" : "returned",
                                         .worker = job.worker,
                                         .error = error,
                                         .unix_s = now}));
  RETURN_IF_ERROR(jobs_.Litter(job));
  LossUpdate update{.state = JobState::kReady,
                    .app_failures = job.app_failures,
                    .infra_losses = job.infra_losses,
                    .error = error};
  const double progress = ProgressOf(job);
  LeaseEnd end = LeaseEnd::kGivenBack;
  if (kind == LossKind::kLost) {
    ++tables_.effects.losses;
    ++update.infra_losses;
    ASSIGN_OR_RETURN(const bool to_blame, IsToBlame(job, progress, now));
    end = to_blame ? LeaseEnd::kOver : LeaseEnd::kLost;
    if (to_blame) {
      update.state = JobState::kQuarantined;
      update.error += fmt::format(
          "; it is the job: {} workers were lost with it while others lived", update.infra_losses);
    }
  }
  tables_.effects.ended.push_back({job.id, job.fence, job.worker, stop, reason, end,
                                   scheduler_.MachineOf(job.worker), progress});
  return EndAttempt(job, update);
}

// How far its attempt has come, if a later one goes on from there.
double Reports::ProgressOf(const JobRow& job) const {
  return tables_.kinds[job.kind].traits().resumes && progress_of_ ? progress_of_(job.id) : 0;
}

absl::StatusOr<bool> Reports::IsToBlame(const JobRow& job, double progress, double now) {
  evidence_.Pass(tables_.SteadySeconds(), scheduler_.workers());
  LossHistory history = evidence_.HistoryOf(job.id, job.fence, tables_.effects.workers_lost,
                                            scheduler_.MachineOf(job.worker), progress);
  if (history.losses == 0) return false;
  history.machines_all = scheduler_.Machines();
  if (JudgeLoss(tables_.options.retry, history) != FailureVerdict::kQuarantine) return false;
  ASSIGN_OR_RETURN(history.with_another,
                   tables_.losses.AlwaysLostWithAnother(job.id, job.worker, now));
  return JudgeLoss(tables_.options.retry, history) == FailureVerdict::kQuarantine;
}

absl::Status Reports::EndAttempt(const JobRow& job, const LossUpdate& update) {
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  RETURN_IF_ERROR(tables_.jobs.MoveAfterLoss(job, update, tables_.Now()));
  tables_.NoteMove(*variant, job, update.state);
  --tables_.leased_now;
  if (update.state == JobState::kReady) tables_.effects.work_ready = true;
  if (IsTerminal(update.state)) {
    const double now = tables_.Now();
    RETURN_IF_ERROR(jobs_.EnterLoss(job, *variant, update.state));
    RETURN_IF_ERROR(tables_.notices.Raise(job.study, kNoticeFailed, now,
                                          now + tables_.options.notice_gather_s));
  }
  return jobs_.ReleaseFollowers(job.id);
}

// A worker that was away for long may have written after its folder was
// removed.
absl::Status Reports::LitterOfLate(const JobRow& job, const CheckedReport& report) {
  if (report.result == nullptr || report.result->paths.empty()) return absl::OkStatus();
  if (!tables_.kinds[*report.kind].traits().has_output) return absl::OkStatus();
  ASSIGN_OR_RETURN(const bool lost, tables_.losses.WasLost(job.id, report.attempt.fence()));
  if (!lost) return absl::OkStatus();
  // Its own folder, whatever rigs the job had then: no other attempt has this fence.
  const std::string path = report.result->paths.front() + "/";
  const std::string own = fmt::format("/.attempt-{}", report.attempt.fence());
  const size_t at = path.find(own + "/");
  if (at != StorePrefixOf(Sha256Digest{}).size()) return absl::OkStatus();
  const std::string folder = path.substr(0, at + own.size());
  ASSIGN_OR_RETURN(const bool kept, tables_.folders.IsKept(folder));  // Others may go on from it.
  return kept ? absl::OkStatus() : tables_.folders.InsertLitter(folder, tables_.Now());
}

absl::StatusOr<v1::ReportOutcome> Reports::HandBack(const std::string& worker,
                                                    const v1::AttemptId& attempt,
                                                    std::string_view reason) {
  ASSIGN_OR_RETURN(const Holding holding, HoldingOf(attempt));
  if (holding.outcome == v1::REPORT_OUTCOME_OK) {
    RETURN_IF_ERROR(LoseAttempt(holding.job, LossKind::kReturned,
                                "handed back by " + worker + ": " + std::string(reason), false,
                                tables_.Now()));
    return v1::REPORT_OUTCOME_OK;
  }
  ASSIGN_OR_RETURN(const bool known,
                   tables_.losses.Has(attempt.job_id(), attempt.fence(), "returned"));
  return known ? v1::REPORT_OUTCOME_ALREADY_DONE : holding.outcome;
}

absl::StatusOr<std::vector<v1::AttemptId>> Reports::Adopt(const std::string& worker,
                                                          const std::vector<v1::AttemptId>& holding,
                                                          bool same_process) {
  std::vector<v1::AttemptId> adopted;
  if (const auto given_up = given_up_.find(worker); given_up != given_up_.end()) {
    // The worker was only away: none of its jobs has killed it.
    for (const auto& [job, fence] : given_up->second) {
      if (!same_process) break;
      RETURN_IF_ERROR(tables_.losses.MoveLostToReturned(job, fence));
      evidence_.TakeBack(job, fence);
    }
    tables_.effects.came_back.push_back(worker);
  }
  RETURN_IF_ERROR(tables_.db.Run("DELETE FROM unheard_workers WHERE worker = ?1", worker));
  const double now = tables_.Now();
  bool counted = false;
  ASSIGN_OR_RETURN(const std::vector<int64_t> leased, tables_.jobs.LeasedBy(worker));
  for (const int64_t id : leased) {
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(id));
    const auto known = std::find_if(holding.begin(), holding.end(), [&](const v1::AttemptId& a) {
      return a.job_id() == id && a.fence() == job.fence;
    });
    if (known != holding.end() && !tables_.options.unsafe_for_test.adopt_nothing) {
      adopted.push_back(*known);
      adopted_.insert(known->fence());
    } else {
      // Lost workers may speak against a job; lost messages do not. Who was leased to before the
      // last restart may be the same process: nobody knows.
      const bool arrived = !same_process && job.fence >> 32 == tables_.epoch;
      if (arrived && !std::exchange(counted, true)) ++tables_.effects.workers_lost;
      RETURN_IF_ERROR(arrived
                          ? LoseAttempt(job, LossKind::kLost,
                                        "worker " + worker + " came back without it", false, now)
                          : LoseAttempt(job, LossKind::kReturned,
                                        "the lease did not reach worker " + worker, false, now));
    }
  }
  scheduler_.NoteSeen(worker);
  return adopted;
}

absl::StatusOr<int> Reports::WorkerLost(const std::string& worker) {
  if (given_up_.size() > kMostGivenUp) given_up_.clear();  // Most have gone for good.
  return LoseAll(worker, LossKind::kLost, "worker " + worker + " was lost");
}

absl::StatusOr<int> Reports::WorkerLeft(const std::string& worker) {
  return LoseAll(worker, LossKind::kReturned, "worker " + worker + " drained and left");
}

absl::Status Reports::EndEarlier(const std::vector<int64_t>& jobs) {
  for (const int64_t id : jobs) {
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(id));
    RETURN_IF_ERROR(LoseAttempt(job, LossKind::kReturned,
                                "the coordinator has other versions of its stages", true,
                                tables_.Now()));
  }
  return absl::OkStatus();
}

absl::StatusOr<int> Reports::LoseAll(const std::string& worker, LossKind kind,
                                     const std::string& reason) {
  const double now = tables_.Now();
  ASSIGN_OR_RETURN(const std::vector<int64_t> leased, tables_.jobs.LeasedBy(worker));
  const bool lost = kind == LossKind::kLost;
  if (lost && (!leased.empty() || scheduler_.Knows(worker))) ++tables_.effects.workers_lost;
  for (const int64_t id : leased) {
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(id));
    RETURN_IF_ERROR(LoseAttempt(job, kind, reason, true, now));
    if (lost) given_up_[worker].emplace_back(id, job.fence);
  }
  scheduler_.NoteGone(worker);
  return static_cast<int>(leased.size());
}

absl::Status Reports::Expire(const std::vector<LeaseRef>& leases) {
  const double now = tables_.Now();
  std::set<std::string> lost;
  for (const LeaseRef& lease : leases) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, tables_.jobs.Find(lease.job));
    if (!job || job->state != JobState::kLeased || job->fence != lease.fence) continue;
    if (adopted_.count(lease.fence) > 0) continue;  // By a hello of the same group.
    if (lost.insert(lease.worker).second) ++tables_.effects.workers_lost;
    RETURN_IF_ERROR(LoseAttempt(*job, LossKind::kLost,
                                "worker " + lease.worker + " was not heard of for a whole lease",
                                true, now));
    given_up_[lease.worker].emplace_back(lease.job, lease.fence);
  }
  return absl::OkStatus();
}

void Reports::TakeEvidence(const Effects& effects) {
  adopted_.clear();
  for (const std::string& worker : effects.came_back) given_up_.erase(worker);
  evidence_.Pass(tables_.SteadySeconds(), scheduler_.workers());
  for (const LeaseRef& lease : effects.granted) evidence_.Begin(lease.job, lease.fence);
  for (const LeaseRef& lease : effects.ended) {
    evidence_.End(lease.job, lease.fence, lease.end, lease.machine, lease.progress);
  }
  evidence_.CountLost(effects.workers_lost);
}

}  // namespace parallax
