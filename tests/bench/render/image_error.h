// The error of a picture against its reference, in numbers and as an eye perceives it.
#pragma once

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax::bench {

struct ImageError {
  double psnr_db = 0;      // From 8-bit values; infinite for equal pictures.
  double flip = 0;         // Mean FLIP, in [0, 1].
  double bias = 0;         // Mean of picture - reference, in 8-bit levels.
  double worst_block = 0;  // Largest mean difference of a channel over 16 x 16 pixels, levels.
};

// Errors: kInvalidArgument when the sizes differ.
absl::StatusOr<ImageError> CompareImages(const ImageRgb8& picture, const ImageRgb8& reference);

// Mean FLIP of two pictures of one size at 67 pixels a degree.
// Source: Andersson et al., "FLIP: a difference evaluator for alternating images", HPG 2020.
double MeanFlip(const ImageRgb8& picture, const ImageRgb8& reference);

// Pictures of one size side by side.
ImageRgb8 SideBySide(const ImageRgb8& left, const ImageRgb8& right);
// |picture - reference| of each channel, `gain` times, for looking.
ImageRgb8 DifferenceImage(const ImageRgb8& picture, const ImageRgb8& reference, int gain);

}  // namespace parallax::bench
