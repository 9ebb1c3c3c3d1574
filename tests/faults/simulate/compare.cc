// The model against the queue's tables.
#include <fmt/core.h>

#include <set>
#include <tuple>

#include "tests/faults/simulate/model.h"

namespace parallax::faults {
namespace {

constexpr int kMostRows = 10'000;

// The fence in "ab/ab12.../.attempt-7/003".
uint64_t FenceOf(const std::string& path) {
  constexpr std::string_view kBegin = "/.attempt-";
  const size_t at = path.find(kBegin);
  return at == std::string::npos ? 0 : std::stoull(path.substr(at + kBegin.size()));
}

bool HasEnded(v1::StudyState state) {
  return state == v1::STUDY_STATE_SUCCEEDED || state == v1::STUDY_STATE_CANCELLED ||
         state == v1::STUDY_STATE_FAILED;
}

}  // namespace

void QueueModel::Compare(JobQueue& queue, bool at_end) {
  const auto findings = queue.Check();
  if (!findings.ok()) return Expect(findings.status(), "audit");
  for (const std::string& finding : *findings) {
    // A page that nothing reads any more, such as a free one, is looked at by the audit alone.
    found_damage_ |= files_changed_ && finding.starts_with("integrity:");
    if (!found_damage_) Complain("audit: " + finding);
  }
  if (found_damage_) return;
  for (auto& [id, study] : studies_) {
    if (id != 0 && !study.forgotten) CompareStudy(queue, id, study, at_end);
  }
}

void QueueModel::CompareStudy(JobQueue& queue, int64_t id, Study& study, bool at_end) {
  const auto status = queue.GetStudy(StudyId{id});
  if (!status.ok() && !absl::IsNotFound(status.status())) {
    return Expect(status.status(), fmt::format("study {}", id));
  }
  if (study.in_doubt) {
    study.forgotten = absl::IsNotFound(status.status());
    if (study.forgotten) return;
    study.in_doubt = false;
    study.cancelled = status.ok() && status->state() == v1::STUDY_STATE_CANCELLED;
    study.paused = status.ok() && status->state() == v1::STUDY_STATE_PAUSED;
    study.max_running = status.ok() ? status->max_running() : 0;
  }
  if (!status.ok()) return Complain(fmt::format("study {}: {}", id, status.status().ToString()));
  if (status->name() != study.name) {
    Complain(fmt::format("study {} is {} and was {}", id, status->name(), study.name));
  }
  if (study.cancelled && status->state() != v1::STUDY_STATE_CANCELLED) {
    Complain(fmt::format("study {} was cancelled and is not", id));
  }
  if (at_end && !HasEnded(status->state())) {
    std::string why;
    for (const v1::VariantStatus& variant : status->variants()) {
      for (const v1::JobCount& count : variant.jobs()) {
        why += fmt::format(" {} {} {}", count.jobs(), count.state(), count.kind());
      }
    }
    Complain(fmt::format("study {} does not end ({}):{}", id, v1::StudyState_Name(status->state()),
                         why));
  }
  CompareJobs(queue, id);
  CompareFrames(queue, id, *status);
}

void QueueModel::CompareJobs(JobQueue& queue, int64_t id) {
  v1::ListJobsRequest request;
  request.set_study_id(id);
  request.set_limit(kMostRows);
  const auto rows = queue.ListJobs(request);
  if (!rows.ok()) return Expect(rows.status(), "jobs");
  std::set<int64_t> seen;
  for (const v1::JobStatus& row : *rows) {
    seen.insert(row.job_id());
    const auto found = jobs_.find(row.job_id());
    if (found == jobs_.end() || found->second.in_doubt) continue;
    const Job& job = found->second;
    const bool done = row.state() == "SUCCEEDED" || row.state() == "REJECTED";
    if (job.state == Job::kDone && !done) {
      Complain(Name(row.job_id(), job) + " was done and is " + row.state());
    }
    // Its variant gave up in a commit at which the coordinator died.
    if (row.state() == "CANCELLED" && job.state == Job::kHeld) found->second.state = Job::kOpen;
    if (job.state == Job::kHeld && row.state() != "LEASED" && !IsExcused(found->second)) {
      Complain(Name(row.job_id(), job) + " is held and is " + row.state());
    }
  }
  for (const auto& [job_id, job] : jobs_) {
    if (job.study == id && seen.count(job_id) == 0) Complain(Name(job_id, job) + " is gone");
  }
}

void QueueModel::CompareFrames(JobQueue& queue, int64_t id, const v1::StudyStatus& status) {
  v1::ListFramesRequest request;
  request.set_study_id(id);
  request.set_limit(kMostRows);
  const auto frames = queue.ListFrames(request);
  if (!frames.ok()) return Expect(frames.status(), "frames");
  std::set<std::tuple<std::string, uint32_t, uint32_t>> seen;
  std::map<std::string, int64_t> pairs;
  for (const v1::PublishedFrame& frame : *frames) {
    if (!seen.insert({frame.variant(), frame.scene(), frame.frame().rig()}).second) {
      Complain(fmt::format("study {}: scene {} rig {} of {} is published twice", id, frame.scene(),
                           frame.frame().rig(), frame.variant()));
    }
    if (accepted_.count(FenceOf(frame.frame().path())) == 0) {
      Complain(fmt::format("study {}: {} is published, and its attempt was never accepted", id,
                           frame.frame().path()));
    }
    ++pairs[frame.variant()];
  }
  for (const v1::VariantStatus& variant : status.variants()) {
    const int64_t published = pairs[variant.name()];
    if (published != variant.pairs_done() ||
        (status.state() == v1::STUDY_STATE_SUCCEEDED && published < variant.pairs_wanted())) {
      Complain(fmt::format("study {}: {} has {} pairs, says {}, wanted {}", id, variant.name(),
                           published, variant.pairs_done(), variant.pairs_wanted()));
    }
  }
}

}  // namespace parallax::faults
