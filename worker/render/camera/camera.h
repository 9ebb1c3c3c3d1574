// A rig's two cameras: pinholes, or before rectification cameras with a lens. Camera frame: x
// right, y down, z forward; pixel centres at integer coordinates + 0.5.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "common/math/raw_rig.h"
#include "common/math/stereo.h"
#include "worker/render/camera/lens_rays.h"

namespace parallax {

// One eye: a pose in the world, and the way from image points to directions.
struct PinholeCamera {
  Vec3d origin = Vec3d::Zero();
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();  // Rotation.
  double fx_px = 1, fy_px = 1, cx_px = 0, cy_px = 0;
  int width_px = 0, height_px = 0;
  std::shared_ptr<const LensRays> lens;  // None: a pinhole.

  // Returns the direction in the camera frame through image point (x, y) in pixels. A pinhole's
  // direction has z = 1; a lens's is unit length, so a measure along it is a distance, not a depth.
  Vec3d DirectionAt(double x, double y) const {
    if (lens != nullptr) return lens->DirectionAt(x, y);
    return {(x - cx_px) / fx_px, (y - cy_px) / fy_px, 1.0};
  }
};

// Both eyes of a rig.
struct StereoCamera {
  PinholeCamera eyes[2];  // Left, right.
  double baseline_m = 0;

  // Errors: kInvalidArgument for an empty image, a focal length or baseline that is not positive,
  // or a number that is not finite.
  static absl::StatusOr<StereoCamera> FromRig(const v1::Rig& rig) {
    const auto& t = rig.world_from_left();
    const double sum = rig.fx_px() + rig.fy_px() + rig.cx_px() + rig.cy_px() + rig.baseline_m() +
                       t.tx() + t.ty() + t.tz() + t.qw() + t.qx() + t.qy() + t.qz();
    const double turn = t.qw() * t.qw() + t.qx() * t.qx() + t.qy() * t.qy() + t.qz() * t.qz();
    if (rig.width_px() <= 0 || rig.height_px() <= 0 || rig.width_px() > 16384 ||
        rig.height_px() > 16384 || !(rig.fx_px() > 0) || !(rig.fy_px() > 0) ||
        !(rig.baseline_m() > 0) || !std::isfinite(sum) || !(turn > 0)) {
      return InvalidArgument(
          "rig {}: wants a size of 1 to 16384 px, positive focal lengths and baseline, a rotation, "
          "finite numbers",
          rig.index());
    }
    StereoCamera stereo;
    stereo.baseline_m = rig.baseline_m();
    for (int eye = 0; eye < 2; ++eye) {
      PinholeCamera& camera = stereo.eyes[eye];
      camera.origin = EyePosition(rig, eye);
      camera.world_from_camera = RigAxes(rig);
      camera.fx_px = rig.fx_px();
      camera.fy_px = rig.fy_px();
      camera.cx_px = rig.cx_px();
      camera.cy_px = rig.cy_px();
      camera.width_px = rig.width_px();
      camera.height_px = rig.height_px();
    }
    return stereo;
  }

  // Returns the rig's cameras before rectification, which it must have.
  // Errors: as FromRig and CheckRawCamera.
  static absl::StatusOr<StereoCamera> RawFromRig(const v1::Rig& rig) {
    ASSIGN_OR_RETURN(StereoCamera stereo, FromRig(rig));
    for (int eye = 0; eye < 2; ++eye) {
      const v1::RawCamera& given = eye == 0 ? rig.raw_left() : rig.raw_right();
      RETURN_IF_ERROR(CheckRawCamera(given));
      const RawIntrinsics raw = FromProto(given);
      PinholeCamera& camera = stereo.eyes[eye];
      camera.world_from_camera = camera.world_from_camera * raw.rectified_from_raw;
      camera.fx_px = raw.k.fx_px;
      camera.fy_px = raw.k.fy_px;
      camera.cx_px = raw.k.cx_px;
      camera.cy_px = raw.k.cy_px;
      camera.width_px = raw.width_px;
      camera.height_px = raw.height_px;
      camera.lens = LensRays::Make(raw);
    }
    return stereo;
  }
};

}  // namespace parallax
