#include "common/math/stereo.h"

#include <gtest/gtest.h>

#include <numbers>

namespace parallax {
namespace {

constexpr double kPi = std::numbers::pi;

RigSpec SpecAt(double yaw, double pitch) {
  return {.index = 3,
          .position = {1, 2, 1.5},
          .axes = CameraAxes(yaw, pitch),
          .baseline_m = 0.25,
          .k = CentredIntrinsics(70 * kPi / 180, 640, 360),
          .width_px = 640,
          .height_px = 360};
}

TEST(Stereo, CamerasHaveNoRollAndLookWhereTheyAreTurned) {
  for (const double yaw : {0.0, 0.7, 2.0, 5.5}) {
    for (const double pitch : {0.4, kPi / 2, 2.5}) {
      const Eigen::Matrix3d axes = CameraAxes(yaw, pitch);
      EXPECT_TRUE((axes.transpose() * axes).isIdentity(1e-12));
      EXPECT_NEAR(axes.determinant(), 1, 1e-12);
      EXPECT_NEAR(axes.col(0).z(), 0, 1e-12) << "right is level";
      EXPECT_LE(axes.col(1).z(), 0) << "down points down";
      EXPECT_NEAR(axes.col(2).z(), -std::cos(pitch), 1e-12);
    }
  }
  EXPECT_TRUE(CameraAxes(0, kPi / 2).col(2).isApprox(Vec3d::UnitX(), 1e-12));
  EXPECT_TRUE(CameraAxes(kPi / 2, kPi / 2).col(2).isApprox(Vec3d::UnitY(), 1e-12));
}

TEST(Stereo, ARigHasTheFieldOfViewAndThePlaceOfItsSpec) {
  const v1::Rig rig = MakeRig(SpecAt(0.7, 1.4));
  EXPECT_EQ(rig.index(), 3u);
  EXPECT_EQ(rig.width_px(), 640);
  EXPECT_EQ(rig.height_px(), 360);
  EXPECT_EQ(rig.cx_px(), 320);
  EXPECT_EQ(rig.cy_px(), 180);
  EXPECT_EQ(rig.fx_px(), rig.fy_px());
  const Vec2d half = HalfTangents(rig);
  EXPECT_NEAR(2 * std::atan(half.x()), 70 * kPi / 180, 1e-12);
  EXPECT_NEAR(half.y() / half.x(), 360.0 / 640, 1e-12);
  EXPECT_TRUE(RigAxes(rig).isApprox(CameraAxes(0.7, 1.4), 1e-12));
  EXPECT_EQ(EyePosition(rig, 0), Vec3d(1, 2, 1.5));
}

TEST(Stereo, TheRightEyeIsABaselineToTheRightAndLooksTheSameWay) {
  const v1::Rig rig = MakeRig(SpecAt(2.2, 1.1));
  const Vec3d in_left = RigAxes(rig).transpose() * (EyePosition(rig, 1) - EyePosition(rig, 0));
  EXPECT_TRUE(in_left.isApprox(Vec3d(0.25, 0, 0), 1e-12));
  const Pose left = WorldFromEye(rig, 0), right = WorldFromEye(rig, 1);
  EXPECT_EQ(right.translation, EyePosition(rig, 1));
  EXPECT_EQ(right.rotation.coeffs(), left.rotation.coeffs());
}

TEST(Stereo, UnnormalisedRotationsOfRecipesMoveTheRightEyeNoFarther) {
  v1::Rig rig = MakeRig(SpecAt(2.2, 1.1));
  const Vec3d right = EyePosition(rig, 1);
  v1::Transform& pose = *rig.mutable_world_from_left();
  pose.set_qw(3 * pose.qw());
  pose.set_qx(3 * pose.qx());
  pose.set_qy(3 * pose.qy());
  pose.set_qz(3 * pose.qz());
  EXPECT_TRUE(EyePosition(rig, 1).isApprox(right, 1e-12));
}

}  // namespace
}  // namespace parallax
