// Converts and checks the raw (unrectified) cameras of recipes. Pure functions.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/math/proto.h"
#include "common/math/raw_camera.h"

namespace parallax {

// Converts a raw camera of a recipe. Normalises its rotation; distortion coefficients beyond the
// eighth are ignored.
inline RawIntrinsics FromProto(const v1::RawCamera& raw) {
  RawIntrinsics out;
  out.k = {raw.fx_px(), raw.fy_px(), raw.cx_px(), raw.cy_px()};
  out.width_px = raw.width_px();
  out.height_px = raw.height_px();
  using Model = LensDistortion::Model;
  out.lens.model = raw.lens() == v1::LensConfig::MODEL_BROWN_CONRADY    ? Model::kBrownConrady
                   : raw.lens() == v1::LensConfig::MODEL_KANNALA_BRANDT ? Model::kKannalaBrandt
                                                                        : Model::kNone;
  for (int i = 0; i < raw.distortion_size() && i < 8; ++i) {
    out.lens.c[static_cast<size_t>(i)] = raw.distortion(i);
  }
  out.rectified_from_raw =
      Eigen::Quaterniond(raw.qw(), raw.qx(), raw.qy(), raw.qz()).normalized().toRotationMatrix();
  return out;
}

// Checks that the numbers describe a camera, and that the middle of each side of its picture has a
// direction. Corners need not have one: polynomials fitted to real lenses may end before them.
// Errors: kInvalidArgument, for example with the point that has no direction.
inline absl::Status CheckRawCamera(const v1::RawCamera& raw) {
  const RawIntrinsics camera = FromProto(raw);
  if (camera.width_px <= 0 || camera.height_px <= 0 || camera.width_px > 16384 ||
      camera.height_px > 16384 || !(camera.k.fx_px > 0) || !(camera.k.fy_px > 0) ||
      !camera.rectified_from_raw.allFinite() || !std::isfinite(camera.k.cx_px + camera.k.cy_px)) {
    return InvalidArgument("wants a size, positive focal lengths and a rotation");
  }
  const double reach = camera.lens.Reach();
  const double cx = camera.k.cx_px, cy = camera.k.cy_px;
  for (const Vec2d& p :
       {Vec2d(0, cy), Vec2d(camera.width_px, cy), Vec2d(cx, 0), Vec2d(cx, camera.height_px)}) {
    const Vec2d at((p.x() - cx) / camera.k.fx_px, (p.y() - cy) / camera.k.fy_px);
    if (camera.lens.Unproject(at, reach)) continue;
    return InvalidArgument(
        "its distortion ends within the picture: no direction leads to the point ({:f}, {:f}); "
        "allowed are coefficients for which its sides show something",
        p.x(), p.y());
  }
  return absl::OkStatus();
}

}  // namespace parallax
