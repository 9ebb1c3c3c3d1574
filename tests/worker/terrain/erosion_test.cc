#include "worker/terrain/erosion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/terrain/flow.h"
#include "worker/terrain/terms.h"

namespace parallax {
namespace {

Field Range(int size = 129, float extent_m = 2048) {
  Field height = Field::Square(size, extent_m);
  FillWithTerms({{.kind = TermKind::kHills, .wavelength_m = 900, .amplitude_m = 120, .seed = 5}},
                height);
  return height;
}

double Volume(const Field& height) {
  return std::accumulate(height.values.begin(), height.values.end(), 0.0);
}

// Away from the border, which gravity leaves as it is.
float Steepest(const Field& height) {
  float steepest = 0;
  for (int row = 2; row + 3 < height.size; ++row) {
    for (int column = 2; column + 3 < height.size; ++column) {
      const float here = height.At(column, row);
      steepest = std::max({steepest, std::fabs(height.At(column + 1, row) - here) / height.cell_m,
                           std::fabs(height.At(column, row + 1) - here) / height.cell_m});
    }
  }
  return steepest;
}

TEST(Streams, LeaveNoHollowsAndKeepTheRelief) {
  Field height = Range();
  const float before = Quantile(height, 0.95f) - Quantile(height, 0.05f);
  ErodeByStreams(height, {});
  const float after = Quantile(height, 0.95f) - Quantile(height, 0.05f);
  EXPECT_NEAR(after / before, 1, 0.3);
  const FlowGraph flow = RouteFlow(height);
  double filled = 0;
  for (size_t i = 0; i < height.values.size(); ++i) filled += flow.filled[i] - height.values[i];
  EXPECT_LT(filled / static_cast<double>(height.values.size()), 0.5) << "metres of filling";
}

// Hack's law, the mark of branching valleys: the length of a stream grows as area^0.6, far slower
// than in parallel gullies (1) and faster than in a bowl that drains to one point (0.5).
TEST(Streams, BranchAsRealOnesDo) {
  Field height = Range(257, 4096);
  ErodeByStreams(height, {});
  const FlowGraph flow = RouteFlow(height);
  const Field area = DrainageArea(height, flow);
  std::vector<double> length(height.values.size(), 0);
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0, n = 0;
  for (size_t k = flow.order.size(); k-- > 0;) {
    const uint32_t sample = flow.order[k], receiver = flow.receivers[sample];
    if (receiver == sample) continue;
    length[receiver] = std::max(length[receiver], length[sample] + height.cell_m);
    if (area.values[sample] < 40 * height.cell_m * height.cell_m) continue;
    const double x = std::log(area.values[sample]), y = std::log(length[sample]);
    sum_x += x, sum_y += y, sum_xx += x * x, sum_xy += x * y, n += 1;
  }
  const double exponent = (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
  EXPECT_GT(exponent, 0.5);
  EXPECT_LT(exponent, 0.72);
}

TEST(Droplets, MoveGroundDownhillAndLoseNone) {
  Field height = Range(), deposit = Field::Square(129, 2048);
  const Field before = height;
  ErodeByDroplets(height, deposit, {.droplets = 8000, .seed = 3});
  const double cells = static_cast<double>(height.values.size());
  EXPECT_NEAR(Volume(height) / cells, Volume(before) / cells, 0.15);
  double moved = 0, work = 0;
  for (size_t i = 0; i < height.values.size(); ++i) {
    const double change = height.values[i] - before.values[i];
    moved += std::fabs(change);
    work += change * before.values[i];
  }
  EXPECT_GT(moved / cells, 0.05) << "metres";
  EXPECT_LT(work, 0) << "what is taken up high is laid down low";
}

TEST(Gravity, BringsSteepGroundToRestAndLosesNone) {
  Field height = Field::Square(65, 64), deposit = Field::Square(65, 64);
  for (int row = 0; row < 65; ++row) {
    for (int column = 0; column < 65; ++column) {
      height.At(column, row) = column < 32 ? 0.0f : 12.0f;
    }
  }
  const double before = Volume(height);
  ErodeByGravity(height, deposit, {.passes = 400, .talus = 0.65f, .hardness_high = 1.0f});
  EXPECT_NEAR(Volume(height), before, 1e-3 * before);
  EXPECT_LT(Steepest(height), 0.8f);
  EXPECT_GT(deposit.At(28, 32), 0.5f) << "a scree lies below the cliff";
}

TEST(Gravity, HardBandsStandAsCliffs) {
  Field soft = Range(), hard = soft, deposit = Field::Square(129, 2048);
  for (float& value : soft.values) value *= 2.5f;
  hard = soft;
  ErodeByGravity(soft, deposit, {.passes = 400, .hardness_high = 1.0f});
  ErodeByGravity(hard, deposit, {.passes = 400, .hardness_high = 3.0f});
  EXPECT_GT(Steepest(hard), 1.3f * Steepest(soft));
}

}  // namespace
}  // namespace parallax
