#include "coordinator/search/trial_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/config/search/search_values.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/sobol.h"
#include "coordinator/study/keys.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::HasSubstr;

TEST(SobolPoints, HaveOneCoordinateInEachIntervalOfEachDimension) {
  for (const uint64_t seed : {1u, 2u, 77u}) {
    for (const size_t count : {16u, 64u}) {
      const auto points = SobolPoints(seed, count, 24);
      ASSERT_EQ(points.size(), count);
      for (size_t d = 0; d < 24; ++d) {
        std::set<size_t> intervals;
        for (const auto& point : points) {
          ASSERT_GT(point[d], 0);
          ASSERT_LT(point[d], 1);
          intervals.insert(static_cast<size_t>(point[d] * static_cast<double>(count)));
        }
        EXPECT_EQ(intervals.size(), count) << "dimension " << d;
      }
    }
  }
}

TEST(SobolPoints, CoverPairsOfDimensionsMoreEvenlyThanChance) {
  // The first two dimensions are a net: each of the 8 x 8 fields has one of 64 points.
  std::set<int> fields;
  for (const auto& point : SobolPoints(5, 64, 2)) {
    fields.insert(static_cast<int>(point[0] * 8) * 8 + static_cast<int>(point[1] * 8));
  }
  EXPECT_EQ(fields.size(), 64u);
}

TEST(SobolPoints, BeginWithTheSameOnesAndDifferBySeed) {
  const auto few = SobolPoints(3, 8, 5), many = SobolPoints(3, 100, 5);
  for (size_t i = 0; i < few.size(); ++i) EXPECT_EQ(few[i], many[i]);
  EXPECT_NE(few, SobolPoints(4, 8, 5));
}

SearchSpace OneField(double low, double high, bool integer, bool log) {
  v1::SearchSpec search;
  AddRange(search, "field", low, high, integer, log);
  return search.space();
}

TEST(TrialSpace, MapsTheUnitIntervalToRanges) {
  const struct {
    double low, high;
    bool integer, log;
    double at;
    std::string yaml;
  } cases[] = {
      {0, 40, true, false, 0.0001, "0"},
      {0, 40, true, false, 0.9999, "40"},
      {0, 40, true, false, 0.5, "20"},
      {2, 4, true, false, 0.34, "3"},
      {0.05, 0.5, false, false, 0, "0.05"},
      {0.05, 0.5, false, false, 1, "0.5"},
      {1, 100, false, true, 0.5, "10"},
      {1, 100, false, false, 0.5, "50.5"},
      {0.1, 0.123456789, false, false, 0.999999999, "0.123456789"},
      {-2, 2, false, false, 0.25, "-1"},
      {1, 7, true, true, 0.0001, "1"},
  };
  for (const auto& one : cases) {
    const SearchSpace space = OneField(one.low, one.high, one.integer, one.log);
    const SearchValues values = ValuesAt(space, std::vector<double>{one.at});
    ASSERT_EQ(values.size(), 1);
    EXPECT_EQ(values[0].yaml(), one.yaml) << one.low << " to " << one.high << " at " << one.at;
  }
}

TEST(TrialSpace, FindsTheWayBackIntoTheRange) {
  for (const bool log : {false, true}) {
    const SearchSpace space = OneField(0.5, 50, /*integer=*/false, log);
    for (const double at : {0.1, 0.5, 0.93}) {
      const SearchValues values = ValuesAt(space, std::vector<double>{at});
      EXPECT_NEAR(PlaceInRange(space[0], values[0].yaml()), at, 1e-5);
    }
  }
}

TEST(TrialSpace, AFieldIsVariedOnlyWhereItsConditionsHold) {
  v1::SearchSpec search;
  const auto only_where = [&](const std::string& path, const std::vector<std::string>& values) {
    v1::SearchCondition& when = *search.mutable_space()->rbegin()->add_when();
    when.set_path(path);
    for (const std::string& value : values) when.add_values(value);
  };
  AddChoices(search, "mode", {"none", "all", "glass"});
  AddChoices(search, "kind", {"flat", "deep"});
  only_where("mode", {"all", "glass"});
  AddRange(search, "depth", 0, 1);
  only_where("kind", {"deep"});
  AddRange(search, "last", 0, 1);
  const auto paths = [&](double mode, double kind) {
    std::vector<std::string> paths;
    const SearchValues values = ValuesAt(search.space(), std::vector<double>{mode, kind, 0.3, 0.7});
    for (const v1::SearchValue& value : values) paths.push_back(value.path());
    // Its own coordinate, as if all were varied.
    EXPECT_EQ(values.rbegin()->yaml(), "0.7");
    return paths;
  };
  EXPECT_THAT(paths(0.1, 0.9), testing::ElementsAre("mode", "last"));
  EXPECT_THAT(paths(0.5, 0.1), testing::ElementsAre("mode", "kind", "last"));
  EXPECT_THAT(paths(0.9, 0.9), testing::ElementsAre("mode", "kind", "depth", "last"));
}

TEST(ProposeTrials, AreConfigsOfTheSpaceAndBeginAlikeHoweverMany) {
  const auto few = ProposeTrials(SmallSearch(), 4), many = ProposeTrials(SmallSearch(), 32);
  ASSERT_TRUE(few.ok()) << few.status();
  ASSERT_TRUE(many.ok()) << many.status();
  ASSERT_EQ(few->size(), 5u);
  ASSERT_EQ(many->size(), 33u);
  for (size_t i = 0; i < few->size(); ++i) {
    EXPECT_EQ(DeterministicBytes((*few)[i]), DeterministicBytes((*many)[i]));
  }
  std::set<std::string> configs;
  for (const v1::SearchTrial& trial : *many) {
    EXPECT_EQ(trial.values_size(), trial.number() == 0 ? 0 : 3);
    const auto config = WithSearchValues(DefaultOf(SmallSearch()).config(), trial.values());
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_TRUE(configs.insert(DeterministicBytes(*config)).second) << trial.number();
  }
}

TEST(ProposeTrials, LeavesOutWhatIsThereAlreadyOrForbidden) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->clear_space();
  AddChoices(*study.mutable_search(), "materials.mode", {"none", "all"});
  AddRange(*study.mutable_search(), "rigs.count", 1, 4, /*integer=*/true);
  const auto trials = ProposeTrials(study, 16);
  ASSERT_TRUE(trials.ok()) << trials.status();
  // A study of two rigs a scene can't have fewer; one of the others may be the default's config.
  EXPECT_GE(trials->size(), 6u);
  EXPECT_LE(trials->size(), 7u);
  for (const v1::SearchTrial& trial : *trials) {
    const std::string* rigs = ValueOf(trial.values(), "rigs.count");
    if (rigs != nullptr) {
      EXPECT_GE(std::stoi(*rigs), 2);
    }
  }
}

TEST(ProposeTrials, ASpaceWithoutAValidTrialIsRefusedWithTheReason) {
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->clear_space();
  AddRange(*study.mutable_search(), "floating.count", -9, -5, /*integer=*/true);
  const auto trials = ProposeTrials(study, 8);
  EXPECT_TRUE(absl::IsInvalidArgument(trials.status())) << trials.status();
  EXPECT_THAT(std::string(trials.status().message()),
              HasSubstr("search.space of study 'recipe': no point of it is a valid trial; the "
                        "first: floating.count"));
}

}  // namespace
}  // namespace parallax
