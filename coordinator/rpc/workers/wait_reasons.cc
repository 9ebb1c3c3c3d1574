#include "coordinator/rpc/workers/wait_reasons.h"

#include <algorithm>

#include "common/base/seconds.h"

namespace parallax {
namespace {

constexpr double kWorkersAge_s = 0.5;

StudyHold HoldOf(const v1::StudyStatus& study) {
  return {.paused = study.state() == v1::STUDY_STATE_PAUSED, .at_limit = study.at_limit()};
}

v1::WaitingJobs Message(const std::string& kind, const WaitReason& reason, int64_t jobs) {
  v1::WaitingJobs message;
  message.set_kind(kind);
  message.set_jobs(jobs);
  message.set_reason(reason.code);
  message.set_text(reason.text);
  return message;
}

}  // namespace

WaitReasons::WaitReasons(JobQueue& queue, Clock& clock,
                         std::function<std::vector<WorkerGroup>()> workers)
    : queue_(queue), clock_(clock), workers_(std::move(workers)) {}

std::shared_ptr<const std::vector<WorkerGroup>> WaitReasons::Workers() const {
  const std::lock_guard lock(mutex_);
  const SteadyTime now = clock_.Steady();
  if (groups_ == nullptr || SecondsBetween(groups_at_, now) >= kWorkersAge_s) {
    groups_ = std::make_shared<const std::vector<WorkerGroup>>(workers_());
    groups_at_ = now;
  }
  return groups_;
}

void WaitReasons::AddTo(v1::StudyStatus& study) const {
  study.clear_waiting();
  const std::map<ReadyKey, int64_t> groups = queue_.ReadyGroups(study.study_id());
  if (groups.empty()) return;
  const auto workers = Workers();
  const StudyHold hold = HoldOf(study);
  // Groups with different needs may have one reason.
  std::vector<v1::WaitingJobs> reasons;
  for (const auto& [key, jobs] : groups) {
    const WaitReason reason = WhyWaiting(key, hold, *workers);
    const auto is_same = [&kind = key.kind, &reason](const v1::WaitingJobs& one) {
      return one.kind() == kind && one.text() == reason.text;
    };
    const auto same = std::find_if(reasons.begin(), reasons.end(), is_same);
    if (same != reasons.end()) {
      same->set_jobs(same->jobs() + jobs);
    } else {
      reasons.push_back(Message(key.kind, reason, jobs));
    }
  }
  std::stable_sort(
      reasons.begin(), reasons.end(), [](const v1::WaitingJobs& a, const v1::WaitingJobs& b) {
        const bool a_stuck = IsUnservable(a.reason()), b_stuck = IsUnservable(b.reason());
        return a_stuck != b_stuck ? a_stuck : a.jobs() > b.jobs();
      });
  for (v1::WaitingJobs& reason : reasons) *study.add_waiting() = std::move(reason);
}

absl::Status WaitReasons::AddTo(std::span<v1::JobStatus> jobs, int64_t study_id) const {
  const auto is_ready = [](const v1::JobStatus& job) { return job.state() == "READY"; };
  if (std::none_of(jobs.begin(), jobs.end(), is_ready)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const v1::StudyStatus study, queue_.GetStudy(StudyId{study_id}));
  const auto workers = Workers();
  const StudyHold hold = HoldOf(study);
  std::map<ReadyKey, WaitReason> known;
  for (v1::JobStatus& job : jobs) {
    if (!is_ready(job)) continue;
    const ReadyKey key{study_id,
                       job.kind(),
                       job.needs_memory_mb(),
                       {job.needs_tags().begin(), job.needs_tags().end()}};
    auto found = known.find(key);
    if (found == known.end()) {
      found = known.emplace(key, WhyWaiting(key, hold, *workers)).first;
    }
    job.set_waits_reason(found->second.code);
    job.set_waits_text(found->second.text);
  }
  return absl::OkStatus();
}

std::vector<v1::WaitingJobs> WaitReasons::UnservableOf(const v1::StudySpec& study) const {
  const auto workers = Workers();
  const WorkNeeds study_needs{study.memory_mb(), {study.tags().begin(), study.tags().end()}};
  std::vector<v1::WaitingJobs> unservable;
  for (size_t i = 0; i < queue_.kinds().size(); ++i) {
    const JobKind& kind = queue_.kinds().at(i);
    for (const WorkNeeds& needs : kind.NeedsOfStudy(study)) {
      const WaitReason reason = WhyWaiting(ReadyKeyOf(0, study_needs, kind, needs), {}, *workers);
      if (!IsUnservable(reason.code)) continue;
      const bool listed =
          std::any_of(unservable.begin(), unservable.end(), [&](const v1::WaitingJobs& one) {
            return one.text() == reason.text &&
                   (one.kind() == kind.name() || reason.code == "no_worker");
          });
      if (!listed) unservable.push_back(Message(kind.name(), reason, 0));
    }
  }
  return unservable;
}

}  // namespace parallax
