// A wall's own frame: x along the wall, y into the room (the inner face is y = 0, the outer y =
// -depth_m), z up. Right-handed, so x runs against the world's coordinate on walls 2 and 3. Pure
// functions.
#pragma once

#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// The frame of one wall of a room.
struct WallFrame {
  Vec2d origin = Vec2d::Zero();  // World place of (0, 0).
  Vec2d along = Vec2d::UnitX();
  Vec2d inward = Vec2d::UnitY();
  double length_m = 0;
  bool reversed = false;  // x runs against the coordinate that Opening.center_m is measured along.
  double yaw_rad = 0;     // Yaw of an object that stands with its back (-y) to the wall.
  double depth_m = 0;     // Thickness of its masonry: the outer face is y = -depth_m.

  double LocalOf(double center_m) const { return reversed ? length_m - center_m : center_m; }
  Vec2d At(double x, double y) const { return origin + along * x + inward * y; }
  Eigen::Affine3f WorldFromWall() const {
    Eigen::Affine3d world = Eigen::Affine3d::Identity();
    world.linear().col(0) = Vec3d(along.x(), along.y(), 0);
    world.linear().col(1) = Vec3d(inward.x(), inward.y(), 0);
    world.translation() = Vec3d(origin.x(), origin.y(), 0);
    return world.cast<float>();
  }
};

// Returns the wall's frame within the room's own frame, whose inner corner is (0, 0). `wall` in [0,
// 3], as Opening.wall.
WallFrame FrameOfWall(const v1::Room& room, int wall);

}  // namespace parallax
