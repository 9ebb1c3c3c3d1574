// Floating objects: the code common to rooms and dense scenes. Private to worker/scene.
#pragma once

#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/types.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Returns the classes that may float, each once, with groups (all, chairs, shelves, bushes, nature
// and its families) expanded. Errors: kInvalidArgument for an unknown class or when nothing is
// left.
absl::StatusOr<std::vector<std::string>> FloatingClasses(const v1::SceneConfig& config);

// Draws uniformly from all rotations.   Source: Shoemake, "Uniform random rotations", Graphics Gems
// III.
Eigen::Quaterniond RandomRotation(Rng& rng);

// The view of a rig's left camera, for placing objects in it.
struct RigView {
  Vec3d eye;
  Eigen::Matrix3d axes;     // Columns: right, down, forward; world frame.
  double half_x, half_y;    // Tangents of half of the field of view.
  double shift_x, shift_y;  // Tangents of the picture's middle.
  double baseline_m;
  double time_s;  // When it looks: Rig.time_s.

  static RigView Of(const v1::Rig& rig);
  // Returns the unit direction through a point of the image, x and y in [-1, 1].
  Vec3d Direction(double x, double y) const {
    return (axes * Vec3d(shift_x + half_x * x, shift_y + half_y * y, 1)).normalized();
  }
};

// Returns the object's pose with the middle of its bounds (object frame) at `middle`.
Pose PoseAbout(const Vec3d& middle, const Eigen::Quaterniond& rotation, double scale,
               const Box3f& bounds);

// Returns whether the box of an object (`bounds`: object frame) at `pose` is at least `clearance_m`
// > 0 away from the left eye, from right eyes at baselines of up to `reach_m`, and from all
// between.
bool IsClearOfEyes(const RigView& view, double reach_m, double clearance_m, const Box3f& bounds,
                   const Pose& pose);

}  // namespace parallax
