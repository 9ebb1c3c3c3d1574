// Disparity maps in the encodings that benchmarks, predictors and users have, all brought to one
// form: float32 pixels of the left view, from the top row. Thread-safe.
//
// Errors: kInvalidArgument for bytes that do not have the format of the file's name; those of
// ReadFile. Each message names the path.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Known true disparities are finite, > 0 and below this bound, in pixels; all other values become
// 0, "no truth". No benchmark comes near the bound, which common readers apply to Middlebury's
// full-size maps.
inline constexpr float kLargestTruthPx = 1000;

// Decodes a two-dimensional numpy array of float32 or float64, little-endian, in C order, of shape
// (height, width).
// Source: numpy.lib.format, versions 1.0 and 2.0.
absl::StatusOr<ImageF> DecodeNpy(std::string_view bytes);

// Reads raw values, in the format of the file's extension: .pfm, .exr (channel Y), .npy, or .png
// with 16 bits, divided by `png_scale`; 0 in a PNG means "none" and becomes NaN.
absl::StatusOr<ImageF> ReadDisparity(const std::string& path, float png_scale = 256);

// Reads a map like ReadDisparity, and sets pixels without known truth to 0.
absl::StatusOr<ImageF> ReadTruth(const std::string& path, float png_scale = 256,
                                 float largest_px = kLargestTruthPx);

// Returns the map with 0 wherever the value is not finite, not positive, or not below `largest_px`.
ImageF KnownTruth(ImageF disparity_px, float largest_px = kLargestTruthPx);

// Encodes a 16-bit PNG of disparity * 256, rounded; 0 where the disparity is not finite or not
// positive, 65535 where it exceeds 255.996 px. Errors: those of EncodePng.
absl::StatusOr<std::string> EncodeDisparityPng(const ImageF& disparity_px);

// Return every `step`-th pixel of every `step`-th row; SubsampleDisparity also divides the values
// by `step`: a disparity map at a lower resolution without mixing surfaces.   Source: Booster's
// evaluation at quarter resolution.
ImageF SubsampleDisparity(const ImageF& disparity_px, int step);
ImageU8 Subsample(const ImageU8& image, int step);

}  // namespace parallax
