// Ends leases: by results, failures and losses.
#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"

namespace parallax {
namespace {

constexpr size_t kMostGivenUp = 10'000;  // Workers whose last leases are remembered.

std::string AttemptFolder(const JobRow& job) {
  return fmt::format("{}/.attempt-{}", StorePrefixOf(job.work_key), job.fence);
}

}  // namespace

// Returns the job and whether the attempt holds it or, if not, the outcome to answer.
absl::StatusOr<Machine::Holding> Machine::HoldingOf(const v1::AttemptId& attempt) {
  Holding holding;
  holding.outcome = v1::REPORT_OUTCOME_STALE_FENCE;
  ASSIGN_OR_RETURN(std::optional<JobRow> job, store_.Find(attempt.job_id()));
  if (!job) {
    ASSIGN_OR_RETURN(job, store_.FindArchived(attempt.job_id()));
  }
  const bool any_fence =
      options_.unsafe_for_test.ignore_fences && job && job->state == JobState::kLeased;
  if (job && (any_fence || job->fence == attempt.fence()) && attempt.fence() != 0) {
    switch (job->state) {
      case JobState::kLeased:
        holding.outcome = v1::REPORT_OUTCOME_OK;
        break;
      case JobState::kSucceeded:
      case JobState::kRejected:
        holding.outcome = v1::REPORT_OUTCOME_ALREADY_DONE;
        break;
      case JobState::kCancelled:
        holding.outcome = v1::REPORT_OUTCOME_CANCELLED;
        break;
      default:
        break;
    }
  }
  if (job) holding.job = *std::move(job);
  if (holding.outcome == v1::REPORT_OUTCOME_STALE_FENCE) ++effects_.stale;
  return holding;
}

// ---- Results ------------------------------------------------------------------------------------
absl::StatusOr<Machine::Verdict> Machine::Complete(const CheckedReport& report) {
  ASSIGN_OR_RETURN(const Holding holding, HoldingOf(report.attempt));
  Verdict verdict{holding.outcome, ""};
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
  ++effects_.completions;
  return verdict;
}

// A report in another's name, although it knows the fence.
std::string Machine::WhyNotHolder(const JobRow& job, const std::string& worker) const {
  if (worker.empty() || worker == job.worker || options_.unsafe_for_test.ignore_fences) return "";
  return fmt::format("job {}: attempt {} reported by {}, but {} holds its lease", job.id,
                     job.attempts, worker, job.worker);
}

absl::StatusOr<std::string> Machine::WhyNotOf(const JobRow& job, const CheckedReport& report) {
  if (!report.invalid.empty()) return report.invalid;
  const JobKind& kind = KindOf(job);
  if (*report.kind != job.kind) {
    return "a " + kinds_[*report.kind].name() + " result for a " + kind.name() + " job";
  }
  const std::string folder = AttemptFolder(job) + "/";
  for (const std::string& path : report.result->paths) {
    if (!kind.traits().has_output || (path + "/").compare(0, folder.size(), folder) != 0) {
      return "a result at '" + path + "', wanted a folder under '" + folder + "'";
    }
  }
  return kind.WhyNot(*this, job, *report.result);
}

absl::Status Machine::StoreResult(const JobRow& job, const CheckedReport& report) {
  const JobKind& kind = KindOf(job);
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  ending_fence_ = job.fence;
  auto stored = kind.Store(*this, job, *report.result);
  ending_fence_ = 0;
  ASSIGN_OR_RETURN(const Ending ending, std::move(stored));
  const JobState end = ending.rejected ? JobState::kRejected : JobState::kSucceeded;
  RETURN_IF_ERROR(store_.MoveToResult(job.id, job.fence, end, OneLine(ending.reason), Now()));
  NoteMove(*variant, job, end);
  --leased_now_;
  effects_.ended.push_back({.job = job.id, .fence = job.fence, .worker = job.worker});
  if (job.part_given) ++ledger_.Change(*variant).layouts_reused;
  RETURN_IF_ERROR(ending.rejected ? EnterLoss(job, *variant, end)
                                  : EnterSuccess(job, *variant, ending, /*by_own_attempt=*/true));
  return ReleaseFollowers(job.id);
}

// ---- Failures and losses ------------------------------------------------------------------------
absl::StatusOr<v1::ReportOutcome> Machine::Fail(const v1::FailRequest& request) {
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
  ASSIGN_OR_RETURN(const bool known,
                   losses_.Has(request.attempt().job_id(), request.attempt().fence(), "app"));
  return known ? v1::REPORT_OUTCOME_ALREADY_DONE : holding.outcome;
}

absl::Status Machine::FailAttempt(const JobRow& job, const AppFailure& failure) {
  // If its input has been taken back meanwhile, the job is not at fault.
  ASSIGN_OR_RETURN(const bool complete, HasWhatItWaitedFor(job));
  if (!complete) return LoseAttempt(job, LossKind::kReturned, failure.error, false, Now());
  const std::string worker = failure.worker.empty() ? job.worker : failure.worker;
  const std::string error = OneLine(failure.error);
  const std::string fingerprint =
      OneLine(failure.fingerprint.empty() ? failure.error : failure.fingerprint);
  RETURN_IF_ERROR(losses_.Insert({.job = job.id,
                                  .fence = job.fence,
                                  .ledger = "app",
                                  .worker = worker,
                                  .fingerprint = fingerprint,
                                  .error = error,
                                  .unix_s = Now(),
                                  .log_tail = failure.log_tail}));
  RETURN_IF_ERROR(Litter(job));
  ++effects_.failures;

  FailureHistory history{.app_failures = job.app_failures + 1, .retryable = failure.retryable};
  ASSIGN_OR_RETURN(history.workers_with_fingerprint,
                   losses_.WorkersWithFingerprint(job.id, fingerprint));
  LossUpdate update{
      .app_failures = history.app_failures, .infra_losses = job.infra_losses, .error = error};
  switch (JudgeAppFailure(options_.retry, history)) {
    case FailureVerdict::kRetryNow:
      update.state = JobState::kReady;
      break;
    case FailureVerdict::kRetryLater: {
      Rng rng(SceneSeed{job.fence}, "queue/backoff");
      update.state = JobState::kRetryWait;
      update.not_before_unix_s =
          Now() + BackoffSeconds(options_.retry, history.app_failures, rng.Uniform());
      break;
    }
    case FailureVerdict::kFail:
      update.state = JobState::kFailed;
      break;
    case FailureVerdict::kQuarantine:
      update.state = JobState::kQuarantined;
      break;
  }
  effects_.ended.push_back(
      {.job = job.id,
       .fence = job.fence,
       .worker = job.worker,
       .end = IsTerminal(update.state) ? LeaseEnd::kOver : LeaseEnd::kGivenBack,
       .progress = ProgressOf(job)});
  return EndAttempt(job, update);
}

absl::Status Machine::LoseAttempt(const JobRow& job, LossKind kind, const std::string& reason,
                                  bool stop, double now) {
  const std::string error = OneLine(reason);
  RETURN_IF_ERROR(losses_.Insert({.job = job.id,
                                  .fence = job.fence,
                                  .ledger = kind == LossKind::kLost ? "lost" : "returned",
                                  .worker = job.worker,
                                  .error = error,
                                  .unix_s = now}));
  RETURN_IF_ERROR(Litter(job));
  LossUpdate update{.state = JobState::kReady,
                    .app_failures = job.app_failures,
                    .infra_losses = job.infra_losses,
                    .error = error};
  const double progress = ProgressOf(job);
  LeaseEnd end = LeaseEnd::kGivenBack;
  if (kind == LossKind::kLost) {
    ++effects_.losses;
    ++update.infra_losses;
    ASSIGN_OR_RETURN(const bool to_blame, IsToBlame(job, progress, now));
    end = to_blame ? LeaseEnd::kOver : LeaseEnd::kLost;
    if (to_blame) {
      update.state = JobState::kQuarantined;
      update.error += fmt::format(
          "; it is the job: {} workers were lost with it while others lived", update.infra_losses);
    }
  }
  effects_.ended.push_back(
      {job.id, job.fence, job.worker, stop, reason, end, MachineOf(job.worker), progress});
  return EndAttempt(job, update);
}

// How far its attempt has come, if a later one goes on from there.
double Machine::ProgressOf(const JobRow& job) const {
  return KindOf(job).traits().resumes && progress_of_ ? progress_of_(job.id) : 0;
}

std::string Machine::MachineOf(const std::string& worker) const {
  const auto known = workers_.find(worker);
  return known == workers_.end() || known->second.machine.empty() ? worker : known->second.machine;
}

int Machine::Machines() const {
  std::set<std::string> machines;
  for (const auto& [name, memory] : workers_) machines.insert(MachineOf(name));
  return static_cast<int>(machines.size());
}

absl::StatusOr<bool> Machine::IsToBlame(const JobRow& job, double progress, double now) {
  evidence_.Pass(SteadySeconds(), workers_.size());
  LossHistory history = evidence_.HistoryOf(job.id, job.fence, effects_.workers_lost,
                                            MachineOf(job.worker), progress);
  if (history.losses == 0) return false;
  history.machines_all = Machines();
  if (JudgeLoss(options_.retry, history) != FailureVerdict::kQuarantine) return false;
  ASSIGN_OR_RETURN(history.with_another, losses_.AlwaysLostWithAnother(job.id, job.worker, now));
  return JudgeLoss(options_.retry, history) == FailureVerdict::kQuarantine;
}

absl::Status Machine::EndAttempt(const JobRow& job, const LossUpdate& update) {
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  RETURN_IF_ERROR(store_.MoveAfterLoss(job, update, Now()));
  NoteMove(*variant, job, update.state);
  --leased_now_;
  if (update.state == JobState::kReady) effects_.work_ready = true;
  if (IsTerminal(update.state)) RETURN_IF_ERROR(EnterLoss(job, *variant, update.state));
  return ReleaseFollowers(job.id);
}

absl::Status Machine::Litter(const JobRow& job) {
  const JobTraits& traits = KindOf(job).traits();
  if (!traits.has_output) return absl::OkStatus();
  if (!traits.resumes) return folders_.InsertLitter(AttemptFolder(job), Now());
  std::optional<KeptFor> scene;
  if (traits.of_scene) scene = KeptFor{job.variant, job.ordinal};
  ASSIGN_OR_RETURN(const Sha256Digest keep_key, KindOf(job).KeepKey(*this, job));
  return folders_.Keep(AttemptFolder(job), keep_key, scene, Now());
}

// A worker that was away for long may have written after its folder was
// removed.
absl::Status Machine::LitterOfLate(const JobRow& job, const CheckedReport& report) {
  if (report.result == nullptr || report.result->paths.empty()) return absl::OkStatus();
  if (!kinds_[*report.kind].traits().has_output) return absl::OkStatus();
  ASSIGN_OR_RETURN(const bool lost, losses_.WasLost(job.id, report.attempt.fence()));
  if (!lost) return absl::OkStatus();
  // Its own folder, whatever rigs the job had then: no other attempt has this fence.
  const std::string path = report.result->paths.front() + "/";
  const std::string own = fmt::format("/.attempt-{}", report.attempt.fence());
  const size_t at = path.find(own + "/");
  if (at != StorePrefixOf(Sha256Digest{}).size()) return absl::OkStatus();
  const std::string folder = path.substr(0, at + own.size());
  ASSIGN_OR_RETURN(const bool kept, folders_.IsKept(folder));  // Others may go on from it.
  return kept ? absl::OkStatus() : folders_.InsertLitter(folder, Now());
}

absl::StatusOr<v1::ReportOutcome> Machine::HandBack(const std::string& worker,
                                                    const v1::AttemptId& attempt,
                                                    std::string_view reason) {
  ASSIGN_OR_RETURN(const Holding holding, HoldingOf(attempt));
  if (holding.outcome == v1::REPORT_OUTCOME_OK) {
    RETURN_IF_ERROR(LoseAttempt(holding.job, LossKind::kReturned,
                                "handed back by " + worker + ": " + std::string(reason), false,
                                Now()));
    return v1::REPORT_OUTCOME_OK;
  }
  ASSIGN_OR_RETURN(const bool known, losses_.Has(attempt.job_id(), attempt.fence(), "returned"));
  return known ? v1::REPORT_OUTCOME_ALREADY_DONE : holding.outcome;
}

absl::StatusOr<std::vector<v1::AttemptId>> Machine::Adopt(const std::string& worker,
                                                          const std::vector<v1::AttemptId>& holding,
                                                          bool same_process) {
  std::vector<v1::AttemptId> adopted;
  if (const auto given_up = given_up_.find(worker); given_up != given_up_.end()) {
    // The worker was only away: none of its jobs has killed it.
    for (const auto& [job, fence] : given_up->second) {
      if (!same_process) break;
      RETURN_IF_ERROR(losses_.MoveLostToReturned(job, fence));
      evidence_.TakeBack(job, fence);
    }
    given_up_.erase(given_up);
  }
  const double now = Now();
  bool counted = false;
  ASSIGN_OR_RETURN(const std::vector<int64_t> leased, store_.LeasedBy(worker));
  for (const int64_t id : leased) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
    const auto known = std::find_if(holding.begin(), holding.end(), [&](const v1::AttemptId& a) {
      return a.job_id() == id && a.fence() == job.fence;
    });
    if (known != holding.end()) {
      adopted.push_back(*known);
    } else {
      // Lost workers may speak against a job; lost messages do not. Who was leased to before the
      // last restart may be the same process: nobody knows.
      const bool arrived = !same_process && job.fence >> 32 == epoch_;
      if (arrived && !std::exchange(counted, true)) ++effects_.workers_lost;
      RETURN_IF_ERROR(arrived
                          ? LoseAttempt(job, LossKind::kLost,
                                        "worker " + worker + " came back without it", false, now)
                          : LoseAttempt(job, LossKind::kReturned,
                                        "the lease did not reach worker " + worker, false, now));
    }
  }
  workers_[worker].seen_s = SteadySeconds();
  return adopted;
}

absl::StatusOr<int> Machine::WorkerLost(const std::string& worker) {
  const double now = Now();
  if (given_up_.size() > kMostGivenUp) given_up_.clear();  // Most have gone for good.
  ASSIGN_OR_RETURN(const std::vector<int64_t> leased, store_.LeasedBy(worker));
  if (!leased.empty() || workers_.count(worker) > 0) ++effects_.workers_lost;
  for (const int64_t id : leased) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
    RETURN_IF_ERROR(LoseAttempt(job, LossKind::kLost, "worker " + worker + " was lost", true, now));
    given_up_[worker].emplace_back(id, job.fence);
  }
  workers_.erase(worker);
  return static_cast<int>(leased.size());
}

absl::StatusOr<int> Machine::WorkerLeft(const std::string& worker) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> leased, store_.LeasedBy(worker));
  for (const int64_t id : leased) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
    RETURN_IF_ERROR(LoseAttempt(job, LossKind::kReturned, "worker " + worker + " drained and left",
                                true, Now()));
  }
  workers_.erase(worker);
  return static_cast<int>(leased.size());
}

absl::Status Machine::Expire(const std::vector<LeaseRef>& leases) {
  const double now = Now();
  std::set<std::string> lost;
  for (const LeaseRef& lease : leases) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.Find(lease.job));
    if (!job || job->state != JobState::kLeased || job->fence != lease.fence) continue;
    if (lost.insert(lease.worker).second) ++effects_.workers_lost;
    RETURN_IF_ERROR(LoseAttempt(*job, LossKind::kLost,
                                "worker " + lease.worker + " was not heard of for a whole lease",
                                true, now));
    given_up_[lease.worker].emplace_back(lease.job, lease.fence);
  }
  return absl::OkStatus();
}

absl::Status Machine::WakeRetries() {
  ASSIGN_OR_RETURN(const std::vector<int64_t> due,
                   store_.BackoffsDue(Now(), options_.retry.backoff_max_s, 10'000));
  for (const int64_t id : due) RETURN_IF_ERROR(SettleJob(id));
  return absl::OkStatus();
}

}  // namespace parallax
