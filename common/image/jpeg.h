// Writes JPEGs for previews, and reads the user's own pictures. Thread-safe.
//
// Errors: kInvalidArgument for an empty image, or bytes that are not a picture; those of ReadFile
// and WriteFile.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Encode a JPEG of `quality` 1 to 100, with colour at half resolution as is usual.
absl::StatusOr<std::string> EncodeJpeg(const ImageRgb8& image, int quality);
absl::Status WriteJpeg(const std::string& path, const ImageRgb8& image, int quality);

// Read a PNG or JPEG as 8-bit R G B, turned upright as its camera was held (EXIF orientation).
absl::StatusOr<ImageRgb8> ReadPictureRgb8(const std::string& path);
absl::StatusOr<ImageRgb8> DecodePictureRgb8(std::string_view bytes);

}  // namespace parallax
