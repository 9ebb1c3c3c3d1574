// Stereo rigs: two equal pinhole cameras that look the same way. The right camera is baseline_m
// along the left camera's +x, so both images are rectified by construction. Camera frame: x right,
// y down, z forward. Pixel centres are at integer coordinates + 0.5. Pure functions.
#pragma once

#include <cmath>

#include "common/math/proto.h"
#include "common/math/raw_camera.h"

namespace parallax {

// Returns the world axes of a camera without roll; columns: right, down, forward. `yaw_rad` turns
// from world +x towards +y. `pitch_rad` is measured from straight down: pi / 2 looks at the
// horizon.
inline Eigen::Matrix3d CameraAxes(double yaw_rad, double pitch_rad) {
  Eigen::Matrix3d axes;
  axes.col(2) = Vec3d(std::sin(pitch_rad) * std::cos(yaw_rad),
                      std::sin(pitch_rad) * std::sin(yaw_rad), -std::cos(pitch_rad));
  axes.col(0) = Vec3d(std::sin(yaw_rad), -std::cos(yaw_rad), 0);
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

// The placement and cameras of a rig, as a strategy chooses them.
struct RigSpec {
  uint32_t index = 0;                                  // The rig's folder in the dataset.
  Vec3d position = Vec3d::Zero();                      // Left eye, world.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // Columns: right, down, forward; world.
  double baseline_m = 0.1;                             // > 0
  Intrinsics k;                                        // K of both eyes.
  int width_px = 0, height_px = 0;                     // > 0
};

// Returns K with square pixels and the optical axis through the middle of the image.
// `horizontal_fov_rad` is in (0, pi).
inline Intrinsics CentredIntrinsics(double horizontal_fov_rad, int width_px, int height_px) {
  const double focal_px = width_px / 2.0 / std::tan(horizontal_fov_rad / 2);
  return {focal_px, focal_px, width_px / 2.0, height_px / 2.0};
}

// Converts a spec into the recipe's message.
inline v1::Rig MakeRig(const RigSpec& spec) {
  v1::Rig rig;
  rig.set_index(spec.index);
  *rig.mutable_world_from_left() =
      ToProto(Pose{spec.position, Eigen::Quaterniond(spec.axes).normalized(), 1.0});
  rig.set_baseline_m(spec.baseline_m);
  rig.set_width_px(spec.width_px);
  rig.set_height_px(spec.height_px);
  rig.set_fx_px(spec.k.fx_px);
  rig.set_fy_px(spec.k.fy_px);
  rig.set_cx_px(spec.k.cx_px);
  rig.set_cy_px(spec.k.cy_px);
  return rig;
}

// Returns the world axes of both cameras; columns: right, down, forward.
inline Eigen::Matrix3d RigAxes(const v1::Rig& rig) {
  return FromProto(rig.world_from_left()).rotation.normalized().toRotationMatrix();
}

// Returns the world position of eye 0 (left) or 1 (right). All code takes the right eye's position
// from here; only `verify` computes it independently, as a check.
inline Vec3d EyePosition(const v1::Rig& rig, int eye) {
  return FromProto(rig.world_from_left()).translation +
         eye * rig.baseline_m() * RigAxes(rig).col(0);
}

// Returns the pose of eye 0 or 1 as world_from_eye: both eyes have the same rotation.
inline Pose WorldFromEye(const v1::Rig& rig, int eye) {
  Pose pose = FromProto(rig.world_from_left());
  pose.translation = EyePosition(rig, eye);
  return pose;
}

// Returns the tangents of half the horizontal and half the vertical field of view, as if the
// optical axis went through the middle of the image.
inline Vec2d HalfTangents(const v1::Rig& rig) {
  return {rig.width_px() / 2.0 / rig.fx_px(), rig.height_px() / 2.0 / rig.fy_px()};
}

// Returns the tangents (x, y) of the angles from the optical axis to the middle of the image; 0 if
// the axis goes through the middle.
inline Vec2d ShiftTangents(const v1::Rig& rig) {
  return {(rig.width_px() / 2.0 - rig.cx_px()) / rig.fx_px(),
          (rig.height_px() / 2.0 - rig.cy_px()) / rig.fy_px()};
}

}  // namespace parallax
