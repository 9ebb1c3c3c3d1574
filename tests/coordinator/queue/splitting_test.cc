// Render jobs are split when workers would idle: same frames, true accounts, reused all the same.
#include <set>

#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

// A worker that asks while `idle` of `slots` render slots of the farm have nothing to do.
WorkerFacts OfFarm(const std::string& name, int idle, int slots) {
  WorkerFacts worker = Renderer(name);
  worker.farm["render"].idle = idle;
  worker.farm["render"].all = slots;
  return worker;
}

std::vector<uint32_t> RigsOf(const v1::Lease& lease) {
  const v1::RenderJob job = RenderOf(lease);
  return {job.rigs().begin(), job.rigs().end()};
}

class Splitting : public QueueTest {
 protected:
  StudyId SubmitSolved(const StudyOptions& options) {
    const StudyId study = Submit(options);
    for (const v1::Lease& lease : Lease(Solver("s"), 64)) {
      EXPECT_EQ(Complete(SolveAnswer(lease, "s")), v1::REPORT_OUTCOME_OK);
    }
    return study;
  }
};

TEST(PartsToSplitInto, OnlyIdleSlotsSplitWhileMoreWillCome) {
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 1}),
            1u);  // Nothing is known of the farm.
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 1, .idle_slots = 4}), 4u);
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 4, .idle_slots = 4}), 1u);
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 3, .idle_slots = 4}), 2u);
  EXPECT_EQ(PartsToSplitInto({.rigs = 3, .ready_jobs = 1, .idle_slots = 9}), 3u);
  // Workers that can solve don't idle while there is something to solve.
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 1, .ready_others = 3, .idle_slots = 4}),
            1u);
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 1, .slots = 8}), 1u);
}

TEST(PartsToSplitInto, TheLastRendersAreSharedByAllSlots) {
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 1, .slots = 8, .only_these_left = true}),
            8u);
  EXPECT_EQ(PartsToSplitInto({.rigs = 20, .ready_jobs = 9, .slots = 8, .only_these_left = true}),
            1u);
}

TEST_F(Splitting, IdleWorkersShareASceneAndTheirFramesAddUp) {
  const StudyId study = SubmitSolved({.pairs = 20, .rigs_per_scene = 20});
  std::set<uint32_t> rigs;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "r" + std::to_string(i);
    const v1::Lease lease = LeaseOne(OfFarm(name, 4 - i, 4));
    EXPECT_THAT(RigsOf(lease), SizeIs(5));
    for (const uint32_t rig : RigsOf(lease)) EXPECT_TRUE(rigs.insert(rig).second);
    EXPECT_EQ(Complete(RenderAnswer(lease, name)), v1::REPORT_OUTCOME_OK);
  }
  EXPECT_THAT(rigs, SizeIs(20));
  EXPECT_THAT(Frames(study), SizeIs(20));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(queue_->Stats().splits, 3u);
}

TEST_F(Splitting, AFarmThatIsBusyGetsScenesWhole) {
  SubmitSolved({.pairs = 40, .rigs_per_scene = 20});
  EXPECT_THAT(RigsOf(LeaseOne(OfFarm("r", 2, 2))), SizeIs(20));
}

TEST_F(Splitting, TheRestOfASplitSceneGoesToWhoHasItBuilt) {
  SubmitSolved({.pairs = 40, .rigs_per_scene = 20});
  const v1::Lease first = LeaseOne(OfFarm("a", 4, 4));
  EXPECT_THAT(RigsOf(first), SizeIs(10));
  EXPECT_EQ(Complete(RenderAnswer(first, "a")), v1::REPORT_OUTCOME_OK);
  const v1::Lease second = LeaseOne(OfFarm("a", 1, 4));
  EXPECT_EQ(second.scene(), first.scene());
}

TEST_F(Splitting, WhatWasRenderedInPartsIsReusedWhole) {
  SubmitSolved({.name = "first", .pairs = 20, .rigs_per_scene = 20});
  while (true) {
    const auto leases = Lease(OfFarm("r", 3, 3));
    if (leases.empty()) break;
    EXPECT_EQ(Complete(RenderAnswer(leases[0], "r")), v1::REPORT_OUTCOME_OK);
  }
  const StudyId again = Submit({.name = "again", .pairs = 20, .rigs_per_scene = 20});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 0);
  EXPECT_EQ(Status(again).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Status(again).variants(0).frames_reused(), 20);
}

TEST_F(Splitting, APartThatFailsLosesOnlyItsRigs) {
  const StudyId study = SubmitSolved({.pairs = 20, .rigs_per_scene = 20});
  const v1::Lease bad = LeaseOne(OfFarm("a", 2, 2));
  EXPECT_THAT(RigsOf(bad), SizeIs(10));
  EXPECT_EQ(Fail(Failure(bad, "a", "boom", /*retryable=*/false)), v1::REPORT_OUTCOME_OK);
  WorkOff(AnyWorker("w"));
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.variants(0).pairs_done(), 20);  // The next seed gave the ten.
  EXPECT_EQ(Jobs(study, "render", "FAILED"), 1);
}

TEST_F(Splitting, AZombieOfTheWholeSceneCantPublishAfterTheSplit) {
  const StudyId study = SubmitSolved({.pairs = 4, .rigs_per_scene = 4});
  const v1::Lease whole = LeaseOne(Renderer("zombie"));
  ASSERT_TRUE(queue_->WorkerLost("zombie").ok());
  const v1::Lease part = LeaseOne(OfFarm("a", 2, 2));
  EXPECT_THAT(RigsOf(part), ElementsAre(0, 1));
  EXPECT_EQ(Complete(RenderAnswer(whole, "zombie")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(Complete(RenderAnswer(part, "a")), v1::REPORT_OUTCOME_OK);
  WorkOff(Renderer("a"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(Splitting, ARetryKeepsItsPredecessorsRigs) {
  const StudyId study = SubmitSolved({.pairs = 4, .rigs_per_scene = 4});
  EXPECT_EQ(Fail(Failure(LeaseOne(Renderer("a")), "a", "boom", false)), v1::REPORT_OUTCOME_OK);
  ASSERT_TRUE(queue_->Pause(study, "", "tester").ok());
  ASSERT_TRUE(queue_->Resume(study, "", "tester").ok());
  const auto retried = queue_->Retry(study, "tester");
  ASSERT_TRUE(retried.ok()) << retried.status();
  for (const v1::Lease& lease : Lease(OfFarm("a", 4, 4), 4)) {
    if (lease.scene() == 0) {
      EXPECT_THAT(RigsOf(lease), SizeIs(4));
    }
  }
}

}  // namespace
}  // namespace parallax
