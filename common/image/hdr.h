// Reads Radiance's .hdr files: linear pictures with a shared exponent for each pixel. Thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Decodes the bytes of a .hdr file into linear R G B, rows from the top.
// Errors: kInvalidArgument if the bytes are not such a file, or a broken one.
absl::StatusOr<ImageF3> DecodeHdr(std::string_view bytes);

}  // namespace parallax
