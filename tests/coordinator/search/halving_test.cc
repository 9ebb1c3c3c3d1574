#include "coordinator/search/halving.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coordinator/search/rung_study.h"
#include "coordinator/study/keys.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::SearchRecord RecordOf(int trials, int keep_one_of = 2) {
  v1::SearchRecord record;
  *record.mutable_study() = SmallSearch(trials);
  record.mutable_study()->mutable_search()->set_keep_one_of(keep_one_of);
  for (int number = 0; number <= trials; ++number) record.add_trials()->set_number(number);
  return record;
}

TrialScore Scored(int number, double objective, const std::string& verdict = "not significant",
                  bool worse_than_best = false) {
  TrialScore score{.variant = TrialName(number), .verdict = verdict};
  score.worse_than_best = worse_than_best;
  score.objective.set_value(objective);
  return score;
}

std::vector<int> Numbers(const v1::SearchRecord& record) {
  std::vector<int> numbers;
  for (const v1::SearchTrial& trial : Entrants(record)) numbers.push_back(trial.number());
  return numbers;
}

TEST(EndRung, TheBestOfSoManyGoOnAndTheDefaultAlways) {
  v1::SearchRecord record = RecordOf(5);
  ASSERT_TRUE(
      EndRung({Scored(0, 99), Scored(1, 5), Scored(2, 1), Scored(3, 4), Scored(4, 2), Scored(5, 3)},
              {}, record)
          .ok());
  EXPECT_THAT(Numbers(record), ElementsAre(0, 2, 4, 5));
  EXPECT_EQ(record.trials(1).ended(), "rung 1: not among the best 3 of 5");
  EXPECT_EQ(EndedRungs(record), 1);
  EXPECT_EQ(BestOf(record), 2);
  ASSERT_TRUE(EndRung({Scored(0, 99), Scored(2, 3), Scored(4, 2), Scored(5, 1)}, {}, record).ok());
  EXPECT_THAT(Numbers(record), ElementsAre(0, 4, 5));
  EXPECT_EQ(BestOf(record), 5);
  // The last rung leaves nobody behind.
  ASSERT_TRUE(EndRung({Scored(0, 99), Scored(4, 2), Scored(5, 1, "worse")}, {}, record).ok());
  EXPECT_THAT(Numbers(record), ElementsAre(0, 4, 5));
  EXPECT_EQ(WhyOver(record), "all rungs have ended");
}

TEST(EndRung, IntervalsLeaveTrialsBehindFirst) {
  v1::SearchRecord record = RecordOf(6);
  ASSERT_TRUE(
      EndRung({Scored(0, 3), Scored(1, 1), Scored(2, 2, "not significant", true), Scored(3, 2.5),
               Scored(4, 2.6), Scored(5, 2.7), Scored(6, 2.1, "worse", true)},
              {}, record)
          .ok());
  EXPECT_THAT(Numbers(record), ElementsAre(0, 1, 3, 4));
  EXPECT_EQ(record.trials(2).ended(), "rung 1: significantly worse than trial-001");
  EXPECT_EQ(record.trials(6).ended(), "rung 1: significantly worse than the default");
  EXPECT_EQ(record.trials(5).ended(), "rung 1: not among the best 3 of 6");
}

TEST(EndRung, TrialsThatMakeNoPairsEndAndOthersMustHaveScores) {
  v1::SearchRecord record = RecordOf(2);
  const std::string before = DeterministicBytes(record);
  const absl::Status missing = EndRung({Scored(0, 3), Scored(1, 1)}, {}, record);
  EXPECT_TRUE(absl::IsFailedPrecondition(missing));
  EXPECT_THAT(std::string(missing.message()), HasSubstr("rung 1: trial-002 has no scores"));
  EXPECT_EQ(DeterministicBytes(record), before);
  ASSERT_TRUE(
      EndRung({Scored(0, 3), Scored(1, 1)}, {{"trial-002", "no valid scene"}}, record).ok());
  EXPECT_EQ(record.trials(2).ended(), "rung 1: no valid scene");
  EXPECT_THAT(Numbers(record), ElementsAre(0, 1));
}

TEST(EndRung, ATrialThatIsSignificantlyWorseIsNotTheBestHoweverSmallItsError) {
  v1::SearchRecord record = RecordOf(2);  // Its verdicts may be by another figure than its error.
  ASSERT_TRUE(
      EndRung({Scored(0, 3), Scored(1, 1, "worse"), Scored(2, 2, "worse")}, {}, record).ok());
  EXPECT_EQ(BestOf(record), 0);
}

TEST(EndRung, TheRecordKeepsTheIntervalThatDecides) {
  v1::SearchRecord record = RecordOf(1);
  TrialScore by_log = Scored(1, 1, "better");
  by_log.log_difference.emplace().set_value(-0.5);
  ASSERT_TRUE(EndRung({Scored(0, 3), by_log}, {}, record).ok());
  EXPECT_EQ(record.trials(1).scores(0).log_difference().value(), -0.5);
  EXPECT_FALSE(record.trials(0).scores(0).has_log_difference());
}

TEST(EndRung, EqualTrialsGoOnInTheirOrder) {
  v1::SearchRecord record = RecordOf(4, /*keep_one_of=*/4);
  ASSERT_TRUE(
      EndRung({Scored(4, 1), Scored(3, 1), Scored(2, 1), Scored(1, 1), Scored(0, 1)}, {}, record)
          .ok());
  EXPECT_THAT(Numbers(record), ElementsAre(0, 1));
  EXPECT_EQ(BestOf(record), 0);  // No trial is better than the default.
}

TEST(WhyOver, ASearchWithoutTrialsThatGoOnIsOver) {
  v1::SearchRecord record = RecordOf(1);
  EXPECT_EQ(WhyOver(record), "");
  EXPECT_EQ(BestOf(record), std::nullopt);
  ASSERT_TRUE(EndRung({Scored(0, 3), Scored(1, 5, "worse")}, {}, record).ok());
  EXPECT_EQ(WhyOver(record), "no trial goes on");
  EXPECT_EQ(BestOf(record), 0);
}

TEST(WhyOver, ARungThatTheBudgetHasNotIsNotBegun) {
  v1::SearchRecord record = RecordOf(1);
  record.mutable_study()->mutable_search()->set_core_hours(2);
  record.set_core_hours(100);  // The first rung has no figures yet.
  EXPECT_EQ(WhyOver(record), "");
  ASSERT_TRUE(EndRung({Scored(0, 3), Scored(1, 1)}, {}, record).ok());
  record.set_core_hours(1.5);
  record.set_next_core_hours(0.5);
  EXPECT_EQ(WhyOver(record), "");
  record.set_next_core_hours(0.75);
  EXPECT_EQ(WhyOver(record), "rung 2 would take it to 2.25 core-hours, core_hours is 2");
  record.mutable_study()->mutable_search()->set_core_hours(0);
  EXPECT_EQ(WhyOver(record), "");
}

TEST(NextCoreHours, CountsNewPairsAndLongerTrainingsOfThoseThatGoOn) {
  v1::SearchRecord record = RecordOf(3);  // 8 pairs: rungs of 2, 4 and 8.
  ASSERT_TRUE(EndRung({Scored(0, 3), Scored(1, 1), Scored(2, 2), Scored(3, 4)}, {}, record).ok());
  StudyCosts costs;
  for (int number = 0; number < 4; ++number) {
    costs.variants[TrialName(number)] = {.pairs = 2, .core_s = 3600.0 * (number + 1)};
  }
  costs.train_core_s = 4 * 3600;
  costs.evaluate_core_s = 8 * 3600;
  // Pairs: two more of the default and trials 1 and 2 at 0.5, 1 and 1.5 hours; three of four
  // variants train twice as long, and are evaluated as before.
  EXPECT_NEAR(NextCoreHours(record, costs), 6 + 0.75 * (2 * 4 + 8), 1e-9);
  ASSERT_TRUE(EndRung({Scored(0, 3), Scored(1, 1), Scored(2, 2)}, {}, record).ok());
  ASSERT_TRUE(EndRung({Scored(0, 3), Scored(1, 1)}, {}, record).ok());
  EXPECT_EQ(NextCoreHours(record, costs), 0);
}

}  // namespace
}  // namespace parallax
