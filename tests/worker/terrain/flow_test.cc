#include "worker/terrain/flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace parallax {
namespace {

// A tilted plane with a hollow in its middle.
Field PlaneWithHollow() {
  Field height = Field::Square(33, 320);
  for (int row = 0; row < 33; ++row) {
    for (int column = 0; column < 33; ++column) {
      const float r = std::hypot(static_cast<float>(column - 16), static_cast<float>(row - 16));
      height.At(column, row) = 0.5f * static_cast<float>(column) - 20 * std::exp(-r * r / 20);
    }
  }
  return height;
}

TEST(Flow, EverySampleDrainsToTheBorderEvenOutOfAHollow) {
  const Field height = PlaneWithHollow();
  const FlowGraph flow = RouteFlow(height);
  ASSERT_EQ(flow.order.size(), height.values.size());
  std::vector<bool> reached(height.values.size(), false);
  for (const uint32_t sample : flow.order) {
    const uint32_t receiver = flow.receivers[sample];
    const int column = static_cast<int>(sample) % 33, row = static_cast<int>(sample) / 33;
    const bool border = column == 0 || row == 0 || column == 32 || row == 32;
    EXPECT_EQ(receiver == sample, border) << column << ", " << row;
    EXPECT_TRUE(receiver == sample || reached[receiver]) << "the receiver comes first";
    reached[sample] = true;
  }
}

TEST(Flow, FilledGroundNeverLiesBelowItsReceiverNorBelowTheGround) {
  const Field height = PlaneWithHollow();
  const FlowGraph flow = RouteFlow(height);
  for (size_t i = 0; i < height.values.size(); ++i) {
    EXPECT_GE(flow.filled[i], height.values[i]);
    EXPECT_GE(flow.filled[i], flow.filled[flow.receivers[i]]);
  }
  EXPECT_GT(flow.filled[height.Index(16, 16)], height.At(16, 16) + 5) << "the hollow is filled";
}

TEST(Flow, TheBorderDrainsAllOfTheArea) {
  const Field height = PlaneWithHollow();
  const FlowGraph flow = RouteFlow(height);
  const Field area = DrainageArea(height, flow);
  double drained = 0;
  for (size_t i = 0; i < height.values.size(); ++i) {
    if (flow.receivers[i] == i) drained += area.values[i];
  }
  EXPECT_NEAR(drained, 33 * 33 * 100.0, 1);
}

TEST(Flow, AValleyIsWetterThanItsRidges) {
  Field height = Field::Square(65, 640);
  for (int row = 0; row < 65; ++row) {
    for (int column = 0; column < 65; ++column) {
      height.At(column, row) =
          3.0f * std::fabs(static_cast<float>(column - 32)) + 0.3f * static_cast<float>(row);
    }
  }
  const Field wetness = Wetness(height, DrainageArea(height, RouteFlow(height)));
  EXPECT_GT(wetness.At(32, 20), 0.8f);
  EXPECT_LT(wetness.At(3, 20), 0.4f);
}

}  // namespace
}  // namespace parallax
