// The blur of a picture that is exposed while its eye moves through a scene that keeps still.
// Things that move by themselves are blurred as if they stood.
#pragma once

#include "common/image/image.h"
#include "common/math/types.h"

namespace parallax {

// One eye's pinhole camera and its motion, in its own frame: x right, y down, z ahead. The
// picture's own moment is the middle of the exposure.
struct EyeMotion {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  Vec3d velocity_m_s = Vec3d::Zero();
  Vec3d turn_rad_s = Vec3d::Zero();  // About its own axes, right-handed.
  double exposure_s = 0;

  bool IsStill() const;
};

// Returns how far the image of the point at pixel coordinates (x, y) and this depth moves during
// the exposure, in pixels, to first order. Depth 0: at infinity.
Vec2d ImageShift(const EyeMotion& motion, double x_px, double y_px, double depth_m);

// Replaces `light` by its mean over the exposure; shifts of more than 64 pixels count as 64. Near
// things hide what is behind them at each moment; what comes out from behind an edge is not in the
// picture, and continues what is beside it. `depth_m` is as large as `light`; 0: at infinity.
void BlurByMotion(const EyeMotion& motion, const ImageF& depth_m, ImageF3& light);

}  // namespace parallax
