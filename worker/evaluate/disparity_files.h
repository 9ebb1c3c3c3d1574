// Disparity maps in the encodings that benchmarks, predictors and users have, all brought to one
// form: float32 pixels of the left view, from the top row. Thread-safe.
//
// Errors: kInvalidArgument for bytes that are not what the name says; reading as ReadFile. Each
// message names the path.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Known true disparities are finite, > 0 and < this; all else becomes 0, "no truth". No pair in use
// comes near; it is what readers apply to Middlebury's full-size maps.
inline constexpr float kLargestTruthPx = 1000;

// A two-dimensional numpy array of float32 or float64, little-endian, C order, as (height, width).
// Source: numpy.lib.format, versions 1.0 and 2.0.
absl::StatusOr<ImageF> DecodeNpy(std::string_view bytes);

// Raw values by the extension: .pfm, .exr (channel Y), .npy, or .png with 16 bits, divided by
// `png_scale`; 0 in a PNG means "none" and becomes NaN.
absl::StatusOr<ImageF> ReadDisparity(const std::string& path, float png_scale = 256);

// As ReadDisparity, with 0 where no truth is known.
absl::StatusOr<ImageF> ReadTruth(const std::string& path, float png_scale = 256,
                                 float largest_px = kLargestTruthPx);

// 0 wherever the value is not finite, not positive, or not below `largest_px`.
ImageF KnownTruth(ImageF disparity_px, float largest_px = kLargestTruthPx);

// 16-bit PNG with disparity * 256, rounded; 0 where it is not finite or not positive, and 65535 for
// what is larger than 255.996 px. Errors: as EncodePng.
absl::StatusOr<std::string> EncodeDisparityPng(const ImageF& disparity_px);

// Every `step`-th pixel of every `step`-th row, values divided by `step`: a disparity map at a
// lower resolution without mixing surfaces.   Source: Booster's evaluation at quarter resolution.
ImageF SubsampleDisparity(const ImageF& disparity_px, int step);
ImageU8 Subsample(const ImageU8& image, int step);

}  // namespace parallax
