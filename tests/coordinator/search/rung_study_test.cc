#include "coordinator/search/rung_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/config/config.h"
#include "coordinator/search/trial_space.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/training_seed.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<v1::SearchTrial> TrialsOf(const v1::StudySpec& search) {
  const auto trials = ProposeTrials(search, search.search().trials());
  EXPECT_TRUE(trials.ok()) << trials.status();
  return trials.ok() ? *trials : std::vector<v1::SearchTrial>();
}

TEST(RungStudy, IsAnOrdinaryStudyOfTheDefaultAndTheTrials) {
  const v1::StudySpec search = SmallSearch(3);
  const auto study = RungStudy(search, 0, TrialsOf(search));
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->name(), "recipe-rung1");
  EXPECT_EQ(study->seed(), search.seed());
  EXPECT_FALSE(study->has_search());
  std::vector<std::string> names;
  for (const v1::VariantSpec& variant : study->variants()) names.push_back(variant.name());
  EXPECT_THAT(names, ElementsAre("default", "trial-001", "trial-002", "trial-003"));
  EXPECT_EQ(study->pairs(), 2);
  EXPECT_EQ(study->train().steps(), 25);
  EXPECT_EQ(study->train().seeds(), 2);
  EXPECT_THAT(study->evaluate().benchmarks(), ElementsAre("shipped"));
  EXPECT_TRUE(study->evaluate().baselines().empty());
  EXPECT_TRUE(CheckStudySpec(*study).ok());
  EXPECT_TRUE(ValidateStudy(*study).ok()) << ValidateStudy(*study);
}

TEST(RungStudy, ScalesPairsInWholeScenesAndStepsAndSeedsAsTheRungSays) {
  v1::StudySpec search = SmallSearch();
  search.set_pairs(20);
  search.set_rigs_per_scene(3);
  const struct {
    double share;
    int64_t pairs;
  } cases[] = {{0.001, 3}, {0.25, 6}, {0.5, 9}, {0.9, 18}, {1, 20}};
  for (const auto& one : cases) {
    search.mutable_search()->clear_rungs();
    search.mutable_search()->add_rungs()->set_pairs(one.share);
    EXPECT_EQ(PairsOfRung(search, 0), one.pairs) << one.share;
  }
  v1::SearchRung& rung = *search.mutable_search()->mutable_rungs(0);
  rung.set_seeds(5);
  rung.set_steps(0.001);
  search.mutable_train()->set_steps(0);
  search.mutable_train()->set_minutes(4);
  const auto study = RungStudy(search, 0, {v1::SearchTrial()});
  ASSERT_TRUE(study.ok());
  EXPECT_EQ(study->train().seeds(), 5);
  EXPECT_EQ(study->train().steps(), 0);
  EXPECT_DOUBLE_EQ(study->train().minutes(), 0.004);
}

TEST(ConfirmStudy, HasOtherScenesAndTheBenchmarksThatTheSearchHasNotSeen) {
  v1::StudySpec search = SmallSearch();
  search.mutable_search()->mutable_confirm()->set_seeds(4);
  const std::vector<v1::SearchTrial> trials = TrialsOf(search);
  const auto study = ConfirmStudy(search, trials[5]);
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->name(), "recipe-confirm");
  EXPECT_NE(study->seed(), search.seed());
  for (int i = 0; i < 4; ++i) EXPECT_GE(TrainingSeed(*study, i), 100u);
  ASSERT_EQ(study->variants_size(), 2);
  EXPECT_EQ(study->variants(1).name(), "trial-005");
  EXPECT_EQ(study->pairs(), search.pairs());
  EXPECT_EQ(study->train().steps(), 100);
  EXPECT_EQ(study->train().seeds(), 4);
  EXPECT_THAT(study->evaluate().benchmarks(), ElementsAre("eth3d"));
  EXPECT_TRUE(ValidateStudy(*study).ok()) << ValidateStudy(*study);
}

TEST(TrainingSeed, IsTheTrainingsNumberUnlessTheStudysSeedIsLarge) {
  v1::StudySpec study;
  for (const uint64_t seed : {uint64_t{0}, uint64_t{7}, uint64_t{0xffffffff}}) {
    study.set_seed(seed);
    EXPECT_EQ(TrainingSeed(study, 3), 3u) << seed;
  }
  std::set<uint64_t> seen;
  for (const uint64_t high : {uint64_t{1}, uint64_t{2}, uint64_t{0xffffffff}}) {
    study.set_seed(high << 32);
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(seen.insert(TrainingSeed(study, i)).second) << high << ", " << i;
    }
  }
  EXPECT_GE(*seen.begin(), 100u);
  EXPECT_LT(*seen.rbegin(), uint64_t{1} << 31);
}

TEST(RungStudy, TakesOwnAndHeldOutPairsOnlyWhereTheyAreAskedFor) {
  v1::StudySpec search = SmallSearch();
  v1::OwnBenchmark& own = *search.mutable_evaluate()->add_own_benchmarks();
  own.set_name("camera");
  own.set_list("pairs/list.txt");
  search.mutable_evaluate()->set_heldout_pairs(4);
  ResolveTraining(&search);
  EXPECT_THAT(SearchedBenchmarks(search), ElementsAre("shipped", "camera"));
  search.mutable_search()->add_benchmarks("camera");
  auto study = RungStudy(search, 0, TrialsOf(search));
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_TRUE(study->evaluate().benchmarks().empty());
  EXPECT_EQ(study->evaluate().own_benchmarks_size(), 1);
  EXPECT_EQ(study->variants_size(), 9);
  *search.mutable_search()->mutable_benchmarks(0) = "heldout";
  study = RungStudy(search, 0, TrialsOf(search));
  ASSERT_TRUE(study.ok());
  EXPECT_TRUE(study->evaluate().own_benchmarks().empty());
  ASSERT_EQ(study->variants_size(), 10);
  EXPECT_TRUE(study->variants(9).heldout());
}

TEST(CheckSearch, RefusesWhatCannotBeSearchedByName) {
  const auto refusal = [](const std::function<void(v1::StudySpec&)>& change) {
    v1::StudySpec study = SmallSearch();
    change(study);
    return std::string(CheckSearch(study).message());
  };
  EXPECT_TRUE(CheckSearch(SmallSearch()).ok());
  EXPECT_THAT(refusal([](auto& study) { study.clear_search(); }), HasSubstr("has no `search`"));
  EXPECT_THAT(refusal([](auto& study) { study.add_variants()->set_name("more"); }),
              HasSubstr("2 variants, wanted 1"));
  const absl::Status submitted = CheckStudySpec(SmallSearch());
  EXPECT_THAT(std::string(submitted.message()),
              HasSubstr("`parallax search FILE` begins a search"));
}

TEST(TrialsAtOnce, SamplersBeginWithAFewToLearnFrom) {
  v1::StudySpec search = SmallSearch(30);
  EXPECT_EQ(TrialsAtOnce(search), 30);
  search.mutable_search()->set_sampler("optuna");
  EXPECT_EQ(TrialsAtOnce(search), 8);
  search.mutable_search()->set_trials(3);
  EXPECT_EQ(TrialsAtOnce(search), 3);
  search.mutable_search()->set_trials(9);
  EXPECT_EQ(TrialsAtOnce(search), 4);
}

}  // namespace
}  // namespace parallax
