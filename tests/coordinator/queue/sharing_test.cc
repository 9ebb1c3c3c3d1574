// Equal work is done once: layouts between variants, scenes and frames between studies; and nothing
// gets stuck over it.
#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

class SharingTest : public QueueTest {
 protected:
  int64_t Sum(const v1::StudyStatus& status, int64_t (v1::VariantStatus::*field)() const) {
    int64_t sum = 0;
    for (const auto& variant : status.variants()) sum += (variant.*field)();
    return sum;
  }
};

TEST_F(SharingTest, ThreeVariantsSolveOneLayout) {
  const StudyId study = Submit({.pairs = 2, .variants = {"a", "b", "c"}});
  const v1::Lease leader = LeaseOne(Solver("w"));
  EXPECT_FALSE(SolveOf(leader).has_layout());
  EXPECT_THAT(Lease(Solver("v")), IsEmpty());
  EXPECT_EQ(Jobs(study, "solve", "BLOCKED"), 2);
  Complete(Answer(leader, "w"));
  const auto followers = Lease(Solver("v"), 5);
  ASSERT_THAT(followers, SizeIs(2));
  for (const v1::Lease& lease : followers) {
    ASSERT_TRUE(SolveOf(lease).has_layout());
    EXPECT_EQ(SolveOf(lease).layout().SerializeAsString(),
              SolveOf(Answer(leader, "w")).layout().SerializeAsString());
    Complete(Answer(lease, "v"));
  }
  WorkOff(AnyWorker("u"));
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::layouts_reused), 2);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::solves_reused), 0);
}

// Whatever ends the leader's lease, a follower takes over.
TEST_F(SharingTest, FollowersGoOnWhateverBecomesOfTheirLeader) {
  const struct {
    const char* what;
    std::function<void(JobQueue&, const v1::Lease&, StudyId)> end;
  } cases[] = {
      {"failed", [](auto& q, auto& l, auto) { (void)*q.Fail(Failure(l, "w", "boom", false)); }},
      {"waits to be retried",
       [](auto& q, auto& l, auto) { (void)*q.Fail(Failure(l, "w", "boom", true)); }},
      {"handed back", [](auto& q, auto& l, auto) { (void)*q.HandBack("w", l.attempt(), ""); }},
      {"lost", [](auto& q, auto&, auto) { (void)*q.WorkerLost("w"); }},
      {"rejected at dressing",
       [](auto& q, auto& l, auto) { (void)*q.Complete(RejectAnswer(l, "w", true)); }},
      {"cancelled", [](auto& q, auto&, StudyId s) { q.Cancel(s, "", "t").IgnoreError(); }},
  };
  uint64_t seed = 100;
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    ++seed;
    // One pair each, so that the leader's variant has one scene; the follower is another study of
    // lower priority.
    const StudyId first =
        Submit({.seed = seed, .pairs = 1, .rigs_per_scene = 1, .variants = {"a"}, .priority = 1});
    const StudyId second =
        Submit({.seed = seed, .pairs = 1, .rigs_per_scene = 1, .variants = {"x", "b"}});
    const v1::Lease leader = LeaseOne(Solver("w"));
    EXPECT_EQ(Jobs(second, "solve", "BLOCKED"), 2);
    c.end(*queue_, leader, first);
    EXPECT_GE(Jobs(second, "solve", "READY"), 1);
    ExpectSound();
    clock_.Advance(100);
    Tick();
    WorkOff(AnyWorker("v"));
    EXPECT_EQ(Status(second).state(), v1::STUDY_STATE_SUCCEEDED);
    ExpectSound();
  }
}

TEST_F(SharingTest, APausedStudyHoldsUpNobody) {
  const StudyId first = Submit({.pairs = 2, .priority = 5});
  const StudyId second = Submit({.pairs = 2});
  ASSERT_TRUE(queue_->Pause(first, "", "t").ok());
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);
  EXPECT_EQ(Status(second).state(), v1::STUDY_STATE_SUCCEEDED);
  ASSERT_TRUE(queue_->Resume(first, "", "t").ok());
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(first).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(SharingTest, AnEqualStudyIsFinishedWithoutWork) {
  Submit({.pairs = 5, .rigs_per_scene = 2, .variants = {"a", "b"}});
  WorkOff(AnyWorker("w"));
  const StudyId again = Submit({.pairs = 5, .rigs_per_scene = 2, .variants = {"a", "b"}});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 0);
  const v1::StudyStatus status = Status(again);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::solves_reused), 6);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::frames_reused), 10);
  for (const auto& frame : Frames(again)) EXPECT_TRUE(frame.reused());
}

TEST_F(SharingTest, AnEqualStudyAtTheSameTimeIsWorkedOnce) {
  const StudyId first = Submit({.pairs = 8, .rigs_per_scene = 2});
  const StudyId second = Submit({.pairs = 8, .rigs_per_scene = 2});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 8);  // Four solves, four renders.
  EXPECT_EQ(Status(first).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Status(second).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(SharingTest, ALargerStudyMakesOnlyWhatIsNew) {
  Submit({.pairs = 5, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  const StudyId larger = Submit({.pairs = 8, .rigs_per_scene = 2});
  // Scene 2 has one of two frames; scene 3 is new.
  const v1::Lease missing = LeaseOne(Renderer("w"));
  EXPECT_THAT(RenderOf(missing).rigs(), testing::ElementsAre(1));
  Complete(Answer(missing, "w"));
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);
  EXPECT_EQ(Status(larger).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Sum(Status(larger), &v1::VariantStatus::frames_reused), 5);
}

TEST_F(SharingTest, ARejectedLayoutRejectsItForAllVariants) {
  const StudyId study = Submit({.pairs = 1, .rigs_per_scene = 1, .variants = {"a", "b", "c"}});
  Complete(RejectAnswer(LeaseOne(Solver("w")), "w", /*with_layout=*/false));
  EXPECT_EQ(Jobs(study, "solve", "REJECTED"), 3);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(SharingTest, ARejectedDressingKeepsTheLayoutForOthers) {
  const StudyId study = Submit({.pairs = 1, .rigs_per_scene = 1, .variants = {"a", "b"}});
  Complete(RejectAnswer(LeaseOne(Solver("w")), "w", /*with_layout=*/true));
  EXPECT_EQ(Jobs(study, "solve", "REJECTED"), 1);
  const v1::Lease other = LeaseOne(Solver("w"));
  EXPECT_TRUE(SolveOf(other).has_layout());
  Complete(Answer(other, "w"));
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(SharingTest, AnotherLayoutVersionSolvesAgain) {
  Submit({.pairs = 2});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);
  options_.versions.layout = "other";
  Reopen();
  const v1::Lease solve = (Submit({.pairs = 2}), LeaseOne(Solver("w")));
  EXPECT_FALSE(SolveOf(solve).has_layout());
}

TEST_F(SharingTest, AnotherSceneVersionDressesTheLayoutsThatThereAre) {
  Submit({.pairs = 2});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);
  options_.versions.scene = "other";
  Reopen();
  Submit({.pairs = 2});
  EXPECT_TRUE(SolveOf(LeaseOne(Solver("w"))).has_layout());
}

// A change of pictures alone keeps stored layouts and recipes.
TEST_F(SharingTest, AStudyContinuedWithAnotherFrameVersionSolvesNothingAnew) {
  Submit({.pairs = 4, .rigs_per_scene = 2});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 4);
  options_.versions.frame = "other";
  Reopen();
  const StudyId again = Submit({.pairs = 6, .rigs_per_scene = 2});
  // The third scene is new; the other two have their recipes and want new pictures.
  EXPECT_EQ(Jobs(again, "solve", "READY"), 1);
  EXPECT_EQ(Jobs(again, "render", "READY"), 2);
  EXPECT_EQ(WorkOff(AnyWorker("w")), 4);
  const v1::StudyStatus status = Status(again);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::solves_reused), 2);
  EXPECT_EQ(Sum(status, &v1::VariantStatus::frames_reused), 0);
}

TEST_F(SharingTest, OtherFiltersRenderNothing) {
  v1::SubmitRequest request = MakeStudy({.pairs = 4});
  ASSERT_TRUE(queue_->Submit(request, "tester").ok());
  EXPECT_EQ(WorkOff(AnyWorker("w")), 4);
  request.mutable_study()
      ->mutable_variants(0)
      ->mutable_config()
      ->mutable_filters()
      ->set_min_depth_m(2);
  const auto again = queue_->Submit(request, "tester");
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(WorkOff(AnyWorker("w")), 0);
  EXPECT_EQ(Sum(Status(StudyId{again->study_id()}), &v1::VariantStatus::frames_reused), 4);
}

TEST_F(SharingTest, TheStorePrefixIsTheSameForEqualWork) {
  Submit({.pairs = 2});
  Complete(Answer(LeaseOne(Solver("w")), "w"));
  const v1::Lease first = LeaseOne(Renderer("w"));
  (void)*queue_->WorkerLost("w");
  const v1::Lease second = LeaseOne(Renderer("v"));
  EXPECT_EQ(first.store_prefix(), second.store_prefix());
  EXPECT_THAT(first.store_prefix(), testing::MatchesRegex("[0-9a-f]{2}/[0-9a-f]{64}"));
  Complete(Answer(second, "v"));
}

TEST_F(SharingTest, StudiesOfEqualPriorityShareTheWorkers) {
  Submit({.name = "one", .seed = 1, .pairs = 100, .rigs_per_scene = 1});
  Submit({.name = "two", .seed = 2, .pairs = 100, .rigs_per_scene = 1});
  std::map<std::string, int> served;
  for (const v1::Lease& lease : Lease(Solver("w"), 40)) ++served[lease.study()];
  EXPECT_EQ(served["one"], 20);
  EXPECT_EQ(served["two"], 20);
  // A newcomer gets its share, not the past.
  Submit({.name = "three", .seed = 3, .pairs = 100, .rigs_per_scene = 1});
  served.clear();
  for (const v1::Lease& lease : Lease(Solver("w"), 30)) ++served[lease.study()];
  EXPECT_NEAR(served["three"], 10, 1);
}

TEST_F(SharingTest, AWorkerGetsRendersOfASceneThatItHasBuilt) {
  // Two studies whose scenes are equal and whose renders differ.
  v1::SubmitRequest coarse = MakeStudy({.pairs = 6, .rigs_per_scene = 1});
  v1::SubmitRequest fine = coarse;
  fine.mutable_study()
      ->mutable_variants(0)
      ->mutable_config()
      ->mutable_render()
      ->set_samples_per_pixel(64);
  coarse.mutable_study()->set_priority(5);  // Would be served first but for the scene.
  ASSERT_TRUE(queue_->Submit(coarse, "t").ok());
  ASSERT_TRUE(queue_->Submit(fine, "t").ok());
  while (true) {
    const auto solves = Lease(Solver("s"), 10);
    if (solves.empty()) break;
    for (const auto& lease : solves) Complete(Answer(lease, "s"));
  }
  const v1::Lease first = LeaseOne(Renderer("w"));
  const v1::Lease second = LeaseOne(Renderer("w"));
  EXPECT_EQ(first.scene(), second.scene());
  EXPECT_NE(first.store_prefix(), second.store_prefix());
}

}  // namespace
}  // namespace parallax
