// Which pixels of the left view the right eye sees too, from the two views' true disparities. Pure.
#pragma once

#include "common/image/image.h"

namespace parallax {

// Values of Middlebury's mask0nocc.png.
inline constexpr uint8_t kMaskUnknown = 0, kMaskOccluded = 128, kMaskVisible = 255;

// Returns the mask of visible pixels. A pixel (x, y) with left disparity d is visible if the right
// view's disparity d1 at x1 = round(x - d), halves away from zero, is known and |d - d1| <=
// `tolerance_px`. Otherwise it is occluded, also if x1 lies outside the image. Where d is unknown,
// so is the mask. Disparities are >= 0, with 0 for unknown; both images have the same size.
// Source: Middlebury's stereo SDK 1.6, computemask; with 1 px it gives the published mask of
// Motorcycle at quarter size on every pixel.
ImageU8 VisibilityMask(const ImageF& left_px, const ImageF& right_px, float tolerance_px = 1);

// Returns an image that is 1 where `mask` is kMaskVisible, else 0.
ImageU8 VisibleOf(const ImageU8& mask);

}  // namespace parallax
