// Reads PNG files of any kind as pictures, for ReadPictureRgb8 of jpeg.h. Thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Returns whether the bytes begin with the signature of PNG.
bool IsPng(std::string_view bytes);

// Decodes a PNG; grey, palettes, 16 bits and transparency become 8-bit R G B. Errors:
// kInvalidArgument for a broken file.
absl::StatusOr<ImageRgb8> DecodeAnyPngAsRgb8(std::string_view bytes);

}  // namespace parallax
