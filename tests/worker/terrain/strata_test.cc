#include "worker/terrain/strata.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

const StrataSpec kSpec = {.bed_m = 8, .step = 0.9f, .ledge_m = 1.5f, .dip = 0.02f, .seed = 5};

TEST(Strata, StepsRiseWithTheGroundAndStayWithinABed) {
  const Strata strata(kSpec);
  const Vec2f p(31, -17);
  float before = strata.Stepped(p, -60, 0);
  float steepest = 0, gentlest = 1e9f;
  for (float height = -60; height < 60; height += 0.05f) {
    const float stepped = strata.Stepped(p, height, 0);
    EXPECT_LT(std::fabs(stepped - height), kSpec.bed_m);
    EXPECT_GE(stepped, before - 0.02f) << height;
    steepest = std::max(steepest, (stepped - before) / 0.05f);
    gentlest = std::min(gentlest, (stepped - before) / 0.05f);
    before = stepped;
  }
  // Hard beds are cliffs, soft ones benches.
  EXPECT_GT(steepest, 3);
  EXPECT_LT(gentlest, 0.6f);
}

TEST(Strata, DebrisHidesThem) {
  const Strata strata(kSpec);
  for (float height = -20; height < 20; height += 0.7f) {
    EXPECT_NEAR(strata.Stepped({3, 4}, height, 1), height, 1e-4f);
  }
}

TEST(Strata, LedgesStandOutNoFurtherThanTheyMay) {
  const Strata strata(kSpec);
  float least = 1e9f, most = 0;
  for (float z = 0; z < 60; z += 0.13f) {
    const float out = strata.Ledge({2.0f * z, 11, z});
    EXPECT_GE(out, 0);
    EXPECT_LE(out, kSpec.ledge_m);
    least = std::min(least, out);
    most = std::max(most, out);
  }
  EXPECT_GT(most - least, 0.4f * kSpec.ledge_m);
  EXPECT_FALSE(Strata().any());
  EXPECT_FALSE(Strata({.bed_m = 4}).has_ledges());
}

// Courses end in slopes: a jump between them would be drawn as teeth, however fine the mesh.
TEST(Strata, LedgesHaveNoJumps) {
  const Strata strata(kSpec);
  float largest = 0;
  for (float x = 0; x < 40; x += 1.7f) {
    float before = strata.Ledge({x, 11, 0});
    for (float z = 0; z < 40; z += 0.01f) {
      const float out = strata.Ledge({x, 11, z});
      largest = std::max(largest, std::fabs(out - before));
      before = out;
    }
  }
  EXPECT_LT(largest, 0.1f * kSpec.ledge_m);
}

}  // namespace
}  // namespace parallax
