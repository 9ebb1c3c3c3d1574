#include "worker/render/lights/haze.h"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/render/truth/ground_truth.h"

namespace parallax {
namespace {

v1::Air HazyAir() {
  v1::Air air;
  air.set_haze_per_m(0.004);
  air.set_scale_height_m(150);
  return air;
}

// exp(-optical depth) by the midpoint rule.
double ByNumbers(const v1::Air& air, const Vec3d& origin, const Vec3d& direction, double distance) {
  constexpr int kSteps = 20'000;
  double depth = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double z = origin.z() + (i + 0.5) / kSteps * distance * direction.z();
    depth += air.haze_per_m() * std::exp(-z / air.scale_height_m()) * distance / kSteps;
  }
  return std::exp(-depth);
}

TEST(Haze, TransmittanceIsTheIntegralAlongTheRay) {
  const Haze haze(HazyAir());
  for (const double z0 : {-40.0, 0.0, 90.0}) {
    for (const double slope : {-0.6, -0.01, -1e-6, 0.0, 1e-6, 0.02, 0.7, 1.0}) {
      for (const double distance : {0.5, 30.0, 400.0, 5000.0}) {
        const Vec3d origin(3, -2, z0), to(std::sqrt(1 - slope * slope), 0, slope);
        if (z0 + slope * distance < -800) continue;
        const double want = ByNumbers(HazyAir(), origin, to, distance);
        const float got =
            haze.Transmittance(Vec3x8(Vec3f(origin.cast<float>())), Vec3x8(Vec3f(to.cast<float>())),
                               Splat(static_cast<float>(distance)))[0];
        EXPECT_NEAR(static_cast<double>(got), want, 2e-4 + 1e-3 * want)
            << z0 << " " << slope << " " << distance;
      }
    }
  }
}

TEST(Haze, NoneLeavesEverythingAndMarksNothing) {
  const Haze none;
  EXPECT_TRUE(none.clear());
  PinholeCamera camera;
  View view;
  view.depth_m = ImageF(8, 8);
  view.masks = ImageU8(8, 8);
  for (float& depth : view.depth_m.values()) depth = 1e6f;
  MarkVeiled(none, camera, &view);
  for (const uint8_t mask : view.masks.values()) EXPECT_EQ(mask, 0);
}

// Level rays of constant haze: a twentieth is left after ln 20 / extinction metres.
TEST(Haze, VeilsWhatItLeavesLessThanATwentiethOf) {
  v1::Air air = HazyAir();
  air.set_scale_height_m(1e6);
  PinholeCamera camera;
  camera.width_px = camera.height_px = 9;
  camera.fx_px = camera.fy_px = 1000;
  camera.cx_px = camera.cy_px = 4.5;
  camera.world_from_camera.col(0) = Vec3d::UnitX();
  camera.world_from_camera.col(1) = -Vec3d::UnitZ();
  camera.world_from_camera.col(2) = Vec3d::UnitY();
  const float limit = static_cast<float>(std::log(20.0) / air.haze_per_m());
  View view;
  view.depth_m = ImageF(9, 9);
  view.masks = ImageU8(9, 9);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      view.depth_m(x, y) = x < 3 ? 0.98f * limit : x < 6 ? 1.02f * limit : 0.0f;
      view.masks(x, y) = kMaskMirror;
    }
  }
  MarkVeiled(Haze(air), camera, &view);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const bool veiled = x >= 3 && x < 6;  // Pixels of the sky, depth 0, are not.
      EXPECT_EQ(view.masks(x, y), kMaskMirror | (veiled ? kMaskVeiled : 0)) << x << " " << y;
    }
  }
}

// Else thick air shows a vertical stripe below each cloud at the horizon.
TEST(Haze, ItsGlowHasNoShapesOfClouds) {
  v1::Sky sky;
  sky.set_strength(1);
  sky.set_sun_strength(1);
  sky.set_sun_elevation_rad(0.5);
  sky.set_cloud_cover(0.6);
  sky.set_cloud_seed(3);
  const SkyModel model(sky);
  v1::Air air = HazyAir();
  const Haze haze(air);
  constexpr int kSteps = 720;
  double glow_jump = 0, sky_jump = 0, glow_sum = 0, sky_sum = 0;
  double glow_before = 0, sky_before = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const Vec3f direction = DirectionAt(0.045f, 2.0f * kPi * static_cast<float>(i) / kSteps);
    const auto glow = static_cast<double>(Luminance(haze.Glow(model, Vec3x8(direction)).Get(0)));
    const auto seen = static_cast<double>(Luminance(model.Radiance(direction)));
    if (i > 0) {
      glow_jump = std::max(glow_jump, std::abs(glow / glow_before - 1));
      sky_jump = std::max(sky_jump, std::abs(seen / sky_before - 1));
      glow_sum += glow;
      sky_sum += seen;
    }
    glow_before = glow;
    sky_before = seen;
  }
  EXPECT_GT(sky_jump, 0.03);  // There are clouds at the horizon.
  EXPECT_LT(glow_jump, 0.02);
  EXPECT_NEAR(glow_sum / sky_sum, 1, 0.15);  // All in all, air is as bright as the sky behind it.
}

}  // namespace
}  // namespace parallax
