// PNG files of any kind as pictures: what jpeg.h's ReadPictureRgb8 needs of the PNG code.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Whether bytes begin as a PNG does.
bool IsPng(std::string_view bytes);

// Grey, palettes, 16 bits and transparency become 8-bit R G B. Errors: kInvalidArgument.
absl::StatusOr<ImageRgb8> DecodeAnyPngAsRgb8(std::string_view bytes);

}  // namespace parallax
