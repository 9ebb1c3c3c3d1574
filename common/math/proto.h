// Conversions between messages of recipes and math types. Pure functions.
#pragma once

#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Convert a vector.
inline Vec3d FromProto(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline v1::Vec3 ToProto(const Vec3d& v) {
  v1::Vec3 out;
  out.set_x(v.x());
  out.set_y(v.y());
  out.set_z(v.z());
  return out;
}
// Converts a pose. The rotation is not normalised; callers that need a unit quaternion do that.
inline Pose FromProto(const v1::Transform& t) {
  return {{t.tx(), t.ty(), t.tz()}, {t.qw(), t.qx(), t.qy(), t.qz()}, t.scale()};
}
inline v1::Transform ToProto(const Pose& pose) {
  v1::Transform out;
  out.set_tx(pose.translation.x());
  out.set_ty(pose.translation.y());
  out.set_tz(pose.translation.z());
  out.set_qw(pose.rotation.w());
  out.set_qx(pose.rotation.x());
  out.set_qy(pose.rotation.y());
  out.set_qz(pose.rotation.z());
  out.set_scale(pose.scale);
  return out;
}

// Returns world_from_object of Scene.objects(object) in a keyframe. Requires that the keyframe has
// it.
inline Pose KeyframePose(const v1::Keyframe& keyframe, int object) {
  const auto at = [&](int k) { return double{keyframe.world_from_object(8 * object + k)}; };
  return {
      {at(0), at(1), at(2)}, Eigen::Quaterniond(at(3), at(4), at(5), at(6)).normalized(), at(7)};
}

}  // namespace parallax
