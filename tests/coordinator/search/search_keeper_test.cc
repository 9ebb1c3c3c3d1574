#include "coordinator/search/search_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/rng.h"
#include "common/base/system/file.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/study/keys.h"
#include "tests/coordinator/queue/train_fixture.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Objectives of a farm where 30 floating objects are the best, and more is known on later rungs.
class SearchKeeperTest : public QueueTest {
 protected:
  void SetUp() override {
    QueueTest::SetUp();
    Restart();
  }
  void TearDown() override {
    keeper_.reset();
    QueueTest::TearDown();
  }

  // A kill of the coordinator: nothing is left but the database.
  void Restart() {
    keeper_.reset();
    Reopen();
    ForgetAll();
  }
  // Nothing is left of the keeper.
  void ForgetAll() {
    keeper_ = std::make_unique<SearchKeeper>(
        *queue_, clock_, [this](const ScoreQuery& query) { return ScoresOf(query); }, samplers_);
  }

  absl::StatusOr<std::vector<TrialScore>> ScoresOf(const ScoreQuery& query) {
    if (!store_is_there_) return Unavailable("the store is gone");
    ASSIGN_OR_RETURN(const v1::StudyStatus study, queue_->GetStudy(StudyId{query.study}));
    queries_.push_back(query);
    std::vector<TrialScore> scores;
    for (const v1::VariantSpec& variant : study.spec().variants()) {
      if (gave_up_.count(variant.name()) > 0) continue;
      const double count = variant.config().floating().count().constant();
      const auto points = query.points.find(variant.name());
      TrialScore& score = scores.emplace_back();
      score.variant = variant.name();
      score.objective.set_value(20 + std::abs(count - 30) / 10 +
                                (points == query.points.end() ? 0 : points->second));
      score.difference.set_value(score.objective.value() - scores[0].objective.value());
      score.verdict = score.difference.value() < -0.5  ? "better"
                      : score.difference.value() > 0.5 ? "worse"
                                                       : "not significant";
    }
    return scores;
  }

  v1::SearchStatus Open(const v1::StudySpec& study) {
    const auto status = keeper_->Open(study, "submitter ada ipv4:1");
    EXPECT_TRUE(status.ok()) << status.status();
    return status.ok() ? *status : v1::SearchStatus();
  }
  v1::SearchStatus Status() {
    const auto list = keeper_->List("recipe");
    EXPECT_TRUE(list.ok()) << list.status();
    return list.ok() ? list->front() : v1::SearchStatus();
  }
  v1::SearchRecord Record() {
    const auto records = queue_->ListSearches();
    EXPECT_TRUE(records.ok() && records->size() == 1);
    return records.ok() && !records->empty() ? records->front() : v1::SearchRecord();
  }
  void TickSearches() {
    const absl::Status status = keeper_->Tick();
    EXPECT_TRUE(status.ok()) << status;
  }

  // Answers a lease; each pair took 36 core-seconds.
  void Finish(const v1::Lease& lease) {
    v1::CompleteRequest answer = AnyAnswer(lease, "w");
    if (lease.kind() == "solve" && gave_up_.count(lease.variant()) > 0) {
      answer = RejectAnswer(lease, "w", false);
    }
    v1::RenderResult result;
    if (lease.kind() == "render" && result.ParseFromString(answer.result())) {
      for (v1::FrameResult& frame : *result.mutable_frames()) {
        (*frame.mutable_stage_s())["cpu"] = 36;
      }
      SetResult(result, answer);
    }
    EXPECT_EQ(Complete(answer), v1::REPORT_OUTCOME_OK);
  }
  // Does at most so many jobs; returns how many it did.
  int Work(int most = 1'000'000) {
    int jobs = 0;
    while (jobs < most) {
      const auto leases = Lease(Everyman("w"), std::min(8, most - jobs));
      if (leases.empty()) break;
      for (const v1::Lease& lease : leases) Finish(lease);
      jobs += static_cast<int>(leases.size());
    }
    return jobs;
  }
  // Works until the search is over.
  void RunToItsEnd() {
    for (int i = 0; i < 50; ++i) {
      Work();
      TickSearches();
      const std::string state = Status().state();
      if (state == "ended" || state == "stopped") return;
    }
    FAIL() << Status().DebugString();
  }
  int StudiesOfQueue() {
    const auto studies = queue_->ListStudies(1000);
    EXPECT_TRUE(studies.ok());
    return studies.ok() ? static_cast<int>(studies->size()) : -1;
  }

  std::unique_ptr<SearchKeeper> keeper_;
  std::vector<ScoreQuery> queries_;
  bool store_is_there_ = true;
  std::set<std::string> gave_up_;  // Variants without any valid scene.
  std::map<std::string, Sampler> samplers_;
};

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
  // confirmation has 2 of 8. Trainings take 3 s of two threads, scores 2 s.
  EXPECT_NEAR(ended.core_hours(),
              (36.0 * (9 * 2 + 5 * 2 + 3 * 4 + 2 * 8) + (9 + 5 + 3 + 2) * 2 * 2 * (3 + 2)) / 3600,
              1e-9);
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
      keeper_.reset();
      queue_.reset();
      for (const char* file : {"", "-wal", "-shm", ".lock"}) {
        std::filesystem::remove(options_.db_path + file);
      }
      clock_.JumpWall(1.8e9 - clock_.UnixSeconds());
      Restart();
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

// A sampler that proposes more floating objects with each trial that it hears of.
class SampledSearchTest : public SearchKeeperTest {
 protected:
  void SetUp() override {
    const std::string script =
        "n=$(grep -c '\"number\"' \"$1\"); echo $n >> asked; if [ -e broken ]; then echo no luck; "
        "exit 7;"
        " fi; for i in 1 2 3 4; do echo \"{\\\"floating.count\\\": $((2 * n + i)),"
        " \\\"rigs.baseline_m\\\": 0.$((200 + 2 * n + i)), \\\"materials.mode\\\": \\\"all\\\"}\"; "
        "done"
        " | paste -sd, | sed 's/^/{\"trials\": [/; s/$/]}/' > \"$2\"";
    samplers_["steps"] = {.name = "steps",
                          .command = {"sh", "-c", script, "sh", "{ask}", "{answer}"},
                          .directory = dir_,
                          .timeout_s = 1000};
    SearchKeeperTest::SetUp();
  }
  static v1::StudySpec Sampled(int trials) {
    v1::StudySpec study = SmallSearch(trials);
    study.mutable_search()->set_sampler("steps");
    return study;
  }
  // Works until the search is over or needs somebody; kills its keeper now and then.
  void RunSampled(uint64_t kill_seed = 0) {
    Rng rng(SceneSeed{kill_seed}, "kills");
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (Status().outcome().empty() && Status().needs().empty()) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline) << Status().DebugString();
      Work();
      TickSearches();
      if (kill_seed != 0 && rng.Bernoulli(0.1)) ForgetAll();
      if (!Status().waits_for().empty()) std::this_thread::yield();
    }
  }
};

TEST_F(SampledSearchTest, TheFirstRungGrowsByWhatTheSamplerAnswers) {
  EXPECT_EQ(Open(Sampled(12)).trials_size(), 5);
  RunSampled();
  const v1::SearchStatus ended = Status();
  EXPECT_EQ(ended.outcome(), "confirmed");
  ASSERT_EQ(ended.trials_size(), 13);
  // It heard of 4 trials, then of 8.
  EXPECT_EQ(ended.trials(5).values(0).yaml(), "9");
  EXPECT_EQ(ended.trials(12).values(0).yaml(), "20");
  EXPECT_EQ(*ReadFile(dir_ + "/asked"), "4\n8\n");
  for (const v1::SearchTrial& trial : ended.trials()) EXPECT_GE(trial.scores_size(), 1);
  EXPECT_EQ(ended.studies_size(), 4);
  EXPECT_EQ(StudiesOfQueue(), 6);
}

TEST_F(SampledSearchTest, KillsChangeNothing) {
  Open(Sampled(12));
  RunSampled();
  const std::string calm = DeterministicBytes(Record());
  keeper_.reset();
  queue_.reset();
  for (const char* file : {"", "-wal", "-shm", ".lock"}) {
    std::filesystem::remove(options_.db_path + file);
  }
  Restart();
  Open(Sampled(12));
  RunSampled(/*kill_seed=*/5);
  EXPECT_EQ(DeterministicBytes(Record()), calm);
}

TEST_F(SampledSearchTest, MoreTrialsKeepThoseThatTheSamplerProposed) {
  Open(Sampled(8));
  RunSampled();
  const v1::SearchStatus before = Status();
  Open(Sampled(12));
  RunSampled();
  ASSERT_EQ(Status().trials_size(), 13);
  for (int i = 0; i < before.trials_size(); ++i) {
    EXPECT_EQ(Status().trials(i).values_size(), before.trials(i).values_size());
    for (int j = 0; j < before.trials(i).values_size(); ++j) {
      EXPECT_EQ(Status().trials(i).values(j).yaml(), before.trials(i).values(j).yaml());
    }
  }
}

TEST_F(SampledSearchTest, ASamplerThatFailsIsSaidAndAskedAgain) {
  ASSERT_TRUE(WriteFile(dir_ + "/broken", "").ok());
  Open(Sampled(8));
  RunSampled();
  EXPECT_EQ(Status().needs(), "sampler steps: exit status 7: no luck; it is asked again in 60 s");
  EXPECT_EQ(Status().state(), "running");
  TickSearches();
  EXPECT_EQ(*ReadFile(dir_ + "/asked"), "4\n");
  std::filesystem::remove(dir_ + "/broken");
  clock_.Advance(61);
  TickSearches();
  RunSampled();
  EXPECT_EQ(Status().outcome(), "confirmed");
}

TEST_F(SampledSearchTest, ASamplerThatRepeatsItselfIsAskedNoMore) {
  samplers_["steps"].command[2] =
      "echo asked >> asked; echo '{\"trials\": [{\"floating.count\": 9, \"rigs.baseline_m\": 0.2,"
      " \"materials.mode\": \"all\"}]}' > \"$2\"";
  Restart();
  Open(Sampled(12));
  RunSampled();
  EXPECT_EQ(Status().trials_size(), 6);
  EXPECT_EQ(Status().outcome(), "confirmed");
  EXPECT_EQ(*ReadFile(dir_ + "/asked"), "asked\nasked\n");
}

TEST_F(SampledSearchTest, ABudgetThatIsUsedUpEndsTheAsking) {
  v1::StudySpec study = Sampled(12);
  study.mutable_search()->set_core_hours(0.2);
  Open(study);
  RunSampled();
  EXPECT_EQ(Status().trials_size(), 9);
  EXPECT_EQ(Status().trials(0).scores_size(), 1);
}

TEST_F(SampledSearchTest, AnUnknownSamplerIsRefusedByName) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->set_sampler("optuna");
  EXPECT_THAT(std::string(keeper_->Open(study, "tester").status().message()),
              HasSubstr("search.sampler \"optuna\" is not known here; known are: sobol, steps"));
  Open(Sampled(8));
  samplers_.clear();
  Restart();
  RunSampled();
  EXPECT_EQ(Status().needs(), "sampler \"steps\" is not known here any more");
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
  EXPECT_NEAR(queries_[0].points.at("default"), 0.5 * 36, 1e-9);
  EXPECT_NEAR(Status().trials(1).scores(0).core_s_per_pair(), 36, 1e-9);
}

TEST_F(SearchKeeperTest, AFailedRungNeedsAPersonAndGoesOnAfterIt) {
  Open(SmallSearch());
  bool has_failed = false;
  for (;;) {
    const auto leases = Lease(Everyman("w"), 8);
    if (leases.empty()) break;
    for (const v1::Lease& lease : leases) {
      if (lease.kind() == "train" && !has_failed) {
        has_failed = true;
        Fail(Failure(lease, "w", "disk full", /*retryable=*/false));
      } else {
        Finish(lease);
      }
    }
  }
  TickSearches();
  EXPECT_EQ(Status().state(), "failed");
  EXPECT_THAT(Status().needs(), HasSubstr("rung 1 failed: `parallax retry 1` tries again"));
  ASSERT_TRUE(queue_->Retry(StudyId{1}, "tester").ok());
  RunToItsEnd();
  EXPECT_EQ(Status().outcome(), "confirmed");
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

}  // namespace
}  // namespace parallax
