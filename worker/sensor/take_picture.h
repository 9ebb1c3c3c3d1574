// The picture that a camera takes of a rendered view, with the steps in physical order: exposure,
// motion, lens (defocus, point spread, vignetting), pixels (mosaic, photon and read noise), and
// in-camera processing (demosaicing, white balance, tone curve, JPEG).
#pragma once

#include <cstdint>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/sensor/draw.h"
#include "worker/sensor/motion_blur.h"

namespace parallax {

// One eye's view, as stored with frames.
struct LinearView {
  ImageF3 light;   // Linear, exposed: 1 is white to the tone curve (hdr_*.exr).
  ImageF depth_m;  // Needed for defocus and for eyes that move; else may be empty.
  EyeMotion motion;
};

// The address from which the noise is drawn.
struct SensorAddress {
  SceneSeed seed;
  uint32_t rig = 0;
  int eye = 0;  // 0 left, 1 right.
};

// Takes the picture. Depends only on its arguments. With all numbers 0 the result equals the
// renderer's own picture of that light, except above kFullWell. The noise of the eyes is
// independent. Errors: kInvalidArgument for an empty view, and when depth is needed and has another
// size.
absl::StatusOr<ImageRgb8> TakePicture(const SensorDraw& draw, const SensorAddress& address,
                                      LinearView view);

}  // namespace parallax
