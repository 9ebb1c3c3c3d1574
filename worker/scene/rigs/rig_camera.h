// The camera of a rig, as rigs.camera says. Private to worker/scene.
#pragma once

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/stereo.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// A camera's view for probing, as tangents. The point (x, y) of the picture, each in [-1, 1], lies
// in the direction (shift_x + half_x * x, shift_y + half_y * y, 1).
struct RigCamera {
  Intrinsics k;  // For rigs.width_px x rigs.height_px.
  double half_x = 1, half_y = 1;
  double shift_x = 0, shift_y = 0;  // 0: the axis goes through the middle.

  Vec3d DirectionAt(double x, double y) const {
    return {shift_x + half_x * x, shift_y + half_y * y, 1};
  }
  // Returns the length of the camera's longest ray divided by that of its axis, both up to the same
  // depth.
  double Corner() const;
};

// Draws a camera. `fov_draw` in [0, 1) draws rigs.horizontal_fov_deg, where it is used; all else is
// drawn from children of `stream`.
RigCamera DrawRigCamera(const v1::RigConfig& config, double fov_draw, const Rng& stream);

// Returns the largest baseline that rigs may have.
double LargestBaseline(const v1::RigConfig& config);

// Makes a rig for each of rigs.baselines_m, where there are any: the rigs of one left eye follow
// each other. Numbers the rigs anew.
void AddBaselines(const v1::RigConfig& config, v1::Scene& recipe);

// Adds raw cameras to `rig`, which has its intrinsics, if the config has any. Draws from children
// of `stream`.
void AddRawCameras(const v1::RigConfig& config, const Rng& stream, v1::Rig* rig);

// Checks that every raw camera sees to the sides of its picture (CheckRawCamera). Errors:
// kInvalidArgument, naming the rig, the eye and the point, for a lens whose image ends before.
absl::Status CheckRawCameras(const v1::Scene& scene);

}  // namespace parallax
