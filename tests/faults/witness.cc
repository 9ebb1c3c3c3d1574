#include "tests/coordinator/queue/train_fixture.h"
#include "tests/faults/life.h"
#include "tests/noop/noop_kind.h"

namespace parallax::faults {

void Witness::NoteFence(uint64_t fence) {
  if (!fences_.insert(fence).second) {
    tally_.Doubled("fence " + std::to_string(fence) + " was issued twice");
  }
}

std::unique_ptr<JobQueue> Witness::Open() {
  JobQueueOptions options = options_.queue;
  options.fail_point = nullptr;
  options.kinds = &Kinds();
  auto queue = JobQueue::Open(options);
  if (!queue.ok()) {
    tally_.Lost("the database does not open: " + queue.status().ToString());
    return nullptr;
  }
  return *std::move(queue);
}

void Witness::Audit(JobQueue& queue, const std::string& where) {
  const auto violations = queue.Check();
  if (!violations.ok()) return tally_.Lost("the auditor fails: " + violations.status().ToString());
  tally_.Found(*violations, where);
}

void Witness::Verify(const AckLog& acks) {
  // Clients whose call may have ended any lease, also one granted meanwhile.
  std::set<int32_t> ending;
  for (size_t i = 0; i < acks.size(); ++i) {
    if (!acks.IsWhole(i)) continue;
    const Ack& ack = acks[i];
    const std::pair<int64_t, uint64_t> attempt(ack.job, ack.fence);
    switch (ack.kind) {
      case Ack::kStudy:
        studies_.insert(ack.study);
        break;
      case Ack::kCancelled:
        cancelled_.insert(ack.study);
        break;
      case Ack::kLeased:
        NoteFence(ack.fence);
        held_[attempt] = ack.worker;
        break;
      case Ack::kCompleted:
      case Ack::kFailed:
      case Ack::kHandedBack:
        held_.erase(attempt);
        reports_[attempt] = ack;
        break;
      case Ack::kMayEnd:
      case Ack::kGone:
        if (ack.job != 0) {
          held_.erase(attempt);
          break;
        }
        held_.clear();
        if (ack.kind == Ack::kMayEnd) {
          ending.insert(ack.client);
        } else {
          ending.erase(ack.client);
        }
        break;
      case Ack::kViolation:
        tally_.Doubled("a late result of job " + std::to_string(ack.job) + " was accepted");
        break;
    }
  }
  if (!ending.empty()) held_.clear();
  const auto queue = Open();
  if (queue == nullptr) return;
  Audit(*queue, "after the fault");
  VerifyStudies(*queue);
  VerifyReports(*queue);
  VerifyLeases(*queue);
}

void Witness::VerifyStudies(JobQueue& queue) {
  for (const int64_t study : studies_) {
    const auto status = queue.GetStudy(StudyId{study});
    if (!status.ok()) {
      tally_.Lost("study " + std::to_string(study) + ": " + status.status().ToString());
    } else if (cancelled_.count(study) != 0 && status->state() != v1::STUDY_STATE_CANCELLED) {
      tally_.Lost("the cancel of study " + std::to_string(study));
    } else if (status->state() == v1::STUDY_STATE_CANCELLED) {
      cancelled_.insert(study);  // Committed, not answered.
    }
  }
}

// Each report again: it is known, whatever has happened since.
void Witness::VerifyReports(JobQueue& queue) {
  for (const auto& [key, ack] : reports_) {
    v1::AttemptId attempt;
    attempt.set_job_id(ack.job);
    attempt.set_fence(ack.fence);
    absl::StatusOr<v1::ReportOutcome> outcome = v1::REPORT_OUTCOME_UNSPECIFIED;
    if (ack.kind == Ack::kCompleted) {
      v1::CompleteRequest request;
      *request.mutable_attempt() = attempt;
      request.set_worker(ack.worker);
      outcome = queue.Complete(request);
    } else if (ack.kind == Ack::kFailed) {
      v1::FailRequest request;
      *request.mutable_attempt() = attempt;
      request.set_worker(ack.worker);
      outcome = queue.Fail(request);
    } else {
      outcome = queue.HandBack(ack.worker, attempt, "again");
    }
    if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_ALREADY_DONE) {
      tally_.Lost("report of job " + std::to_string(ack.job) + ", attempt " +
                  std::to_string(ack.fence) + ": " +
                  (outcome.ok() ? v1::ReportOutcome_Name(*outcome) : outcome.status().ToString()));
    }
  }
}

void Witness::VerifyLeases(JobQueue& queue) {
  std::map<std::string, std::vector<v1::AttemptId>> of_worker;
  for (const auto& [key, worker] : held_) {
    v1::AttemptId& attempt = of_worker[worker].emplace_back();
    attempt.set_job_id(key.first);
    attempt.set_fence(key.second);
  }
  for (const auto& [worker, holding] : of_worker) {
    const auto adopted = queue.Adopt(worker, holding);
    if (!adopted.ok() || adopted->size() != holding.size()) {
      tally_.Lost("of " + std::to_string(holding.size()) + " leases of " + worker + ", " +
                  (adopted.ok() ? std::to_string(adopted->size()) + " are adopted"
                                : adopted.status().ToString()));
      for (const v1::AttemptId& attempt : holding) {
        v1::CompleteRequest request;
        *request.mutable_attempt() = attempt;
        const auto outcome = queue.Complete(request);
        tally_.complaints.push_back(
            "  job " + std::to_string(attempt.job_id()) + ", attempt " +
            std::to_string(attempt.fence()) + ": " +
            (outcome.ok() ? v1::ReportOutcome_Name(*outcome) : outcome.status().ToString()));
        std::fprintf(stderr, "%s\n", tally_.complaints.back().c_str());
      }
      continue;
    }
    for (const v1::AttemptId& attempt : *adopted) {
      (void)queue.HandBack(worker, attempt, "end of a life");
    }
  }
  held_.clear();
}

void Witness::Finish() {
  const auto queue = Open();
  if (queue == nullptr) return;
  for (const int64_t study : studies_) (void)queue->Resume(StudyId{study}, "", "witness");
  const WorkerFacts worker = LivingWorker("finisher");
  for (int idle = 0; idle < 12;) {
    const auto leases = queue->Lease(worker, 8);
    if (!leases.ok()) return tally_.Lost("lease: " + leases.status().ToString());
    if (leases->empty()) {
      ++idle;
      options_.clock->Advance(300);  // Longer than a lease and, twelve times, than any back-off.
      (void)queue->Tick();
      continue;
    }
    idle = 0;
    for (const v1::Lease& lease : *leases) {
      NoteFence(lease.attempt().fence());
      const auto outcome = queue->Complete(AnswerOf(lease, worker.name));
      if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_OK) {
        tally_.Lost("job " + std::to_string(lease.attempt().job_id()) + " can't be completed");
      }
    }
  }
  for (const int64_t study : studies_) CountPairs(*queue, study);
  Audit(*queue, "at the end");
}

void Witness::CountPairs(JobQueue& queue, int64_t study) {
  const auto status = queue.GetStudy(StudyId{study});
  if (!status.ok()) return tally_.Lost("study " + std::to_string(study));
  v1::ListFramesRequest request;
  request.set_study_id(study);
  request.set_limit(10'000);
  const auto frames = queue.ListFrames(request);
  if (!frames.ok()) return tally_.Lost("frames: " + frames.status().ToString());
  std::set<std::tuple<std::string, uint32_t, uint32_t>> seen;
  for (const v1::PublishedFrame& frame : *frames) {
    if (!seen.insert({frame.variant(), frame.scene(), frame.frame().rig()}).second) {
      tally_.Doubled("a frame of study " + std::to_string(study));
    }
  }
  int64_t wanted = 0;
  for (const v1::VariantStatus& variant : status->variants()) {
    wanted += variant.pairs_wanted();
    tally_.jobs += JobsOf(variant, "", "SUCCEEDED");
  }
  // A job that waits for pairs has ended, in some way, when they are there.
  for (const v1::VariantStatus& variant : status->variants()) {
    for (const char* kind : {"noop", "train", "evaluate"}) {
      if (JobsOf(variant, kind, "BLOCKED") + JobsOf(variant, kind, "READY") > 0) {
        tally_.Lost(std::string(kind) + " jobs of study " + std::to_string(study) + " are stuck");
      }
    }
  }
  // A variant that gave up after too many rejections has said so; its study is not short of a pair
  // by a fault.
  bool gave_up = false;
  int64_t others_lost = 0;
  for (const v1::VariantStatus& variant : status->variants()) {
    for (const v1::JobProblem& problem : variant.problems()) {
      gave_up |= problem.state() == "GAVE_UP";
    }
    for (const char* kind : {"noop", "train", "evaluate"}) {
      for (const char* state : {"FAILED", "QUARANTINED", "CANCELLED"}) {
        others_lost += JobsOf(variant, kind, state);
      }
    }
  }
  if (status->state() == v1::STUDY_STATE_CANCELLED || gave_up) return;
  const bool succeeded = status->state() == v1::STUDY_STATE_SUCCEEDED ||
                         (status->state() == v1::STUDY_STATE_FAILED && others_lost > 0);
  if (!succeeded || static_cast<int64_t>(seen.size()) != wanted) {
    tally_.Lost("study " + std::to_string(study) + " is " + v1::StudyState_Name(status->state()) +
                " with " + std::to_string(seen.size()) + " of " + std::to_string(wanted) +
                " pairs");
  }
}

}  // namespace parallax::faults
