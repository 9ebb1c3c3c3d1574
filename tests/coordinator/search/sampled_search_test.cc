// Searches whose trials a sampler proposes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "common/base/rng.h"
#include "common/base/system/file.h"
#include "coordinator/study/keys.h"
#include "tests/coordinator/search/search_keeper_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;

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
  BeginAnew();
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

}  // namespace
}  // namespace parallax
