// Which workers get a training or an evaluation: those with what it needs.
#include "train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using TrainNeedsTest = TrainQueueTest;

TEST_F(TrainNeedsTest, OnlyAWorkerWithWhatATrainingNeedsGetsIt) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  v1::JobNeeds& needs = *request.mutable_study()->mutable_train()->mutable_needs();
  needs.set_gpus(1);
  needs.set_memory_mb(4000);
  needs.add_tags("fast");
  SubmitRequest(request);
  MakePairs();
  WorkerFacts worker = Trainer("t");
  worker.memory_mb = 4000;
  worker.tags = {"fast", "trainer:builtin"};
  EXPECT_THAT(Lease(worker, 1), IsEmpty()) << "without a GPU";
  worker.tags = {"gpu", "trainer:builtin"};
  EXPECT_THAT(Lease(worker, 1), IsEmpty());
  worker.tags = {"fast", "gpu"};
  EXPECT_THAT(Lease(worker, 1), IsEmpty()) << "without the trainer";
  worker.tags = {"fast", "gpu", "trainer:builtin"};
  worker.memory_mb = 3999;
  EXPECT_THAT(Lease(worker, 1), IsEmpty());
  worker.memory_mb = 4000;
  EXPECT_THAT(Lease(worker, 1), SizeIs(1));
}

// A worker with the wanted trainer and benchmarks tells so by its tags.
TEST_F(TrainNeedsTest, AnEvaluationGoesToAWorkerThatHasItsTrainerAndBenchmark) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  for (const char* name : {"eth3d", "shipped"}) evaluate.add_benchmarks(name);
  evaluate.add_baselines("sgbm");
  SubmitRequest(request);
  MakePairs();
  TrainAll();
  WorkerFacts worker = Evaluator("e");
  const auto labels_with = [&](std::vector<std::string> tags) {
    worker.tags = std::move(tags);
    std::vector<std::string> labels;
    for (const v1::Lease& lease : Lease(worker, 9)) {
      labels.push_back(lease.label());
      Complete(EvaluateAnswer(lease, "e"));
    }
    return labels;
  };
  EXPECT_THAT(labels_with({"trainer:another"}), ElementsAre("sgbm on shipped"));
  EXPECT_THAT(labels_with({"benchmark:eth3d"}), ElementsAre("sgbm on eth3d"));
  EXPECT_THAT(labels_with({"trainer:builtin"}), ElementsAre("wide, seed 0 on shipped"));
  EXPECT_THAT(labels_with({"benchmark:eth3d", "trainer:builtin"}),
              ElementsAre("wide, seed 0 on eth3d"));
}

// ---- Out of memory
TEST_F(TrainNeedsTest, ATrainingThatRanOutOfMemoryGoesToAWorkerWithMore) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_train()->mutable_needs()->set_memory_mb(4000);
  const StudyId study = SubmitRequest(request);
  MakePairs();
  WorkerFacts small = Trainer("small"), big = Trainer("big"), other = Evaluator("other");
  small.memory_mb = 4000;
  big.memory_mb = 5000;
  other.memory_mb = 64000;  // Takes no trainings.
  const auto fail = [&](const v1::Lease& lease, const std::string& worker) {
    v1::FailRequest failure =
        Failure(lease, worker, "RESOURCE_EXHAUSTED@train: out of memory: killed");
    failure.set_error("RESOURCE_EXHAUSTED: out of memory: killed");
    Fail(failure);
    clock_.Advance(3600);
    Tick();
  };
  EXPECT_THAT(Lease(other, 1), IsEmpty());
  const v1::Lease first = LeaseOne(small);
  EXPECT_THAT(Lease(big, 1), IsEmpty());  // It is known from now on.
  fail(first, "small");
  EXPECT_THAT(Lease(small, 1), IsEmpty()) << "half as much again, as far as a worker has it";
  ASSERT_THAT(ListJobs(study, "READY"), SizeIs(1));
  EXPECT_EQ(ListJobs(study, "READY")[0].needs_memory_mb(), 5000);
  EXPECT_THAT(ListJobs(study, "READY")[0].error(),
              HasSubstr("out of memory: killed; it needs a worker with 5000 MB now"));
  Reopen();
  EXPECT_THAT(Lease(small, 1), IsEmpty()) << "after a restart too";
  fail(LeaseOne(big), "big");
  const int64_t job = first.attempt().job_id();
  const auto attempts = queue_->ListAttempts(job);
  ASSERT_TRUE(attempts.ok()) << attempts.status();
  ASSERT_THAT(attempts->attempts(), SizeIs(2));
  EXPECT_THAT(attempts->attempts(0).error(), HasSubstr("no worker for it has more than 5000 MB"));
  EXPECT_EQ(Jobs(study, "train", "QUARANTINED"), 0) << "the two had different memory";
  Complete(TrainAnswer(LeaseOne(big), "big"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(TrainNeedsTest, AWorkersMemoryIsWhereATrainingWithoutNeedsBegins) {
  const StudyId study = SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  WorkerFacts small = Trainer("small"), big = Trainer("big");
  small.memory_mb = 4000;
  big.memory_mb = 64000;
  const v1::Lease lease = LeaseOne(small);
  EXPECT_THAT(Lease(big, 1), IsEmpty());
  // A GPU's memory is another one.
  Fail(Failure(lease, "small", "RESOURCE_EXHAUSTED@train: CUDA out of memory"));
  clock_.Advance(3600);
  Tick();
  EXPECT_EQ(ListJobs(study, "READY").at(0).needs_memory_mb(), 0);
  Fail(Failure(LeaseOne(small), "small", "RESOURCE_EXHAUSTED@train: memory is exhausted"));
  clock_.Advance(3600);
  Tick();
  EXPECT_EQ(ListJobs(study, "READY").at(0).needs_memory_mb(), 6000);
}

TEST_F(TrainNeedsTest, AlikeJobsAreOneGroupOfWhatTheyNeed) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->set_memory_mb(3000);
  request.mutable_study()->add_tags("fast");
  request.mutable_study()->mutable_train()->set_seeds(20);
  request.mutable_study()->mutable_train()->mutable_needs()->set_gpus(1);
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  for (const char* name : {"eth3d", "shipped"}) evaluate.add_benchmarks(name);
  evaluate.add_baselines("sgbm");
  const int64_t study = SubmitRequest(request).value;
  const ReadyKey training{study, "train", 3000, {"fast", "gpu", "trainer:builtin"}};
  const ReadyKey on_eth3d{study, "evaluate", 3000, {"benchmark:eth3d", "fast"}};
  const ReadyKey on_shipped{study, "evaluate", 3000, {"fast"}};
  const ReadyKey solve{study, "solve", 3000, {"fast"}};
  using testing::Pair;
  EXPECT_THAT(
      queue_->ReadyGroups(study),
      testing::UnorderedElementsAre(Pair(on_eth3d, 1), Pair(on_shipped, 1), Pair(solve, 1)));
  WorkerFacts worker = AnyWorker("w");
  worker.tags = {"fast"};
  WorkOff(worker);
  const auto all =
      testing::UnorderedElementsAre(Pair(on_eth3d, 1), Pair(on_shipped, 1), Pair(training, 20));
  EXPECT_THAT(queue_->ReadyGroups(study), all);
  EXPECT_THAT(queue_->ReadyGroups(study + 1), IsEmpty());
  Reopen();
  EXPECT_THAT(queue_->ReadyGroups(), all) << "after a restart";
  v1::ListJobsRequest list;
  list.set_study_id(study);
  list.set_state("READY");
  const auto jobs = queue_->ListJobs(list);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  std::map<ReadyKey, int64_t> listed;
  for (const v1::JobStatus& job : *jobs) {
    ++listed[{study,
              job.kind(),
              job.needs_memory_mb(),
              {job.needs_tags().begin(), job.needs_tags().end()}}];
  }
  EXPECT_THAT(listed, all) << "each job names the needs of its group";
}

TEST_F(TrainNeedsTest, ManyJobsThatAWorkerCannotDoHideNoneThatItCan) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_train()->set_seeds(20);
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  evaluate.add_benchmarks("eth3d");
  evaluate.add_benchmarks("shipped");
  const StudyId study = SubmitRequest(request);
  MakePairs();
  TrainAll();
  WorkerFacts worker = Evaluator("e");
  worker.tags = {"trainer:builtin"};
  int leased = 0;
  for (const v1::Lease& lease : Lease(worker, 50)) {
    EXPECT_THAT(lease.label(), HasSubstr("on shipped"));
    ++leased;
  }
  EXPECT_EQ(leased, 20);
  EXPECT_THAT(States(study, "evaluate"), SizeIs(40));
}

}  // namespace
}  // namespace parallax
