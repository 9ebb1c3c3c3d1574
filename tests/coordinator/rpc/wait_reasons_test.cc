// READY jobs say why they do not run, on a busy farm too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "puppet.h"
#include "server_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;

class WaitReasonsTest : public CoordinatorServerTest {
 protected:
  v1::SubmitReply SubmitTraining(const std::string& tag) {
    v1::SubmitRequest request;
    v1::StudySpec& study = *request.mutable_study();
    study.set_name("stuck");
    study.set_seed(7);
    study.set_pairs(2);
    study.set_rigs_per_scene(2);
    if (!tag.empty()) study.add_tags(tag);
    v1::VariantSpec& variant = *study.add_variants();
    variant.set_name("v");
    variant.mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
    variant.mutable_config()->mutable_rigs()->set_count(2);
    study.mutable_train()->set_trainer("raftstereo");
    study.mutable_train()->set_seeds(4);
    study.mutable_train()->set_steps(10);
    grpc::ClientContext context;
    v1::SubmitReply reply;
    const absl::Status status = FromGrpc(stub_->Submit(&context, request, &reply));
    EXPECT_TRUE(status.ok()) << status;
    return reply;
  }
  // Waits until the study's first reason is `reason`; returns the seconds that it took, or -1.
  double SecondsTo(int64_t study, const std::string& reason) {
    const auto begin = std::chrono::steady_clock::now();
    while (true) {
      const double s =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const v1::StudyStatus status = GetStudy(study);
      if (status.waiting_size() > 0 && status.waiting(0).reason() == reason) return s;
      if (s > 20) return -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  std::vector<v1::JobStatus> ReadyJobs(int64_t study) {
    v1::ListJobsRequest request;
    request.set_study_id(study);
    request.set_state("READY");
    grpc::ClientContext context;
    v1::ListJobsReply reply;
    EXPECT_TRUE(stub_->ListJobs(&context, request, &reply).ok());
    return {reply.jobs().begin(), reply.jobs().end()};
  }
};

TEST_F(WaitReasonsTest, AStuckJobHasItsReasonWithin5SecondsWhile20OthersRun) {
  StartCoordinator();
  StartAgent("renderer", noop_, 2);
  const int64_t stuck = SubmitTraining("").study_id();
  ASSERT_GE(SecondsTo(stuck, "kind"), 0) << "its pairs are made; nobody trains";
  std::vector<std::unique_ptr<Puppet>> busy;
  Submit(80, 2, {"load"});
  for (int i = 0; i < 20; ++i) {
    busy.push_back(std::make_unique<Puppet>(*stub_));
    busy.back()->Hello("busy-" + std::to_string(i), {}, {"solve", "render", "train"});
    busy.back()->Credit(1);
  }
  const double seconds = SecondsTo(stuck, "trainer");
  EXPECT_GE(seconds, 0);
  EXPECT_LT(seconds, 5);
  const v1::StudyStatus study = GetStudy(stuck);
  ASSERT_EQ(study.waiting_size(), 1);
  EXPECT_EQ(study.waiting(0).kind(), "train");
  EXPECT_EQ(study.waiting(0).jobs(), 4);
  EXPECT_THAT(study.waiting(0).text(), HasSubstr("the trainer raftstereo"));
  const auto jobs = ReadyJobs(stuck);
  ASSERT_EQ(jobs.size(), 4u);
  for (const v1::JobStatus& job : jobs) {
    EXPECT_EQ(job.waits_reason(), "trainer");
    EXPECT_EQ(job.waits_text(), study.waiting(0).text());
  }
  for (auto& puppet : busy) EXPECT_TRUE(puppet->Finish().ok());
}

TEST_F(WaitReasonsTest, APausedADrainedAndABusyFarmEachSaySo) {
  StartCoordinator();
  Puppet puppet(*stub_);
  puppet.Hello("w");
  const int64_t study = Submit(40, 2, {"v"});
  EXPECT_GE(SecondsTo(study, "starting"), 0);
  puppet.Credit(1);
  EXPECT_GE(SecondsTo(study, "busy"), 0);
  ASSERT_TRUE(queue_->Pause(StudyId{study}, "", "t").ok());
  EXPECT_GE(SecondsTo(study, "pause"), 0);
  ASSERT_TRUE(queue_->Resume(StudyId{study}, "", "t").ok());
  ASSERT_TRUE(queue_->SetMaxRunning(StudyId{study}, 1, "", "t").ok());
  EXPECT_GE(SecondsTo(study, "limit"), 0);
  ASSERT_TRUE(queue_->SetMaxRunning(StudyId{study}, 0, "", "t").ok());
  v1::DrainOrder order;
  order.set_pattern("w");
  ASSERT_TRUE(queue_->Drain(order, /*undo=*/false).ok());
  EXPECT_GE(SecondsTo(study, "drain"), 0);
  EXPECT_TRUE(puppet.Finish().ok());
}

TEST_F(WaitReasonsTest, ASubmitNamesTheJobsThatNoKnownWorkerCouldRun) {
  StartCoordinator();
  v1::SubmitReply reply = SubmitTraining("");
  ASSERT_EQ(reply.unservable_size(), 1);
  EXPECT_EQ(reply.unservable(0).reason(), "no_worker");
  StartAgent("renderer", noop_, 2);
  ASSERT_TRUE(SecondsTo(reply.study_id(), "kind") >= 0);
  reply = SubmitTraining("big");
  std::vector<std::string> said;
  for (const v1::WaitingJobs& jobs : reply.unservable()) {
    said.push_back(jobs.kind() + " " + jobs.reason());
  }
  EXPECT_THAT(said, testing::ElementsAre("solve tag", "render tag", "train kind"));
}

}  // namespace
}  // namespace parallax
