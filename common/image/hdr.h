// Radiance's .hdr: linear pictures of shared exponents. Thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Errors: kInvalidArgument for bytes that are none, or that are broken.
absl::StatusOr<ImageF3> DecodeHdr(std::string_view bytes);

}  // namespace parallax
