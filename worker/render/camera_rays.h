// Rays of a pinhole camera, in single precision.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/camera.h"
#include "worker/render/ray_trees.h"

namespace parallax {

class CameraRays {
 public:
  explicit CameraRays(const PinholeCamera& camera)
      : origin_(camera.origin.cast<float>()),
        corner_((camera.world_from_camera * camera.DirectionAt(0, 0)).cast<float>()),
        right_((camera.world_from_camera.col(0) / camera.fx_px).cast<float>()),
        down_((camera.world_from_camera.col(1) / camera.fy_px).cast<float>()),
        spread_(static_cast<float>(1.0 / camera.fx_px)) {}

  // The ray through the point (x, y) of the picture, in pixels; its cone is a pixel wide.
  Ray Through(float x, float y) const {
    return {origin_, (corner_ + x * right_ + y * down_).normalized(), 0, spread_};
  }
  Rays8 Through(Float8 x, Float8 y) const {
    const Vec3x8 to = corner_ + right_ * x + down_ * y;
    return {Vec3x8(origin_), to / Norm(to)};
  }
  float spread() const { return spread_; }

 private:
  const Vec3f origin_, corner_, right_, down_;
  const float spread_;
};

}  // namespace parallax
