#include "coordinator/search/importance.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "coordinator/search/sobol.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

SearchSpace SixFields() {
  v1::SearchSpec search;
  AddRange(search, "share", 0, 1);
  AddRange(search, "count", 0, 40, /*integer=*/true);
  AddChoices(search, "mode", {"none", "all"});
  AddRange(search, "size", 1, 100, /*integer=*/false, /*log=*/true);
  AddChoices(search, "class", {"chairs", "shelves", "bushes"});
  AddRange(search, "light", -1, 1);
  v1::SearchCondition& when = *search.mutable_space(5)->add_when();
  when.set_path("mode");
  when.add_values("all");
  return search.space();
}

// Trials at Sobol' points, whose objective `effect` of the values and noise of this deviation make.
std::vector<Outcome> Outcomes(uint64_t seed, size_t trials, double noise,
                              const std::function<double(const SearchValues&)>& effect) {
  const SearchSpace space = SixFields();
  Rng rng(SceneSeed{seed}, "noise");
  std::vector<Outcome> outcomes;
  for (const auto& point : SobolPoints(seed, trials, static_cast<size_t>(space.size()))) {
    const SearchValues values = ValuesAt(space, point);
    outcomes.push_back({values, 20 + effect(values) + rng.Normal(0, noise)});
  }
  return outcomes;
}

double Number(const SearchValues& values, const std::string& path) {
  const std::string* value = ValueOf(values, path);
  return value == nullptr ? 0 : std::stod(*value);
}

TEST(Importances, APlantedEffectIsRankedFirst) {
  const struct {
    const char* path;
    std::function<double(const SearchValues&)> effect;
  } cases[] = {
      {"share", [](const SearchValues& values) { return 10 * Number(values, "share"); }},
      {"mode",
       [](const SearchValues& values) { return *ValueOf(values, "mode") == "all" ? 4 : 0; }},
      {"size", [](const SearchValues& values) { return 2 * std::log(Number(values, "size")); }},
      {"class",
       [](const SearchValues& values) { return *ValueOf(values, "class") == "shelves" ? 6 : 0; }},
      {"count",  // The best is in the middle.
       [](const SearchValues& values) { return std::pow(Number(values, "count") / 10 - 2, 2); }},
  };
  for (const auto& one : cases) {
    for (const uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
      const auto importances = ImportancesOf(SixFields(), Outcomes(seed, 24, 0.5, one.effect));
      ASSERT_EQ(importances.size(), 6u);
      EXPECT_EQ(importances[0].path(), one.path) << "seed " << seed;
      EXPECT_GT(importances[0].share().value(), 0.6);
      EXPECT_GT(importances[0].share().low(), 0);
      EXPECT_LE(importances[0].share().low(), importances[0].share().value());
      EXPECT_GE(importances[0].share().high(), importances[0].share().value());
      EXPECT_LT(importances[1].share().value(), 0.4);
    }
  }
}

TEST(Importances, AFieldThatIsVariedSometimesHasTheShareOfThoseTrials) {
  const auto importances =
      ImportancesOf(SixFields(), Outcomes(3, 64, 0.1, [](const SearchValues& values) {
                      return 10 * Number(values, "light");
                    }));
  EXPECT_EQ(importances[0].path(), "light");
  EXPECT_GT(importances[0].share().value(), 0.9);
}

TEST(Importances, SettingsWithoutAnyEffectHaveHardlyAShare) {
  double sum = 0;
  int firm = 0, all = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const auto importances =
        ImportancesOf(SixFields(), Outcomes(seed, 24, 1, [](const SearchValues&) { return 0; }));
    for (const v1::SearchImportance& one : importances) {
      sum += one.share().value();
      firm += one.share().value() > 0.4;
      ++all;
    }
  }
  EXPECT_LT(sum / all, 0.06);
  EXPECT_LT(firm, all / 40);
}

TEST(Importances, NoiseIsSeldomSignificantHoweverManyChoicesThereAre) {
  v1::SearchSpec search;
  AddChoices(search, "mode", {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j"});
  constexpr int kSearches = 200;
  int significant = 0;
  for (uint64_t seed = 1; seed <= kSearches; ++seed) {
    Rng rng(SceneSeed{seed}, "noise");
    std::vector<Outcome> outcomes;
    for (const auto& point : SobolPoints(seed, 16, 1)) {
      outcomes.push_back({ValuesAt(search.space(), point), rng.Normal()});
    }
    significant += ImportancesOf(search.space(), outcomes)[0].share().low() > 0;
  }
  EXPECT_LE(significant, 0.06 * kSearches);
}

TEST(Importances, FewTrialsOrEqualObjectivesTellNothing) {
  const auto none = [](const SearchValues&) { return 0.0; };
  for (const auto& outcomes : {Outcomes(1, 2, 1, none), Outcomes(1, 24, 0, none)}) {
    for (const v1::SearchImportance& one : ImportancesOf(SixFields(), outcomes)) {
      EXPECT_EQ(one.share().value(), 0);
      EXPECT_EQ(one.share().low(), 0);
      EXPECT_EQ(one.share().high(), 1);
    }
  }
  EXPECT_EQ(ImportancesOf(SixFields(), {}).size(), 6u);
}

TEST(Importances, AreTheSameEachTime) {
  const auto outcomes = Outcomes(7, 16, 1, [](const SearchValues&) { return 0; });
  const auto first = ImportancesOf(SixFields(), outcomes);
  const auto second = ImportancesOf(SixFields(), outcomes);
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].SerializeAsString(), second[i].SerializeAsString());
  }
}

}  // namespace
}  // namespace parallax
