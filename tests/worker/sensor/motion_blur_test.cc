#include "worker/sensor/motion_blur.h"

#include <gtest/gtest.h>

#include <cmath>

namespace parallax {
namespace {

constexpr int kBlurWidth = 128, kBlurHeight = 64;

EyeMotion Eye() {
  EyeMotion motion;
  motion.fx_px = motion.fy_px = 100;
  motion.cx_px = 64;
  motion.cy_px = 32;
  motion.exposure_s = 0.02;
  return motion;
}

// Where a point of the scene is seen after the eye has moved for `seconds`.
Vec2d SeenAfter(const EyeMotion& m, const Vec3d& point, double seconds) {
  const double angle = m.turn_rad_s.norm() * seconds;
  const Eigen::Matrix3d turned =
      angle == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                 : Eigen::AngleAxisd(angle, m.turn_rad_s.normalized()).toRotationMatrix();
  const Vec3d p = turned.transpose() * (point - m.velocity_m_s * seconds);
  return {m.fx_px * p.x() / p.z() + m.cx_px, m.fy_px * p.y() / p.z() + m.cy_px};
}

TEST(MotionBlur, ShiftsAreThoseOfPointsProjectedFromAMovedEye) {
  EyeMotion m = Eye();
  m.velocity_m_s = {0.4, -0.2, 0.7};
  m.turn_rad_s = {0.1, 0.3, -0.2};
  for (const double depth : {0.5, 3.0, 1e6}) {
    for (const Vec2d& at : {Vec2d(10, 50), Vec2d(64, 32), Vec2d(120, 5)}) {
      const Vec3d point =
          depth * Vec3d((at.x() - m.cx_px) / m.fx_px, (at.y() - m.cy_px) / m.fy_px, 1);
      const Vec2d moved =
          SeenAfter(m, point, m.exposure_s / 2) - SeenAfter(m, point, -m.exposure_s / 2);
      const Vec2d told = ImageShift(m, at.x(), at.y(), depth < 1e6 ? depth : 0);
      EXPECT_NEAR(told.x(), moved.x(), 0.01 + 0.01 * moved.norm()) << depth;
      EXPECT_NEAR(told.y(), moved.y(), 0.01 + 0.01 * moved.norm()) << depth;
    }
  }
}

TEST(MotionBlur, AnEdgeBecomesARampAsWideAsTheShift) {
  EyeMotion m = Eye();
  m.velocity_m_s = {10, 0, 0};  // 0.2 m at 2 m: 10 px.
  ImageF3 light(kBlurWidth, kBlurHeight);
  for (int y = 0; y < kBlurHeight; ++y) {
    for (int x = 64; x < kBlurWidth; ++x) light(x, y, 0) = 1;
  }
  BlurByMotion(m, ImageF(kBlurWidth, kBlurHeight, 2.0f), light);
  for (int x = 20; x < 108; ++x) {
    const double ramp = std::clamp((x + 0.5 - 59) / 10, 0.0, 1.0);
    EXPECT_NEAR(light(x, 20, 0), ramp, 0.08) << x;
  }
}

// A near post before a far wall: the post's edge is soft over the wall, and the wall, which hardly
// moves, keeps its stripes.
TEST(MotionBlur, NearThingsSmearOverTheFarOnesThatStaySharp) {
  EyeMotion m = Eye();
  m.velocity_m_s = {5, 0, 0};  // 10 px at 1 m, 0.1 px at 100 m.
  ImageF3 light(kBlurWidth, kBlurHeight);
  ImageF depth(kBlurWidth, kBlurHeight, 100.0f);
  for (int y = 0; y < kBlurHeight; ++y) {
    for (int x = 0; x < kBlurWidth; ++x) {
      const bool post = x >= 50 && x < 70;
      if (post) depth(x, y) = 1;
      light(x, y, 0) = post ? 1.0f : 0.0f;
      light(x, y, 1) = !post && x % 4 < 2 ? 1.0f : 0.0f;
    }
  }
  const ImageF3 sharp = light;
  BlurByMotion(m, depth, light);
  EXPECT_NEAR(light(50, 30, 0), 0.5f, 0.12f);
  EXPECT_NEAR(light(47, 30, 0), 0.25f, 0.12f) << "the post reaches 5 px over the wall";
  EXPECT_NEAR(light(60, 30, 0), 1.0f, 0.01f);
  EXPECT_NEAR(light(40, 30, 0), 0.0f, 0.01f);
  for (int x = 8; x < 40; ++x) EXPECT_NEAR(light(x, 30, 1), sharp(x, 30, 1), 0.15f) << x;
}

TEST(MotionBlur, EachPixelMovesByItsOwnDepth) {
  EyeMotion m = Eye();
  m.velocity_m_s = {5, 0, 0};  // 10 px at 1 m, 0.1 px at 100 m.
  ImageF3 light(kBlurWidth, kBlurHeight);
  ImageF depth(kBlurWidth, kBlurHeight);
  const auto is_near = [](int x, int y) { return x < 64 && y < 32; };
  for (int y = 0; y < kBlurHeight; ++y) {
    for (int x = 0; x < kBlurWidth; ++x) {
      depth(x, y) = is_near(x, y) ? 1.0f : 100.0f;
      light(x, y, 0) = x % 64 >= 32 ? 1.0f : 0.0f;  // Edges at 32 and 96.
    }
  }
  BlurByMotion(m, depth, light);
  for (const int y : {5, 25, 40, 60}) {
    for (const int edge : {32, 96}) {
      const double reach = is_near(edge, y) ? 10 : 0.1;
      for (int x = edge - 12; x < edge + 12; ++x) {
        EXPECT_NEAR(light(x, y, 0), std::clamp((x + 0.5 - edge) / reach + 0.5, 0.0, 1.0), 0.08)
            << x << ", " << y;
      }
    }
  }
}

TEST(MotionBlur, StillEyesAndShortExposuresChangeNothing) {
  EyeMotion m = Eye();
  EXPECT_TRUE(m.IsStill());
  m.turn_rad_s = {0, 1, 0};
  EXPECT_FALSE(m.IsStill());
  m.exposure_s = 0;
  EXPECT_TRUE(m.IsStill());
}

}  // namespace
}  // namespace parallax
