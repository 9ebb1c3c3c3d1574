// Camera rays in world space, single precision. Constant; thread-safe.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/camera/camera.h"
#include "worker/render/scene/ray_trees.h"

namespace parallax {

// Makes the rays of one eye; keeps its lens alive.
class CameraRays {
 public:
  explicit CameraRays(const PinholeCamera& camera)
      : origin_(camera.origin.cast<float>()),
        corner_((camera.world_from_camera *
                 Vec3d(-camera.cx_px / camera.fx_px, -camera.cy_px / camera.fy_px, 1))
                    .cast<float>()),
        right_((camera.world_from_camera.col(0) / camera.fx_px).cast<float>()),
        down_((camera.world_from_camera.col(1) / camera.fy_px).cast<float>()),
        spread_(static_cast<float>(1.0 / camera.fx_px)),
        lens_(camera.lens),
        world_from_camera_(camera.world_from_camera.cast<float>()) {}

  // Returns the ray through image point (x, y) in pixels. Its cone is one pixel wide.
  Ray Through(float x, float y) const {
    if (lens_ != nullptr) return {origin_, world_from_camera_ * lens_->SampleAt(x, y), 0, spread_};
    return {origin_, (corner_ + x * right_ + y * down_).normalized(), 0, spread_};
  }
  // Returns the same for eight points.
  Rays8 Through(Float8 x, Float8 y) const {
    if (lens_ != nullptr) return ThroughLens(x, y);
    const Vec3x8 to = corner_ + right_ * x + down_ * y;
    return {Vec3x8(origin_), to / Norm(to)};
  }
  // Radians by which a ray's cone widens.
  float spread() const { return spread_; }
  const Vec3f& origin() const { return origin_; }

 private:
  Rays8 ThroughLens(Float8 x, Float8 y) const {
    Rays8 rays{Vec3x8(origin_), Vec3x8::Zero()};
    for (int k = 0; k < kLanes; ++k) {
      rays.direction.Set(k, world_from_camera_ * lens_->SampleAt(x[k], y[k]));
    }
    return rays;
  }

  const Vec3f origin_, corner_, right_, down_;
  const float spread_;
  const std::shared_ptr<const LensRays> lens_;
  const Mat3f world_from_camera_;
};

}  // namespace parallax
