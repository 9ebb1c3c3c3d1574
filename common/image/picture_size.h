// Inner part of common/image: bounds the size of a picture before its pixels are decoded.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/status.h"

namespace parallax::picture_internal {

// Returns OK if a picture of this size is plausible and if its pixels, of `pixel_bytes` each when
// decoded, fit into the memory of this process. `format` names the file's kind.
// Errors: kInvalidArgument for no pixels, a side of more than 65,536, or more than 2^28 pixels;
// kResourceExhausted, as CheckMemory.
absl::Status CheckPictureSize(std::string_view format, int64_t width, int64_t height,
                              int64_t pixel_bytes);

}  // namespace parallax::picture_internal
