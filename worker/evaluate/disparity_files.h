// Disparity maps in the encodings that benchmarks, predictors and users have, all brought to one
// form: float32 pixels of the left view, from the top row. Thread-safe.
//
// Errors: kInvalidArgument for bytes that do not have the format of the file's name; those of
// ReadFile. Each message names the path.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Known true disparities are finite, > 0 and below this bound, in pixels; all other values become
// 0, "no truth". No benchmark comes near the bound, which common readers apply to Middlebury's
// full-size maps.
inline constexpr float kLargestTruthPx = 1000;

// Decodes a numpy array of floating-point or whole numbers in either byte order, by rows or by
// columns, of shape (height, width), (height, width, 1) or (1, height, width). Whole numbers need
// `steps`, see ReadDisparity.
// Source: numpy.lib.format, versions 1.0 to 3.0.
absl::StatusOr<ImageF> DecodeNpy(std::string_view bytes, std::optional<float> steps = {});

// Reads the values of a file by its extension: .pfm, .exr (channel Y or Z without an X, or its only
// one), .npy or .png. `steps` is the value of one pixel of disparity, by which all values are
// divided; absent: 1 for floating-point numbers, 256 for a PNG of 16 bits, 1000 for one of 24
// (digits to the base 255, as FoundationStereo writes them); 8-bit files and whole numbers in an
// .npy need it. 0 steps mean "none" and become NaN.
absl::StatusOr<ImageF> ReadDisparity(const std::string& path, std::optional<float> steps = {});

// Reads a map like ReadDisparity, and sets pixels without known truth to 0.
absl::StatusOr<ImageF> ReadTruth(const std::string& path, std::optional<float> steps = {},
                                 float largest_px = kLargestTruthPx);

// Reads a grey mask; palettes and R G B count as grey where all their colours are. Errors: those of
// ReadPictureRgb8; kInvalidArgument for a mask in colours.
absl::StatusOr<ImageU8> ReadMask(const std::string& path);

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
