#include "worker/terrain/terms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

TerrainTerm Gorge() {
  return {.kind = TermKind::kGorge,
          .wavelength_m = 300,
          .amplitude_m = 80,
          .warp = 0.2f,
          .sharpness = 0.6f,
          .direction_rad = 0.7f,
          .width_m = 40,
          .seed = 9};
}

TEST(Walls, AGorgeHasAFloorAndRimsAndDebrisAtTheFoot) {
  const TerrainTerm gorge = Gorge();
  const Vec2f across(-std::sin(0.7f), std::cos(0.7f));
  for (float along = -400; along <= 400; along += 37) {
    const Vec2f middle = GorgeMiddle(gorge, along);
    const GorgePlace at = PlaceInGorge(gorge, middle);
    EXPECT_NEAR(at.along_m, along, 0.01f);
    EXPECT_NEAR(at.away_m, 0, 0.01f);
    EXPECT_GT(at.half_m, 5);
    EXPECT_LT(TermHeight(gorge, middle, 1), -0.8f * 80);
    float debris = 0, most = 0;
    for (float away = 0; away < 250; away += 2) {
      EXPECT_LE(TermHeight(gorge, middle + away * across, 1, &debris), 1e-3f);
      most = std::max(most, debris);
    }
    EXPECT_NEAR(TermHeight(gorge, middle + 400.0f * across, 1), 0, 3);
    EXPECT_GT(most, 0.5f);
  }
}

TEST(Walls, AScarpIsFoundByItsFoot) {
  TerrainTerm scarp = Gorge();
  scarp.kind = TermKind::kScarp;
  scarp.width_m = 15;
  for (float along = -300; along <= 300; along += 41) {
    EXPECT_LT(TermHeight(scarp, ScarpFoot(scarp, along, -80), 1), 0.12f * 80);
    EXPECT_GT(TermHeight(scarp, ScarpFoot(scarp, along, 120), 1), 0.9f * 80);
  }
}

TEST(Dunes, FallToTheirLeeAtTheAngleOfRepose) {
  const TerrainTerm dunes{.kind = TermKind::kDunes,
                          .wavelength_m = 120,
                          .amplitude_m = 5,
                          .warp = 0.1f,
                          .direction_rad = 0,
                          .seed = 4};
  std::vector<float> lee;
  float up = 0;
  for (float y = -200; y < 200; y += 23) {
    for (float x = -600; x < 600; x += 0.5f) {
      const float slope =
          2 * (TermHeight(dunes, {x + 0.25f, y}, 0.1f) - TermHeight(dunes, {x - 0.25f, y}, 0.1f));
      up = std::max(up, slope);
      if (slope < -0.3f) lee.push_back(-slope);
    }
  }
  ASSERT_GT(lee.size(), 500u);
  std::sort(lee.begin(), lee.end());
  EXPECT_NEAR(lee[lee.size() / 2], 0.62f, 0.06f);
  // Crests wind: a little steeper here and there.
  EXPECT_LT(lee[lee.size() * 98 / 100], 0.95f);
  EXPECT_LT(up, 0.55f);
}

}  // namespace
}  // namespace parallax
