#include "coordinator/search/search_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <set>

#include "common/base/rng.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/study/keys.h"
#include "tests/coordinator/search/search_keeper_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(SearchKeeperTest, FindsTheDirectionAndConfirmsIt) {
  const v1::SearchStatus begun = Open(SmallSearch());
  EXPECT_EQ(begun.state(), "running");
  EXPECT_EQ(begun.trials_size(), 9);
  EXPECT_EQ(begun.rungs(), 3);
  EXPECT_EQ(begun.study().name(), "recipe");
  EXPECT_THAT(begun.studies(), ElementsAre(1));
  EXPECT_FALSE(begun.has_best());
  RunToItsEnd();
  const v1::SearchStatus ended = Status();
  EXPECT_EQ(ended.state(), "ended");
  EXPECT_EQ(ended.outcome(), "confirmed");
  EXPECT_EQ(ended.needs(), "");
  EXPECT_EQ(ended.waits_for(), "all rungs have ended");
  EXPECT_THAT(ended.studies(), ElementsAre(1, 2, 3, 4));
  ASSERT_GT(ended.best(), 0);
  const v1::SearchTrial& best = ended.trials(ended.best());
  EXPECT_EQ(best.scores_size(), 3);
  for (const v1::SearchTrial& trial : ended.trials()) {
    EXPECT_LE(best.scores(0).objective().value(), trial.scores(0).objective().value());
  }
  EXPECT_EQ(ended.confirmation().verdict(), "better");
  ASSERT_EQ(ended.importances_size(), 3);
  EXPECT_EQ(ended.importances(0).path(), "floating.count");
  // Rungs are scored on what is searched, the confirmation on what is held out.
  ASSERT_EQ(queries_.size(), 4u);
  EXPECT_THAT(queries_[2].benchmarks, ElementsAre("shipped"));
  EXPECT_THAT(queries_[3].benchmarks, ElementsAre("eth3d"));
  // 9, 5 and 3 variants have 2, 4 and 8 pairs, whose first ones are those of the rung before; the
  // confirmation has 2 of 8. Trainings take 3 s of two threads, scores 2 s. A scene has two pairs;
  // all variants have its layout.
  const int pairs = 9 * 2 + 5 * 2 + 3 * 4 + 2 * 8;
  EXPECT_NEAR(
      ended.core_hours(),
      (36.0 * pairs + 7.0 * pairs / 2 + 5.0 * (4 + 4) + (9 + 5 + 3 + 2) * 2 * 2 * (3 + 2)) / 3600,
      1e-9);
  // No training of the confirmation has the seed of one before.
  std::set<std::string> seeds;
  for (const v1::JobStatus& job : ListJobs(StudyId{4})) {
    if (job.kind() == "train") seeds.insert(job.label().substr(job.label().rfind(' ') + 1));
  }
  EXPECT_EQ(seeds.size(), 2u);
  for (const std::string& seed : seeds) EXPECT_GE(std::stoll(seed), 100);
}

TEST_F(SearchKeeperTest, RungsTakeOverThePairsOfTheRungBefore) {
  Open(SmallSearch());
  RunToItsEnd();
  const v1::StudyStatus second = *queue_->GetStudy(StudyId{2});
  for (const v1::VariantStatus& variant : second.variants()) {
    EXPECT_EQ(variant.pairs_done(), 4);
    EXPECT_EQ(variant.frames_reused(), 2);
  }
}

// The kill test: whatever is killed at whichever moment, the record has the same bytes at the end.
TEST_F(SearchKeeperTest, FiveHundredKillsGiveTheRecordOfACalmRun) {
  int kills = 0;
  for (const uint64_t seed : {1u, 2u, 3u, 4u}) {
    v1::StudySpec study = SmallSearch();
    study.set_seed(seed);
    study.mutable_search()->set_points_per_core_s(0.01);
    std::string calm;
    for (const bool is_calm : {true, false}) {
      BeginAnew();
      clock_.JumpWall(1.8e9 - clock_.UnixSeconds());
      Open(study);
      if (is_calm) {
        RunToItsEnd();
        calm = DeterministicBytes(Record());
        continue;
      }
      Rng rng(SceneSeed{seed}, "kills");
      for (int step = 0; step < 5000 && Status().state() != "ended"; ++step) {
        Work(1);
        const v1::SearchRecord before = Record();
        TickSearches();
        ++kills;
        // It dies before the step is entered in its record, or after it.
        if (rng.Bernoulli(0.5)) {
          ASSERT_TRUE(queue_->KeepSearch(before).ok());
        }
        rng.Bernoulli(0.1) ? Restart() : ForgetAll();
        if (rng.Bernoulli(0.1)) Open(study);
      }
      EXPECT_EQ(Status().state(), "ended");
      EXPECT_EQ(StudiesOfQueue(), 4);
      EXPECT_EQ(DeterministicBytes(Record()), calm) << "calm and killed differ, seed " << seed;
    }
  }
  EXPECT_GE(kills, 500);
}

TEST_F(SearchKeeperTest, MoreTrialsGoOnWithAllResultsThatAreThere) {
  Open(SmallSearch(4));
  RunToItsEnd();
  const double before = Status().core_hours();
  const v1::SearchStatus more = Open(SmallSearch(8));
  EXPECT_EQ(more.state(), "running");
  EXPECT_EQ(more.trials_size(), 9);
  EXPECT_EQ(more.outcome(), "");
  EXPECT_EQ(more.core_hours(), before);
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
  // The first rung makes the pairs of the four new trials only.
  const v1::StudyStatus first = *queue_->GetStudy(StudyId{Status().studies(0)});
  for (int i = 0; i < first.variants_size(); ++i) {
    EXPECT_EQ(first.variants(i).frames_reused(), i < 5 ? 2 : 0) << first.variants(i).name();
  }
  EXPECT_GT(Status().core_hours(), before);
  const auto fewer = keeper_->Open(SmallSearch(4), "tester");
  EXPECT_TRUE(absl::IsAlreadyExists(fewer.status()));
  EXPECT_THAT(std::string(fewer.status().message()), HasSubstr("has 8 trials already"));
}

TEST_F(SearchKeeperTest, ARungThatTheBudgetHasNotWaitsForALargerOne) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->set_core_hours(0.3);
  Open(study);
  RunToItsEnd();
  const v1::SearchStatus status = Status();
  EXPECT_THAT(status.waits_for(), HasSubstr("core-hours, core_hours is 0.3"));
  EXPECT_EQ(status.trials(status.best()).scores_size(), 1);
  EXPECT_EQ(status.outcome(), "confirmed");
  study.mutable_search()->set_core_hours(100);
  study.set_source_yaml("study: recipe  # With a larger budget.\n");
  EXPECT_EQ(Open(study).state(), "running");
  RunToItsEnd();
  EXPECT_EQ(Status().trials(Status().best()).scores_size(), 3);
  EXPECT_EQ(Status().trials(0).scores_size(), 3);
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SearchKeeperTest, TheDefaultAsTheBestNeedsNoConfirmation) {
  v1::StudySpec study = SmallSearch();
  study.mutable_variants(0)->mutable_config()->mutable_floating()->mutable_count()->set_constant(
      30);
  Open(study);
  RunToItsEnd();
  EXPECT_EQ(Status().best(), 0);
  EXPECT_EQ(Status().outcome(), "not confirmed");
  EXPECT_FALSE(Status().has_confirmation());
  EXPECT_EQ(Record().confirm_study(), 0);
}

TEST_F(SearchKeeperTest, WithoutAConfirmationItEndsWithTheRungs) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->mutable_confirm()->set_enabled(false);
  Open(study);
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "");
  EXPECT_EQ(Status().studies_size(), 3);
  EXPECT_GT(Status().best(), 0);
}

TEST_F(SearchKeeperTest, TimeCountsAgainstTrialsAsTheStudySays) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->set_points_per_core_s(0.5);
  Open(study);
  Work();
  TickSearches();
  ASSERT_EQ(queries_.size(), 1u);
  // A pair's own time, and half of its scene's and its layout's, also of those that the variants
  // share.
  EXPECT_NEAR(queries_[0].points.at("default"), 0.5 * (36 + 3.5 + 2.5), 1e-9);
  EXPECT_NEAR(Status().trials(1).scores(0).core_s_per_pair(), 36 + 3.5 + 2.5, 1e-9);
}

TEST_F(SearchKeeperTest, ARungWhoseDefaultFailsNeedsAPersonAndGoesOnAfterIt) {
  broken_ = {"default", "trial-002"};
  Open(SmallSearch());
  Work();
  TickSearches();
  EXPECT_EQ(Status().state(), "failed");
  EXPECT_THAT(Status().needs(), HasSubstr("rung 1 failed: `parallax retry 1` tries again: variant "
                                          "default: train default, seed "));
  broken_.clear();
  ASSERT_TRUE(queue_->Retry(StudyId{1}, "tester").ok());
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
  EXPECT_EQ(Status().trials(2).scores(0).rung(), 0);
}

TEST_F(SearchKeeperTest, ATrialWhoseTrainingsFailEndsAndTheOthersGoOn) {
  broken_ = {"trial-002"};
  Open(SmallSearch());
  RunToItsEnd();
  EXPECT_THAT(Status().trials(2).ended(), HasSubstr("rung 1: train trial-002, seed "));
  EXPECT_THAT(Status().trials(2).ended(), HasSubstr("out of paper"));
  EXPECT_EQ(Status().trials(2).scores_size(), 0);
  EXPECT_THAT(queries_[0].without, ElementsAre("trial-002"));
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SearchKeeperTest, WhereAllTrialsFailOrTheConfirmationAPersonLooks) {
  v1::StudySpec study = SmallSearch(3);
  broken_ = {"trial-001", "trial-002", "trial-003"};
  Open(study);
  Work();
  TickSearches();
  EXPECT_EQ(Status().state(), "failed");
  EXPECT_THAT(Status().needs(), HasSubstr("rung 1 failed: `parallax retry 1`"));
  broken_.clear();
  ASSERT_TRUE(queue_->Retry(StudyId{1}, "tester").ok());
  for (int i = 0; i < 50 && Status().state() != "confirming"; ++i) {
    Work();
    TickSearches();
  }
  broken_ = {TrialName(Status().best())};
  for (int i = 0; i < 3; ++i) {
    Work();
    TickSearches();
  }
  EXPECT_THAT(Status().needs(), HasSubstr("the confirmation failed: `parallax retry "));
  EXPECT_EQ(Status().outcome(), "");
}

TEST_F(SearchKeeperTest, PeopleLookWhileScoresAreRead) {
  Open(SmallSearch());
  Work();
  std::future<v1::SearchStatus> seen;
  while_scoring_ = [&] {
    seen = std::async(std::launch::async, [this] { return Status(); });
    EXPECT_EQ(seen.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  };
  TickSearches();
  EXPECT_EQ(seen.get().waits_for(), "the scores of study 1 are read");
  EXPECT_EQ(Status().trials(0).scores_size(), 1);
}

TEST_F(SearchKeeperTest, ScoresOfASearchThatWasStoppedMeanwhileAreLeft) {
  Open(SmallSearch());
  Work();
  while_scoring_ = [&] { ASSERT_TRUE(keeper_->Stop("recipe", "", false).ok()); };
  TickSearches();
  EXPECT_EQ(Status().state(), "stopped");
  EXPECT_EQ(Status().trials(0).scores_size(), 0);
}

TEST_F(SearchKeeperTest, ATrialWithoutAnyValidSceneEndsAndTheOthersGoOn) {
  gave_up_ = {"trial-003"};
  Open(SmallSearch());
  RunToItsEnd();
  EXPECT_THAT(Status().trials(3).ended(), HasSubstr("rung 1: no valid scene"));
  EXPECT_EQ(Status().trials(3).scores_size(), 0);
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SearchKeeperTest, APausedOrCancelledRungSaysWhatToDo) {
  Open(SmallSearch());
  ASSERT_TRUE(queue_->Pause(StudyId{1}, "", "tester").ok());
  TickSearches();
  EXPECT_EQ(Status().needs(), "rung 1 is paused: `parallax resume 1`");
  EXPECT_EQ(Status().state(), "running");
  ASSERT_TRUE(queue_->Resume(StudyId{1}, "", "tester").ok());
  TickSearches();
  EXPECT_EQ(Status().needs(), "");
  EXPECT_EQ(Status().waits_for(), "rung 1 (study 1) is being made");
  ASSERT_TRUE(queue_->Cancel(StudyId{1}, "", "tester").ok());
  TickSearches();
  EXPECT_THAT(Status().needs(), HasSubstr("rung 1 (study 1) was cancelled: `parallax search recipe "
                                          "--stop`, and begin it again"));
  // That helps.
  ASSERT_TRUE(keeper_->Stop("recipe", "", false).ok());
  Open(SmallSearch());
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SearchKeeperTest, AStoreThatIsGoneIsSaidAndWaitedFor) {
  Open(SmallSearch());
  Work();
  store_is_there_ = false;
  TickSearches();
  EXPECT_THAT(Status().needs(),
              HasSubstr("the scores of study 1 can't be read: the store is gone"));
  store_is_there_ = true;
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SearchKeeperTest, AStoppedSearchDoesNothingAndGoesOnWhenItIsOpenedAgain) {
  Open(SmallSearch());
  Work(20);
  const auto stopped = keeper_->Stop("recipe", "the paper is due", false);
  ASSERT_TRUE(stopped.ok()) << stopped.status();
  EXPECT_EQ(stopped->state(), "stopped");
  EXPECT_EQ(stopped->waits_for(), "the paper is due");
  EXPECT_EQ(queue_->GetStudy(StudyId{1})->state(), v1::STUDY_STATE_CANCELLED);
  Restart();
  TickSearches();
  EXPECT_EQ(Work(), 0);
  EXPECT_EQ(StudiesOfQueue(), 1);
  EXPECT_EQ(Open(SmallSearch()).state(), "running");
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
  EXPECT_EQ(Status().studies(0), 2);
}

TEST_F(SearchKeeperTest, AForgottenSearchLeavesNothingAndItsName) {
  Open(SmallSearch());
  Work(20);
  const auto held = Lease(Everyman("w"), 1);
  ASSERT_TRUE(keeper_->Stop("recipe", "", true).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(keeper_->Open(SmallSearch(), "tester").status()));
  ForgetAll();
  TickSearches();
  EXPECT_TRUE(absl::IsNotFound(keeper_->List("recipe").status()));
  EXPECT_EQ(StudiesOfQueue(), 0);
  EXPECT_EQ(Open(SmallSearch()).state(), "running");
}

TEST_F(SearchKeeperTest, TheSameStudyAgainIsTheSameSearchAndAnotherIsRefused) {
  Open(SmallSearch());
  const std::string before = DeterministicBytes(Record());
  Open(SmallSearch());
  EXPECT_EQ(DeterministicBytes(Record()), before);
  v1::StudySpec other = SmallSearch();
  other.set_seed(9);
  const auto refused = keeper_->Open(other, "tester");
  EXPECT_TRUE(absl::IsAlreadyExists(refused.status())) << refused.status();
  EXPECT_THAT(std::string(refused.status().message()),
              HasSubstr("with other settings than trials and core_hours"));
  EXPECT_THAT(std::string(keeper_->List("none").status().message()),
              HasSubstr("search \"none\" is not known; known are: recipe"));
  EXPECT_EQ(*keeper_->OpenedBy("recipe"), "submitter ada ipv4:1");
}

TEST_F(SearchKeeperTest, ListsAllWithoutTheirTrials) {
  Open(SmallSearch());
  const auto all = keeper_->List("");
  ASSERT_TRUE(all.ok());
  ASSERT_EQ(all->size(), 1u);
  EXPECT_EQ(all->front().name(), "recipe");
  EXPECT_THAT(all->front().trials(), IsEmpty());
  EXPECT_FALSE(all->front().has_study());
}

TEST_F(SearchKeeperTest, AUsersLimitIsSaidAndWaitedFor) {
  options_.limits = *LimitRules::Parse("default: {max_studies: 1}\n", "limits.yaml");
  Restart();
  Submit({.name = "other"});
  ASSERT_TRUE(queue_->Submit(MakeStudy({.name = "adas"}), "submitter ada ipv4:1").ok());
  EXPECT_THAT(Open(SmallSearch()).needs(), HasSubstr("its next study can't be submitted: "));
  Work();
  TickSearches();
  EXPECT_EQ(Status().needs(), "");
  EXPECT_EQ(Status().studies_size(), 1);
}

TEST_F(SearchKeeperTest, WithoutAScorerNothingBegins) {
  SearchKeeper blind(*queue_, clock_, nullptr);
  const auto refused = blind.Open(SmallSearch(), "tester");
  EXPECT_TRUE(absl::IsFailedPrecondition(refused.status())) << refused.status();
  Open(SmallSearch());
  Work();
  SearchKeeper viewer(*queue_, clock_, nullptr);
  EXPECT_TRUE(viewer.Tick().ok());
  EXPECT_EQ(viewer.List("recipe")->front().trials(0).scores_size(), 0);
}

TEST_F(SearchKeeperTest, AStopThatIsBrokenOffLeavesNothingThatRunsUnseen) {
  FailingCommand failing(options_);
  Restart();
  for (const char* command : {"cancel", "search"}) {
    Open(SmallSearch());
    failing.Set(command);
    EXPECT_FALSE(keeper_->Stop("recipe", "", false).ok()) << command;
    failing.Clear();
    Restart();
    TickSearches();
    EXPECT_EQ(Status().state(), "running") << command << ": not stopped, so it is not said to be";
    ASSERT_TRUE(keeper_->Stop("recipe", "", false).ok());
    EXPECT_EQ(Status().state(), "stopped");
    EXPECT_EQ(Work(), 0) << command;
  }
}

TEST_F(SearchKeeperTest, ForgettingRemovesAStudyThatWasSubmittedAndNotEntered) {
  auto kept = std::make_shared<std::atomic<int>>(0);
  auto refuses = std::make_shared<std::atomic<bool>>(false);
  options_.fail_point = [kept, refuses](const std::string& command, int) {
    const bool fails = (command == "search" && ++*kept == 2) || (*refuses && command == "submit");
    return fails ? Internal("fail point") : absl::OkStatus();
  };
  Restart();
  EXPECT_FALSE(keeper_->Open(SmallSearch(), "submitter ada ipv4:1").ok());
  Restart();
  ASSERT_EQ(StudiesOfQueue(), 1);
  ASSERT_EQ(Record().rung_studies_size(), 0);
  *refuses = true;
  ASSERT_TRUE(keeper_->Stop("recipe", "", true).ok());
  *refuses = false;
  for (int i = 0; i < 2; ++i) TickSearches();
  EXPECT_TRUE(absl::IsNotFound(keeper_->List("recipe").status()));
  EXPECT_EQ(StudiesOfQueue(), 0);
}

}  // namespace
}  // namespace parallax
