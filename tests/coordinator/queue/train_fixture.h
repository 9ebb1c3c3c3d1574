// Fixture of tests of trainings and evaluations: studies, and their workers' answers.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "common/base/ability_tags.h"
#include "common/config/training_plan.h"
#include "coordinator/queue/job_queue.h"
#include "parallax/v1/train.pb.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {

// The trainers and the benchmark that a worker of these tests has; as it tells by itself.
inline std::vector<std::string> Abilities() {
  return {TrainerTag("builtin"), TrainerTag("other"), BenchmarkTag("eth3d")};
}
inline WorkerFacts Trainer(const std::string& name) {
  return {.name = name, .kinds = {"train"}, .memory_mb = 8000, .tags = Abilities()};
}
inline WorkerFacts Evaluator(const std::string& name) {
  return {.name = name, .kinds = {"evaluate"}, .memory_mb = 8000, .tags = Abilities()};
}
inline v1::TrainJob TrainJobOf(const v1::Lease& lease) {
  v1::TrainJob job;
  job.ParseFromString(lease.spec());
  return job;
}
inline v1::EvaluateJob EvaluateJobOf(const v1::Lease& lease) {
  v1::EvaluateJob job;
  job.ParseFromString(lease.spec());
  return job;
}
inline std::string AttemptFolderOf(const v1::Lease& lease) {
  return lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence());
}

template <typename Result>
v1::CompleteRequest AnswerWith(const v1::Lease& lease, const std::string& worker, Result result) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  request.set_kind(lease.kind());
  request.set_result(result.SerializeAsString());
  return request;
}

inline v1::CompleteRequest TrainAnswer(const v1::Lease& lease, const std::string& worker,
                                       const std::vector<int64_t>& steps = {100}) {
  v1::TrainResult result;
  result.set_path(AttemptFolderOf(lease));
  for (const int64_t step : steps) {
    const std::string name = "step-" + std::to_string(step) + ".pt";
    v1::FileEntry* file = result.add_files();
    file->set_name(name);
    file->set_size(10);
    file->set_sha256(std::string(64, 'b'));
    v1::TrainedCheckpoint* checkpoint = result.add_checkpoints();
    checkpoint->set_name(name);
    checkpoint->set_step(step);
  }
  result.set_loss(1.5);
  result.set_train_s(3);
  int64_t pairs = 0;
  const v1::TrainJob job = TrainJobOf(lease);
  for (const v1::FrameSet& part : job.parts()) {
    for (const v1::FrameFolder& folder : part.folders()) pairs += folder.rigs_size();
  }
  result.set_pairs(pairs);
  return AnswerWith(lease, worker, result);
}

inline v1::CompleteRequest EvaluateAnswer(const v1::Lease& lease, const std::string& worker,
                                          int64_t pairs_missing = 0) {
  v1::EvaluateResult result;
  result.set_path(AttemptFolderOf(lease));
  v1::FileEntry* file = result.add_files();
  file->set_name("scores.jsonl");
  file->set_size(10);
  file->set_sha256(std::string(64, 'c'));
  result.set_pairs(1);
  result.set_metric("bad-2 all");
  result.set_value(12.5);
  result.set_predict_s(2);
  result.set_pairs_missing(pairs_missing);
  return AnswerWith(lease, worker, result);
}

// A worker of all kinds, and its answer to any lease.
inline WorkerFacts Everyman(const std::string& name) {
  WorkerFacts worker = AnyWorker(name);
  worker.kinds.insert(worker.kinds.end(), {"train", "evaluate"});
  worker.tags = Abilities();
  return worker;
}
inline v1::CompleteRequest AnyAnswer(const v1::Lease& lease, const std::string& worker) {
  if (lease.kind() == "train") return TrainAnswer(lease, worker);
  return lease.kind() == "evaluate" ? EvaluateAnswer(lease, worker) : Answer(lease, worker);
}
// The study with two trainings of each variant, their evaluations and a baseline's.
inline v1::SubmitRequest WithTrainings(v1::SubmitRequest request, int heldout_pairs = 0) {
  v1::StudySpec& study = *request.mutable_study();
  study.mutable_train()->set_seeds(2);
  study.mutable_evaluate()->add_benchmarks("shipped");
  study.mutable_evaluate()->add_baselines("sgbm");
  study.mutable_evaluate()->set_heldout_pairs(heldout_pairs);
  ResolveTraining(&study);
  return request;
}

class TrainQueueTest : public QueueTest {
 protected:
  static v1::SubmitRequest Request(const StudyOptions& options = {.variants = {"wide", "narrow"}}) {
    v1::SubmitRequest request = MakeStudy(options);
    request.mutable_study()->mutable_train()->set_seeds(1);
    request.mutable_study()->mutable_train()->set_steps(100);
    return request;
  }
  StudyId SubmitRequest(v1::SubmitRequest request) {
    ResolveTraining(request.mutable_study());
    const auto reply = queue_->Submit(request, "tester");
    EXPECT_TRUE(reply.ok()) << reply.status();
    return StudyId{reply.ok() ? reply->study_id() : 0};
  }
  // "narrow, seed 0: READY", of jobs of these kinds, by id.
  std::vector<std::string> States(StudyId study, const std::string& kind) {
    std::vector<v1::JobStatus> jobs = ListJobs(study);
    std::sort(jobs.begin(), jobs.end(),
              [](const auto& a, const auto& b) { return a.job_id() < b.job_id(); });
    std::vector<std::string> states;
    for (const v1::JobStatus& job : jobs) {
      if (job.kind() == kind) states.push_back(job.label() + ": " + job.state());
    }
    return states;
  }
  void MakePairs() { WorkOff(AnyWorker("w")); }
  // Its one training, done.
  void TrainAll() {
    for (const v1::Lease& lease : Lease(Trainer("t"), 100)) {
      EXPECT_EQ(Complete(TrainAnswer(lease, "t")), v1::REPORT_OUTCOME_OK);
    }
  }
  void EvaluateAll() {
    for (const v1::Lease& lease : Lease(Evaluator("e"), 100)) {
      EXPECT_EQ(Complete(EvaluateAnswer(lease, "e")), v1::REPORT_OUTCOME_OK);
    }
  }
  v1::StudyState State(StudyId study) { return Status(study).state(); }
};

}  // namespace parallax
