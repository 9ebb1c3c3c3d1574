#include "common/base/rate_estimator.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(RateEstimator, NeedsGrowthBeforeItSpeaks) {
  RateEstimator rate;
  EXPECT_FALSE(rate.PerSecond());
  rate.Add(0, 3);
  rate.Add(10, 3);
  EXPECT_FALSE(rate.PerSecond());
  EXPECT_FALSE(rate.SecondsFor(5));
  EXPECT_EQ(*rate.SecondsFor(0), 0);
  rate.Add(20, 5);
  EXPECT_DOUBLE_EQ(*rate.PerSecond(), 0.1);
  EXPECT_DOUBLE_EQ(*rate.SecondsFor(5), 50);
}

TEST(RateEstimator, ForgetsWhatIsOlderThanItsWindow) {
  RateEstimator rate(100);
  for (int t = 0; t <= 100; t += 10) rate.Add(t, t);                      // 1/s
  for (int t = 110; t <= 300; t += 10) rate.Add(t, 100 + (t - 100) * 3);  // 3/s
  EXPECT_NEAR(*rate.PerSecond(), 3, 1e-9);
}

TEST(RateEstimator, StartsAnewWhenTheCountFalls) {
  RateEstimator rate;
  rate.Add(0, 0);
  rate.Add(10, 100);
  rate.Add(20, 5);
  EXPECT_FALSE(rate.PerSecond());
  rate.Add(30, 15);
  EXPECT_DOUBLE_EQ(*rate.PerSecond(), 1);
}

}  // namespace
}  // namespace parallax
