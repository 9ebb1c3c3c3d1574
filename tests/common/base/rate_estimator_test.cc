#include "common/base/rate_estimator.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(RateEstimator, NeedsGrowthBeforeItSpeaks) {
  RateEstimator rate;
  EXPECT_FALSE(rate.PerSecond());
  rate.Add(0, 3);
  rate.Add(30, 3);
  EXPECT_FALSE(rate.PerSecond());
  EXPECT_FALSE(rate.SecondsFor(5));
  EXPECT_EQ(*rate.SecondsFor(0), 0);
  rate.Add(60, 9);
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
  for (int t = 30; t <= 60; t += 10) rate.Add(t, t - 15);
  EXPECT_DOUBLE_EQ(*rate.PerSecond(), 1);
}

TEST(RateEstimator, PairsOfOneLeaseThatArriveAtOnceAreNoRate) {
  RateEstimator rate;
  rate.Add(0, 0);
  rate.Add(4, 7);
  EXPECT_FALSE(rate.PerSecond()) << "7 pairs in 4 s: who knows when their lease began";
  rate.Add(20, 7);
  EXPECT_FALSE(rate.PerSecond());
  rate.Add(60, 7);
  EXPECT_NEAR(*rate.PerSecond(), 7.0 / 60, 1e-9);
}

TEST(RateEstimator, WorkThatWasThereAlreadyIsLeftOut) {
  RateEstimator rate;
  rate.Add(0, 0);
  rate.Add(4, 7);  // Frames that an earlier attempt had left.
  for (int t = 5; t <= 20; ++t) rate.Add(t, 7 + 0.01 * (t - 4));
  EXPECT_NEAR(*rate.PerSecond(), 0.16 / 20, 1e-9);
  EXPECT_GT(*rate.SecondsFor(0.84), 60);
}

TEST(RateEstimator, LeasesLongerThanTheWindowHaveARate) {
  RateEstimator rate(600);
  for (int t = 0; t <= 6000; t += 10) {
    rate.Add(t, 20 * (t / 1000));
    if (t >= 2000) {
      EXPECT_NEAR(*rate.PerSecond(), 0.02, 0.012) << t;
    }
  }
}

TEST(RateEstimator, AFarmThatStandsStillHasNoRate) {
  RateEstimator rate(600);
  for (int t = 0; t <= 1000; t += 10) rate.Add(t, t);
  for (int t = 1010; t <= 4000; t += 10) rate.Add(t, 1000);
  EXPECT_FALSE(rate.PerSecond());
}

}  // namespace
}  // namespace parallax
