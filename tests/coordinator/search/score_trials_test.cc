#include "coordinator/client/scores/score_trials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "coordinator/search/rung_study.h"

namespace parallax {
namespace {

using testing::HasSubstr;

// Errors of networks of several trials on the same pictures: what a picture, a training and both
// together add, and what the trial adds.
struct Errors {
  int trials = 3, seeds = 3, images = 30;
  std::vector<std::string> benchmarks = {"shipped"};
  double effect = 0;  // Points that trial 1 is better.
  double picture = 6, training = 0.5, rest = 1;
};

Scores ImageWith(const std::string& pair, double bad2_percent) {
  Scores scores{.pair = pair, .width_px = 100, .height_px = 100};
  ErrorTally& tally = scores.regions["all"];
  tally.pixels = 1'000'000;
  tally.bad[2] = std::llround(std::clamp(bad2_percent, 0.0, 100.0) * 10'000);
  return scores;
}

std::vector<Evaluation> Draw(const Errors& errors, uint64_t draw) {
  const Rng rng(SceneSeed{draw}, "errors");
  std::vector<Evaluation> all;
  for (const std::string& benchmark : errors.benchmarks) {
    for (int trial = 0; trial <= errors.trials; ++trial) {
      for (int seed = 0; seed < errors.seeds; ++seed) {
        Rng of_run = rng.Child(benchmark).Child(TrialName(trial), static_cast<uint64_t>(seed));
        Evaluation& one = all.emplace_back();
        one.benchmark = benchmark;
        one.headline = {.measure = BadAt(1), .region = "all"};
        one.run = {.variant = TrialName(trial), .trainer = "builtin", .seed = seed};
        const double of_training = of_run.Normal(0, errors.training);
        for (int image = 0; image < errors.images; ++image) {
          Rng picture = rng.Child(benchmark).Child("picture", static_cast<uint64_t>(image));
          one.images.push_back(ImageWith("p" + std::to_string(image),
                                         30 + picture.Normal(0, errors.picture) + of_training +
                                             of_run.Normal(0, errors.rest) -
                                             (trial == 1 ? errors.effect : 0)));
        }
      }
    }
  }
  return all;
}

std::map<std::string, TrialScore> ScoresOf(const std::vector<Evaluation>& evaluations,
                                           const ScoreQuery& query) {
  const auto scores = TrialScoresOf(evaluations, query);
  EXPECT_TRUE(scores.ok()) << scores.status();
  std::map<std::string, TrialScore> by_name;
  if (!scores.ok()) return by_name;
  for (const TrialScore& score : *scores) by_name[score.variant] = score;
  return by_name;
}

TEST(TrialScores, ATrialThatIsBetterIsFoundAndOthersAreWorseThanIt) {
  auto scores = ScoresOf(Draw({.effect = 5}, 1), {.benchmarks = {"shipped"}});
  ASSERT_EQ(scores.size(), 4u);
  EXPECT_EQ(scores["trial-001"].verdict, "better");
  EXPECT_NEAR(scores["trial-001"].difference.value(), -5, 1.5);
  EXPECT_LT(scores["trial-001"].difference.high(), 0);
  EXPECT_FALSE(scores["trial-001"].worse_than_best);
  EXPECT_TRUE(scores["trial-002"].worse_than_best);
  EXPECT_TRUE(scores["default"].worse_than_best);
  EXPECT_EQ(scores["default"].difference.value(), 0);
  EXPECT_EQ(scores["default"].verdict, "not significant");
}

TEST(TrialScores, VerdictsMayBeByTheMeanLogErrorWhileTheObjectiveStays) {
  std::vector<Evaluation> evaluations = Draw({.trials = 2, .training = 3}, 1);
  for (Evaluation& one : evaluations) {
    const int64_t far = one.run.variant == "trial-001" ? 400'000 : 700'000;  // Beyond 0.5 px.
    for (Scores& image : one.images) {
      image.regions["all"].bad[0] = far + 1000 * (one.run.seed.value() % 2);
    }
  }
  auto shown = ScoresOf(evaluations, {.benchmarks = {"shipped"}});
  auto by_log = ScoresOf(evaluations, {.benchmarks = {"shipped"}, .decide_by_log = true});
  EXPECT_EQ(shown["trial-001"].verdict, "not significant");
  EXPECT_EQ(by_log["trial-001"].verdict, "better");
  EXPECT_EQ(by_log["trial-002"].verdict, "not significant");
  ASSERT_TRUE(by_log["trial-001"].log_difference.has_value());
  // Trapezoids: 30 % of the pixels over half an octave.
  EXPECT_NEAR(by_log["trial-001"].log_difference->value(), -0.15, 0.02);
  EXPECT_LT(by_log["trial-001"].log_difference->high(), 0);
  EXPECT_FALSE(shown["trial-001"].log_difference.has_value());
  for (auto& [name, score] : by_log) {
    EXPECT_EQ(score.objective.value(), shown[name].objective.value()) << name;
    EXPECT_EQ(score.difference.low(), shown[name].difference.low()) << name;
  }
}

TEST(TrialScores, EqualTrialsAreHardlyEverCalledBetter) {
  int better = 0, all = 0;
  for (uint64_t draw = 1; draw <= 150; ++draw) {
    for (auto& [name, score] :
         ScoresOf(Draw({.trials = 2, .images = 20}, draw), {.benchmarks = {"shipped"}})) {
      if (name == kDefaultTrial) continue;
      better += score.verdict == "better";
      ++all;
    }
  }
  // 2.5 % are expected; with 300 verdicts, more than 5 % come by chance once in 500.
  EXPECT_LE(better, all / 20);
}

TEST(TrialScores, EachBenchmarkCountsAlikeHoweverManyPairsItHas) {
  std::vector<Evaluation> evaluations;
  for (const std::string variant : {"default", "trial-001"}) {
    for (int seed = 0; seed < 2; ++seed) {
      for (const std::string benchmark : {"shipped", "eth3d"}) {
        Evaluation& one = evaluations.emplace_back();
        one.benchmark = benchmark;
        one.headline = {.measure = BadAt(2), .region = "all"};
        one.run = {.variant = variant, .trainer = "builtin", .seed = seed};
        const int pairs = benchmark == "shipped" ? 1 : 9;
        for (int i = 0; i < pairs; ++i) {
          one.images.push_back(ImageWith(std::to_string(i), benchmark == "shipped" ? 40 : 10));
        }
      }
    }
  }
  auto scores = ScoresOf(evaluations, {.benchmarks = {"shipped", "eth3d"}});
  EXPECT_NEAR(scores["default"].objective.value(), 25, 1e-9);
  EXPECT_NEAR(ScoresOf(evaluations, {.benchmarks = {"eth3d"}})["default"].objective.value(), 10,
              1e-9);
}

TEST(TrialScores, EachSetOfPairsCountsAlikeWhereTheStudySaysSo) {
  std::vector<Evaluation> evaluations;
  for (const std::string variant : {"default", "trial-001"}) {
    for (int seed = 0; seed < 2; ++seed) {
      Evaluation& one = evaluations.emplace_back();
      one.benchmark = "shipped";
      one.headline = {.measure = BadAt(2), .region = "all"};
      one.run = {.variant = variant, .trainer = "builtin", .seed = seed};
      // A large set of easy pairs, a small one of hard ones, and a pair by itself.
      for (int i = 0; i < 8; ++i) one.images.push_back(ImageWith("easy" + std::to_string(i), 10));
      for (int i = 0; i < 2; ++i) one.images.push_back(ImageWith("hard" + std::to_string(i), 40));
      one.images.push_back(ImageWith("alone", 70));
      for (int i = 0; i < 10; ++i)
        one.images[static_cast<size_t>(i)].pair_group = i < 8 ? "a" : "b";
    }
  }
  EXPECT_NEAR(ScoresOf(evaluations, {.benchmarks = {"shipped"}})["default"].objective.value(),
              (8 * 10 + 2 * 40 + 70) / 11.0, 1e-9);
  EXPECT_NEAR(ScoresOf(evaluations, {.benchmarks = {"shipped"}, .weigh_groups = true})["trial-001"]
                  .objective.value(),
              (10 + 40 + 70) / 3.0, 1e-9);
}

TEST(TrialScores, VariantsThatFailedAreLeftOut) {
  std::vector<Evaluation> evaluations = Draw({.effect = 5}, 1);
  evaluations.pop_back();  // One of trial 3's trainings failed.
  auto scores = ScoresOf(evaluations, {.benchmarks = {"shipped"}, .without = {"trial-003"}});
  EXPECT_EQ(scores.size(), 3u);
  EXPECT_EQ(scores["trial-001"].verdict, "better");
}

TEST(TrialScores, TimeThatATrialTakesCountsAgainstIt) {
  const std::vector<Evaluation> evaluations = Draw({.effect = 5}, 1);
  auto free = ScoresOf(evaluations, {.benchmarks = {"shipped"}});
  auto priced = ScoresOf(
      evaluations, {.benchmarks = {"shipped"}, .points = {{"default", 3}, {"trial-001", 20}}});
  EXPECT_NEAR(priced["trial-001"].objective.value(), free["trial-001"].objective.value() + 20,
              1e-9);
  EXPECT_NEAR(priced["trial-001"].difference.value(), free["trial-001"].difference.value() + 17,
              1e-9);
  EXPECT_EQ(priced["trial-001"].verdict, "worse");
}

TEST(TrialScores, OneSeedTellsNothing) {
  auto scores = ScoresOf(Draw({.seeds = 1, .effect = 20}, 1), {.benchmarks = {"shipped"}});
  EXPECT_EQ(scores["trial-001"].verdict, "not significant");
  EXPECT_FALSE(scores["trial-002"].worse_than_best);
}

TEST(TrialScores, BaselinesAreNoTrials) {
  std::vector<Evaluation> evaluations = Draw({}, 1);
  evaluations.push_back(evaluations[0]);
  evaluations.back().run = {.variant = "sgbm", .trainer = "sgbm"};
  EXPECT_EQ(ScoresOf(evaluations, {.benchmarks = {"shipped"}}).size(), 4u);
}

TEST(TrialScores, WhatCannotBeComparedIsNamed) {
  const auto refusal = [](const std::function<void(std::vector<Evaluation>&)>& change) {
    std::vector<Evaluation> evaluations = Draw({.trials = 1, .seeds = 2}, 1);
    change(evaluations);
    return std::string(TrialScoresOf(evaluations, {.benchmarks = {"shipped"}}).status().message());
  };
  EXPECT_THAT(refusal([](auto& all) { all.pop_back(); }),
              HasSubstr("trial-001 can't be compared with the default: other numbers of seeds"));
  EXPECT_THAT(refusal([](auto& all) { all.back().images[3].pair = "other"; }),
              HasSubstr("other pairs or seeds on shipped"));
  EXPECT_THAT(refusal([](auto& all) { all.back().images.pop_back(); }), HasSubstr("other pairs"));
  EXPECT_THAT(refusal([](auto& all) {
                for (Evaluation& one : all) one.benchmark = "eth3d";
              }),
              HasSubstr("no scores on shipped"));
  EXPECT_THAT(refusal([](auto& all) { all.erase(all.begin(), all.begin() + 2); }),
              HasSubstr("the variant default has no scores"));
}

}  // namespace
}  // namespace parallax
