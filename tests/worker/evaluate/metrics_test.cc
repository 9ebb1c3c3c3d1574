#include "worker/evaluate/metrics.h"

#include <gmock/gmock.h>

#include "tests/worker/evaluate/test_tree.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, ThresholdsAreStrict) {
  const struct {
    float predicted_px, truth_px;
    const char* measure;
    double bad_percent;
  } cases[] = {
      {12, 10, "bad-2", 0},
      {12.001f, 10, "bad-2", 100},
      {8, 10, "bad-2", 0},
      {7.99f, 10, "bad-2", 100},
      {10.5f, 10, "bad-0.5", 0},
      {11, 10, "bad-1", 0},
      {13, 10, "bad-3", 0},
      {13.5f, 10, "bad-3", 100},
      {18, 10, "bad-8", 0},
      // D1 wants more than 3 px and more than 5 %.
      {13, 10, "d1", 0},
      {13.5f, 10, "d1", 100},
      {104, 100, "d1", 0},
      {105, 100, "d1", 0},
      {105.5f, 100, "d1", 100},
      {2, 1, "d1", 0},
  };
  for (const auto& c : cases) {
    const ErrorTally tally = TallyErrors(Row({c.predicted_px}), Row({c.truth_px}), {});
    const auto metric = ParseMetric(c.measure);
    ASSERT_TRUE(metric.ok()) << metric.status();
    EXPECT_EQ(FigureOf(metric->measure, tally), c.bad_percent)
        << c.measure << " of " << c.predicted_px << " for " << c.truth_px;
  }
}

TEST(Metrics, PixelsWithoutTruthOrOutsideTheRegionDoNotCount) {
  const ImageF predicted = Row({0, 10, 20, 33}), truth = Row({0, 11, 24, 30});
  const ErrorTally all = TallyErrors(predicted, truth, {});
  EXPECT_EQ(all.pixels, 3);
  EXPECT_DOUBLE_EQ(FigureOf(kEpeMeasure, all), (1 + 4 + 3) / 3.0);
  EXPECT_DOUBLE_EQ(FigureOf({.kind = Measure::Kind::kRmse}, all), std::sqrt((1 + 16 + 9) / 3.0));
  EXPECT_DOUBLE_EQ(FigureOf(BadAt(2), all), 200 / 3.0);
  const ErrorTally part = TallyErrors(predicted, truth, RowU8({1, 1, 0, 1}));
  EXPECT_EQ(part.pixels, 2);
  EXPECT_DOUBLE_EQ(FigureOf(kEpeMeasure, part), 2.0);
}

TEST(Metrics, InvalidPredictionsAreWrongAtEveryThresholdAndNeverImproveTheMeanError) {
  for (const float invalid : {kNan, kInf, -kInf, -0.1f}) {
    const ErrorTally tally = TallyErrors(Row({invalid, 10}), Row({0.2f, 10}), {});
    EXPECT_EQ(tally.invalid, 1) << invalid;
    EXPECT_EQ(tally.d1, 1) << invalid;
    for (const int64_t bad : tally.bad) EXPECT_EQ(bad, 1) << invalid;
  }
  // 100 px wide, truth 20: no disparity in [0, 100] is further away than 80.
  ImageF truth(100, 1, 20.0f), missing(100, 1, kNan);
  for (const float guess : {0.0f, 20.0f, 99.0f, 100.0f}) {
    const ImageF predicted(100, 1, guess);
    EXPECT_GE(FigureOf(kEpeMeasure, TallyErrors(missing, truth, {})),
              FigureOf(kEpeMeasure, TallyErrors(predicted, truth, {})))
        << guess;
  }
  EXPECT_DOUBLE_EQ(FigureOf(kEpeMeasure, TallyErrors(missing, truth, {})), 80);
}

TEST(Metrics, LogErrorsAreTheAreaUnderTheErrorCurve) {
  const struct {
    float error_px;
    double octaves;  // Half of the interval that the error lies in counts.
  } cases[] = {{0, 0},         {0.5f, 0},   {0.7f, 0.5}, {1.5f, 1.5},
               {5.5f, 3.4534}, {7, 3.7925}, {8.5f, 4},   {80, 4}};
  for (const auto& c : cases) {
    const ErrorTally tally = TallyErrors(Row({10 + c.error_px}), Row({10}), {});
    EXPECT_NEAR(FigureOf(kLogMeasure, tally), c.octaves, 0.01) << c.error_px;
  }
  const ErrorTally both = TallyErrors(Row({10, 90}), Row({10, 10}), {});
  EXPECT_DOUBLE_EQ(FigureOf(kLogMeasure, both), 2);
}

TEST(Metrics, TalliesAddUpToThePool) {
  const ImageF truth = Row({10, 10, 10, 10}), predicted = Row({10, 12.5f, kNan, 11});
  ErrorTally pool;
  for (int i = 0; i < 4; ++i) {
    pool += TallyErrors(Row({predicted(i, 0)}), Row({truth(i, 0)}), {});
  }
  // Single-pixel images differ in width, which only the error of the missing one depends on.
  const ErrorTally whole = TallyErrors(predicted, truth, {});
  EXPECT_EQ(pool.bad, whole.bad);
  EXPECT_EQ(pool.pixels, whole.pixels);
  EXPECT_EQ(pool.invalid, whole.invalid);
}

TEST(Metrics, NamesReadBack) {
  for (const char* name :
       {"bad-2 nocc", "bad-0.5 all", "d1 all pooled", "epe all", "rmse class3", "log all"}) {
    const auto metric = ParseMetric(name);
    ASSERT_TRUE(metric.ok()) << metric.status();
    EXPECT_EQ(MetricName(*metric), name);
  }
  for (const char* name : {"bad-7", "", "epe all together"}) {
    EXPECT_FALSE(ParseMetric(name).ok()) << name;
  }
  EXPECT_THAT(std::string(ParseMetric("bad-7").status().message()), HasSubstr("bad-0.5"));
}

}  // namespace
}  // namespace parallax
