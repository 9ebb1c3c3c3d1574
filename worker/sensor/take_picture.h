// The picture that a camera takes of a rendered view, in the order in which light meets its parts:
// exposure, lens (defocus, point spread, vignetting), pixels (mosaic, photon and read noise), and
// the camera's own development (interpolated mosaic, white balance, tone curve, JPEG).
#pragma once

#include <cstdint>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/sensor/draw.h"

namespace parallax {

// One eye's view, as frames keep it.
struct LinearView {
  ImageF3 light;   // Linear, exposed: 1 is what the tone curve takes for bright (hdr_*.exr).
  ImageF depth_m;  // Needed where SensorDraw.defocus_px > 0; else may be empty.
};

// Whose noise it is.
struct SensorAddress {
  SceneSeed seed;
  uint32_t rig = 0;
  int eye = 0;  // 0 left, 1 right.
};

// Depends on nothing but its arguments. With all numbers 0 it is what the renderer itself makes of
// that light, unless brighter than kFullWell. The eyes' noise is independent.
// Errors: kInvalidArgument for an empty view, and when depth is needed and is not of the same size.
absl::StatusOr<ImageRgb8> TakePicture(const SensorDraw& draw, const SensorAddress& address,
                                      LinearView view);

}  // namespace parallax
