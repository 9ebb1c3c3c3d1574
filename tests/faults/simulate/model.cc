#include "tests/faults/simulate/model.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/config/training_plan.h"

namespace parallax::faults {
namespace {

constexpr size_t kMostComplaints = 20;

void EraseOne(auto& set, const auto& value) {
  if (const auto found = set.find(value); found != set.end()) set.erase(found);
}

bool Has(const std::vector<v1::AttemptId>& attempts, int64_t job, uint64_t fence) {
  return std::any_of(attempts.begin(), attempts.end(), [&](const v1::AttemptId& attempt) {
    return attempt.job_id() == job && attempt.fence() == fence;
  });
}

}  // namespace

double QueueModel::SecondsOf(SteadyTime time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

void QueueModel::Complain(const std::string& what) {
  if (complaints_.size() < kMostComplaints) complaints_.push_back(what);
}

void QueueModel::Expect(const absl::Status& status, const std::string& what) {
  const std::string line(status.message());
  const bool of_disk = (files_changed_ && absl::IsDataLoss(status)) ||
                       absl::IsUnavailable(status) || absl::IsResourceExhausted(status) ||
                       absl::IsFailedPrecondition(status);
  const bool is_clear =
      !line.empty() && line.find('\n') == std::string::npos &&
      (line.find("database") != std::string::npos || line.find("checkpoint") != std::string::npos);
  if (!options_.disk_lies || !of_disk || !is_clear) Complain(what + ": " + status.ToString());
}

std::string QueueModel::Name(int64_t job, const Job& row) const {
  return fmt::format("{} job {} of study {} (attempt {:x} of {})", row.kind, job, row.study,
                     row.fence, row.worker);
}

// ---- The coordinator's life
void QueueModel::Starts() {
  const double now = clock_.UnixSeconds();
  for (auto& [name, worker] : workers_) {
    worker.unheard_unix_s = std::min(worker.unheard_unix_s.value_or(now), now);
  }
}

void QueueModel::Started(uint64_t epoch, int release) {
  if (epoch <= epoch_) Complain(fmt::format("epoch {:x} comes after {:x}", epoch, epoch_));
  epoch_ = epoch;
  // Pictures of another release are not wanted.
  for (auto& [id, job] : jobs_) {
    if (release != release_ && job.kind == "render") job.in_doubt = true;
  }
  release_ = release;
  // A lease counts as heard of at the first start that its worker has said nothing to.
  for (auto& [id, job] : jobs_) {
    const double since = workers_[job.worker].unheard_unix_s.value_or(clock_.UnixSeconds());
    job.heard_s = Now() - (clock_.UnixSeconds() - since);
  }
  for (auto& [name, worker] : workers_) {
    worker = {.heard_s = 1e18,  // Nobody waits for its hello.
              .drained_s = worker.drained_s,
              .unheard_unix_s = worker.unheard_unix_s};
  }
}

void QueueModel::Died() {
  for (const auto& [id, fence] : reporting_) {
    accepted_.insert(fence);
    const auto job = jobs_.find(id);
    if (job != jobs_.end() && job->second.fence == fence) job->second.in_doubt = true;
  }
  for (auto& [id, job] : jobs_) job.in_doubt |= job.state == Job::kHeld && IsExcused(job);
  for (const int64_t id : ordering_) studies_[id].in_doubt = true;
  reporting_.clear();
  joining_.clear();
  ordering_.clear();
}

void QueueModel::Rewind(const QueueModel& then) {
  QueueModel copy(then);
  copy.Died();  // Commands that were under way are in the backup or not.
  studies_ = std::move(copy.studies_);
  study_of_name_ = std::move(copy.study_of_name_);
  jobs_ = std::move(copy.jobs_);
  workers_ = std::move(copy.workers_);
  accepted_ = std::move(copy.accepted_);
}

// ---- Clients
void QueueModel::SubmitEnds(const v1::StudySpec& spec, int64_t id) {
  const auto [known, is_new] = studies_.try_emplace(id);
  if (!is_new && known->second.name != spec.name()) {
    Complain(fmt::format("study {} is {} and was {}", id, spec.name(), known->second.name));
  }
  const auto named = study_of_name_.try_emplace(spec.name(), id).first;
  // 0: its jobs were leased before it was answered. A forgotten study's key is free again.
  if (named->second != 0 && named->second != id) {
    const Study& former = studies_[named->second];
    if (!former.forgotten && !former.in_doubt) {
      Complain(fmt::format("{} was submitted twice: {} and {}", spec.name(), named->second, id));
    }
  }
  named->second = id;
  known->second.name = spec.name();
  known->second.pairs = spec.pairs();
}

void QueueModel::OrderBegins(int64_t study) {
  studies_[study].order_s = Now();
  ordering_.insert(study);
}

void QueueModel::OrderFails(int64_t study) { EraseOne(ordering_, study); }

void QueueModel::OrderEnds(int64_t id, Order order) {
  EraseOne(ordering_, id);
  Study& study = studies_[id];
  study.order_s = Now();
  study.cancelled |= order == Order::kCancel;
  study.forgotten |= order == Order::kForget;
  if (order == Order::kPause) study.paused = true;
  if (order == Order::kResume) study.paused = false;
}

void QueueModel::LimitEnds(int64_t id, int64_t max_running) {
  EraseOne(ordering_, id);
  studies_[id].max_running = max_running;
  studies_[id].order_s = Now();
}

void QueueModel::DrainEnds(const std::string& worker, bool undo) {
  workers_[worker].drained_s = undo ? 1e18 : Now();
}

// ---- Workers
bool QueueModel::IsExcused(const Job& job) {
  const Worker& worker = workers_[job.worker];
  const Study& study = studies_[job.study];
  const double slack_s = options_.slack_s;
  return job.in_doubt || study.cancelled || study.in_doubt || ordering_.count(job.study) > 0 ||
         worker.left || joining_.count(job.worker) > 0 ||
         Now() - job.heard_s >= options_.lease_s - slack_s ||
         Now() - worker.heard_s >= options_.lease_s - slack_s ||
         Now() - worker.gone_s >= options_.grace_s - slack_s;
}

void QueueModel::JoinBegins(const std::string& worker) { joining_.insert(worker); }

void QueueModel::JoinFails(const std::string& worker) { EraseOne(joining_, worker); }

void QueueModel::JoinEnds(const std::string& name, const void* stream,
                          const std::vector<v1::AttemptId>& holding,
                          const std::vector<v1::AttemptId>& adopted) {
  for (auto& [id, job] : jobs_) {
    if (job.worker != name || job.state != Job::kHeld) continue;
    const bool is_adopted = Has(adopted, id, job.fence);
    EraseOne(joining_, name);
    if (!is_adopted && Has(holding, id, job.fence) && !IsExcused(job)) {
      Complain(Name(id, job) + " was still running and is not adopted");
    }
    joining_.insert(name);
    if (is_adopted) {
      job.heard_s = Now();
      job.in_doubt = false;
    } else {
      job.state = Job::kOpen;
    }
  }
  EraseOne(joining_, name);
  for (const v1::AttemptId& attempt : adopted) {
    const auto job = jobs_.find(attempt.job_id());
    if (job == jobs_.end() || job->second.fence != attempt.fence() || job->second.worker != name ||
        job->second.state != Job::kHeld) {
      Complain(fmt::format("job {} is adopted under a fence that {} does not hold",
                           attempt.job_id(), name));
    }
  }
  workers_[name] = {.heard_s = Now(), .stream = stream, .drained_s = workers_[name].drained_s};
}

void QueueModel::Heard(const std::string& name, const std::vector<v1::AttemptId>& running,
                       bool draining) {
  workers_[name].heard_s = Now();
  workers_[name].draining = draining;
  for (const v1::AttemptId& attempt : running) {
    const auto job = jobs_.find(attempt.job_id());
    if (job == jobs_.end() || job->second.fence != attempt.fence()) continue;
    if (job->second.worker == name && !job->second.taken) job->second.heard_s = Now();
  }
}

void QueueModel::StreamEnds(const std::string& name, const void* stream) {
  Worker& worker = workers_[name];
  if (worker.stream != stream) return;
  worker.gone_s = std::min(worker.gone_s, Now());
  worker.left = worker.draining;
}

void QueueModel::LeaseGiven(const std::string& name, const v1::Lease& lease,
                            const JobQueue& queue) {
  const uint64_t fence = lease.attempt().fence();
  Job& job = jobs_[lease.attempt().job_id()];
  const int64_t id = lease.attempt().job_id();
  const bool knew = job.fence != 0;
  if (!fences_.insert(fence).second) {
    Complain(fmt::format("fence {:x} of job {} comes twice", fence, id));
  }
  if (fence >> 32 != epoch_) Complain(fmt::format("fence {:x} in epoch {:x}", fence, epoch_));
  if (knew && !job.in_doubt && job.state == Job::kDone) {
    Complain(Name(id, job) + " was done, and is leased again");
  }
  if (knew && !job.in_doubt && job.state == Job::kHeld) {
    Complain(Name(id, job) + " is held, and is leased again to " + name);
  }
  // Unknown if the coordinator died before it could answer the submission: study 0.
  const int64_t study_id = study_of_name_[lease.study()];
  const Study& study = studies_[study_id];
  const bool settled = !study.in_doubt && Now() - study.order_s > options_.slack_s;
  job = {.state = Job::kHeld,
         .study = study_id,
         .kind = lease.kind(),
         .fence = fence,
         .worker = name,
         .heard_s = Now()};
  // Its spec says how many pairs were there.
  const size_t of = lease.spec().rfind(" of ");
  if (options_.pairs_stay && lease.kind() == "noop" && lease.variant() != kHeldoutName &&
      std::stoll(lease.spec().substr(of + 4)) < study.pairs) {
    Complain(Name(id, job) + " begins before the pairs that it waits for: " + lease.spec());
  }
  if (settled && (study.cancelled || study.forgotten)) {
    Complain(Name(id, job) + " is leased, although its study was cancelled");
  }
  if (settled && study.paused) {
    Complain(Name(id, job) + " is leased, although its study is paused");
  }
  if (Now() - workers_[name].drained_s > options_.slack_s) {
    Complain(Name(id, job) + " is leased to a worker that is drained");
  }
  if (settled) CheckLimit(study_id, study.max_running, queue);
  CheckLimit(/*study=*/-1, options_.user_running, queue);
}

void QueueModel::CheckLimit(int64_t id, int64_t limit, const JobQueue& queue) {
  if (limit == 0) return;
  int64_t running = 0;
  for (const auto& [job_id, job] : jobs_) {
    v1::AttemptId attempt;
    attempt.set_job_id(job_id);
    attempt.set_fence(job.fence);
    running += (id < 0 || job.study == id) && queue.IsHeldBy(job.worker, attempt) ? 1 : 0;
  }
  if (running <= limit) return;
  Complain(fmt::format("{} jobs of {} run, the limit is {}", running,
                       id < 0 ? "the user" : fmt::format("study {}", id), limit));
}

void QueueModel::LeaseTaken(const v1::AttemptId& attempt, const std::string& reason) {
  const auto found = jobs_.find(attempt.job_id());
  if (found == jobs_.end() || found->second.fence != attempt.fence()) return;
  Job& job = found->second;
  if (job.state == Job::kDone && !job.in_doubt) {
    Complain(Name(attempt.job_id(), job) + " was done, and its lease is taken");
  }
  // Another reason is that nobody wants its result any more.
  const bool for_silence = reason.find("worker ") != std::string::npos;
  if (for_silence && job.state == Job::kHeld && !IsExcused(job)) {
    Complain(Name(attempt.job_id(), job) + " is taken from a worker in time: " + reason);
  }
  job.state = Job::kOpen;
  job.taken = true;
  job.in_doubt = false;
}

void QueueModel::ReportBegins(const v1::AttemptId& attempt) {
  reporting_.insert({attempt.job_id(), attempt.fence()});
}

void QueueModel::ReportEnds(const v1::AttemptId& attempt, Report report,
                            const absl::StatusOr<v1::ReportOutcome>& outcome) {
  EraseOne(reporting_, std::pair(attempt.job_id(), attempt.fence()));
  const auto found = jobs_.find(attempt.job_id());
  if (!outcome.ok()) return Expect(outcome.status(), fmt::format("job {}", attempt.job_id()));
  if (found == jobs_.end()) {
    const bool was_given = fences_.count(attempt.fence()) > 0;  // In what a backup has replaced.
    if (was_given && *outcome == v1::REPORT_OUTCOME_STALE_FENCE) return;
    return Complain("a report on a job that was never leased");
  }
  Job& job = found->second;
  const std::string name = Name(attempt.job_id(), job);
  const bool newest = job.fence == attempt.fence();
  const bool holds = newest && job.state == Job::kHeld;
  switch (*outcome) {
    case v1::REPORT_OUTCOME_OK:
      if (!holds && !(newest && job.in_doubt)) {
        Complain(fmt::format("{}: the stale attempt {:x} ends it", name, attempt.fence()));
      }
      job.state = report == Report::kComplete ? Job::kDone : Job::kOpen;
      job.in_doubt = false;
      if (report != Report::kComplete) break;
      if (job.kind == "render" && made_by_[attempt.fence()] != release_) {
        Complain(name + ": pictures of another release are published as this one's");
      }
      accepted_.insert(attempt.fence());
      ++done_;
      break;
    case v1::REPORT_OUTCOME_ALREADY_DONE:
      if (report == Report::kComplete && accepted_.count(attempt.fence()) == 0) {
        Complain(name + " is said to be done already, and was not");
      }
      if (report == Report::kComplete && newest) job.state = Job::kDone;
      if (report != Report::kComplete && holds) job.state = Job::kOpen;
      if (newest) job.in_doubt = false;
      break;
    case v1::REPORT_OUTCOME_STALE_FENCE:
      ++stale_;
      if ((holds && !IsExcused(job)) || (newest && job.state == Job::kDone && !job.in_doubt)) {
        const Study& study = studies_[job.study];
        if (!study.forgotten && !study.in_doubt)
          Complain(name + " holds its lease and is called stale");
      }
      if (holds) job.state = Job::kOpen;
      break;
    default:
      break;
  }
}

}  // namespace parallax::faults
