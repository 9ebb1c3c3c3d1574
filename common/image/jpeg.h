// Lossy pictures for previews, and the user's own pictures. Thread-safe.
//
// Errors: kInvalidArgument for an empty image or bytes that are no picture; as ReadFile, WriteFile.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// `quality` 1 to 100, colour at half resolution as is usual.
absl::StatusOr<std::string> EncodeJpeg(const ImageRgb8& image, int quality);
absl::Status WriteJpeg(const std::string& path, const ImageRgb8& image, int quality);

// A PNG or JPEG, made 8-bit R G B and upright as its camera was held.
absl::StatusOr<ImageRgb8> ReadPictureRgb8(const std::string& path);
absl::StatusOr<ImageRgb8> DecodePictureRgb8(std::string_view bytes);

}  // namespace parallax
