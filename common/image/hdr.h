// Reads linear pictures of other tools: Radiance's .hdr files, and OpenEXR. Thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Decodes the bytes of a .hdr file into linear R G B, rows from the top: plain pixels, and both
// encodings of runs, in any of the eight orientations. EXPOSURE is not applied.
// Errors: kInvalidArgument if the bytes are not such a file, hold X Y Z, or are fewer or more than
// the size in its header needs.   Source: Radiance, src/common/color.c and resolu.c.
absl::StatusOr<ImageF3> DecodeHdr(std::string_view bytes);

// Decodes the picture of an EXR, of one part or several: channels R G B in either case, of several
// layers the unnamed one, Blender's Combined or the only one; without colours the luminance Y.
// Errors: kInvalidArgument for other bytes, and naming the channels or layers that are there.
absl::StatusOr<ImageF3> DecodeExrPicture(std::string_view bytes);

}  // namespace parallax
