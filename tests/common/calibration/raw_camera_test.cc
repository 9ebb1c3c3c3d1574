#include "common/math/raw_camera.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

namespace parallax {
namespace {

using Model = LensDistortion::Model;

LensDistortion Brown() {
  return {Model::kBrownConrady, {-0.28, 0.07, 1.3e-3, -8e-4, 0.012, 0.03, -0.01, 0.002}};
}
LensDistortion Fisheye() { return {Model::kKannalaBrandt, {-0.03, 0.012, -0.004, 0.0007}}; }

// Directions to all sides, up to `most` from the axis, in radians.
std::vector<Vec3d> Directions(double most) {
  std::vector<Vec3d> directions;
  for (int ring = 0; ring <= 8; ++ring) {
    for (int spoke = 0; spoke < 12; ++spoke) {
      const double angle = most * ring / 8, turn = spoke * 0.53;
      directions.emplace_back(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                              std::cos(angle));
    }
  }
  return directions;
}

TEST(LensDistortion, PutsPointsWhereOpenCvPutsThem) {
  for (const Vec3d& d : Directions(0.8)) {
    std::vector<cv::Point2d> seen;
    const std::vector<cv::Point3d> points = {{d.x() * 3, d.y() * 3, d.z() * 3}};
    const LensDistortion brown = Brown(), fisheye = Fisheye();
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                      std::vector<double>(brown.c.begin(), brown.c.end()), seen);
    Vec2d ours = *brown.Project(d, brown.Reach());
    EXPECT_NEAR(ours.x(), seen[0].x, 1e-12);
    EXPECT_NEAR(ours.y(), seen[0].y, 1e-12);
    cv::fisheye::projectPoints(points, seen, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                               std::vector<double>(fisheye.c.begin(), fisheye.c.begin() + 4));
    ours = *fisheye.Project(d, fisheye.Reach());
    EXPECT_NEAR(ours.x(), seen[0].x, 1e-12);
    EXPECT_NEAR(ours.y(), seen[0].y, 1e-12);
  }
}

TEST(LensDistortion, UnprojectingUndoesProjecting) {
  const struct {
    LensDistortion lens;
    double most;
  } cases[] = {{{}, 1.2},
               {Brown(), 0.85},
               {Fisheye(), 1.9},
               {{Model::kBrownConrady, {0.3, -0.1, 0, 0, 0.02}}, 0.9}};
  for (const auto& c : cases) {
    const double reach = c.lens.Reach();
    for (const Vec3d& d : Directions(c.most)) {
      const auto at = c.lens.Project(d, reach);
      ASSERT_TRUE(at) << d.transpose();
      const auto back = c.lens.Unproject(*at, reach);
      ASSERT_TRUE(back) << d.transpose();
      EXPECT_LT((*back - d).norm(), 1e-11) << d.transpose();
    }
  }
}

TEST(LensDistortion, BeyondItsReachThereIsNothing) {
  // r (1 - r^2 / 3) is largest at r = 1, where it is 2/3.
  const LensDistortion barrel{Model::kBrownConrady, {-1.0 / 3}};
  const double reach = barrel.Reach();
  EXPECT_NEAR(reach, 1, 3e-3);
  EXPECT_FALSE(barrel.Project({1.2, 0, 1}, reach));
  EXPECT_FALSE(barrel.Unproject({0.67, 0}, reach));
  EXPECT_TRUE(barrel.Unproject({0.66, 0}, reach));
  EXPECT_FALSE(barrel.Project({0, 0, -1}, reach)) << "behind";
  EXPECT_TRUE(Fisheye().Project({1, 0, -0.2}, Fisheye().Reach())) << "behind, but seen";
}

TEST(CameraTurn, IsWhatItsRotationHas) {
  const CameraTurn turn{0.02, -0.3, 1.1};
  const CameraTurn back = TurnOfRotation(RotationOfTurn(turn));
  EXPECT_NEAR(back.yaw_rad, turn.yaw_rad, 1e-14);
  EXPECT_NEAR(back.pitch_rad, turn.pitch_rad, 1e-14);
  EXPECT_NEAR(back.roll_rad, turn.roll_rad, 1e-14);
  EXPECT_GT((RotationOfTurn({0.1, 0, 0}) * Vec3d::UnitZ()).x(), 0) << "to the right";
  EXPECT_LT((RotationOfTurn({0, 0.1, 0}) * Vec3d::UnitZ()).y(), 0) << "upwards";
  EXPECT_GT((RotationOfTurn({0, 0, 0.1}) * Vec3d::UnitX()).y(), 0) << "clockwise";
}

}  // namespace
}  // namespace parallax
