#include "worker/terrain/snow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace parallax {
namespace {

const SnowSpec kSnow = {
    .depth_m = 0.6f, .line_m = -1000, .line_soft_m = 10, .slope = 0.7f, .seed = 3};

// Waves of 40 m along x, so steep at the steepest.
Field Waves(float slope) {
  Field field = Field::Square(129, 192);
  for (int row = 0; row < field.size; ++row) {
    for (int column = 0; column < field.size; ++column) {
      const float x = field.PositionOf(column, row).x();
      constexpr float kTurn = 2 * std::numbers::pi_v<float> / 40;
      field.At(column, row) = slope / kTurn * std::sin(kTurn * x);
    }
  }
  return field;
}

TEST(Snow, LiesOnLevelGroundAsDeepAsItFell) {
  const Field snow = SnowOn(Field::Square(65, 96), kSnow);
  double sum = 0;
  for (const float depth : snow.values) sum += static_cast<double>(depth);
  EXPECT_NEAR(sum / static_cast<double>(snow.values.size()), 0.6, 0.1);
}

TEST(Snow, NoneLiesOnSteepRockOrBelowItsLine) {
  Field ramp = Field::Square(65, 96);
  for (int row = 0; row < ramp.size; ++row) {
    for (int column = 0; column < ramp.size; ++column) {
      ramp.At(column, row) = 1.5f * ramp.PositionOf(column, row).x();
    }
  }
  const Field steep = SnowOn(ramp, kSnow);
  EXPECT_EQ(steep.At(32, 32), 0);
  SnowSpec high = kSnow;
  high.line_m = 500;
  EXPECT_EQ(SnowOn(Field::Square(65, 96), high).At(32, 32), 0);
}

TEST(Snow, FillsHollowsAndNeverDigs) {
  const Field ground = Waves(0.5f);
  const Field snow = SnowOn(ground, kSnow);
  double hollows = 0, crests = 0, flatter = 0, before = 0;
  int count = 0;
  for (int row = 20; row < 109; ++row) {
    for (int column = 20; column < 109; ++column) {
      ASSERT_GE(snow.At(column, row), 0);
      const float height = ground.At(column, row);
      if (height < -2.5f) hollows += static_cast<double>(snow.At(column, row)), ++count;
      if (height > 2.5f) crests += static_cast<double>(snow.At(column, row));
      const auto bend = [&](auto at) {
        return std::fabs(static_cast<double>(at(column - 1) - 2 * at(column) + at(column + 1)));
      };
      before += bend([&](int x) { return ground.At(x, row); });
      flatter += bend([&](int x) { return ground.At(x, row) + snow.At(x, row); });
    }
  }
  EXPECT_GT(count, 100);
  EXPECT_GT(hollows, 1.3 * crests);
  EXPECT_LT(flatter, before);
}

TEST(Snow, WindTakesItToTheLee) {
  SnowSpec east = kSnow, west = kSnow;
  east.wind_rad = 0;
  west.wind_rad = std::numbers::pi_v<float>;
  // Column 64 is at x = 0, where the ground rises towards +x.
  const Field ground = Waves(0.4f);
  EXPECT_LT(SnowOn(ground, east).At(64, 64), SnowOn(ground, west).At(64, 64));
}

}  // namespace
}  // namespace parallax
