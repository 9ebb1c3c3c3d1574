// Rays through a lens with distortion.
#pragma once

#include <memory>
#include <vector>

#include "common/math/raw_camera.h"

namespace parallax {

// Constant after Make; thread-safe.
class LensRays {
 public:
  static std::shared_ptr<const LensRays> Make(const RawIntrinsics& camera);

  // Returns whether a direction leads to image point (x, y): distortion that was fitted to a real
  // lens may end before the picture's corners.
  bool Sees(double x, double y) const { return whole_ || Unproject(x, y).has_value(); }
  // Returns the unit direction, camera frame, through image point (x, y) in pixels; exact. Where no
  // direction leads to it, returns that of the last reachable point on the way from the principal
  // point.
  Vec3d DirectionAt(double x, double y) const;
  // Returns the same, interpolated linearly between the corners of the pixels: within 1e-3 px. For
  // the many samples of a picture.
  Vec3f SampleAt(float x, float y) const;
  // Returns the image point, in pixels, of a direction in the camera frame; nothing if the lens
  // does not see it. The point may lie outside the picture.
  std::optional<Vec2d> PointOf(const Vec3d& direction) const;

 private:
  explicit LensRays(const RawIntrinsics& camera) : camera_(camera), reach_(camera.lens.Reach()) {}

  std::optional<Vec3d> Unproject(double x, double y) const {
    return camera_.lens.Unproject(
        {(x - camera_.k.cx_px) / camera_.k.fx_px, (y - camera_.k.cy_px) / camera_.k.fy_px}, reach_);
  }

  const RawIntrinsics camera_;
  const double reach_;
  std::vector<Vec3f> corners_;  // Rows of width + 1.
  bool whole_ = false;          // Every corner is seen.
};

}  // namespace parallax
