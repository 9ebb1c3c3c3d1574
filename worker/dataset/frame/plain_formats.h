// The plain formats that exports need besides images: numpy arrays and tar archives.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Returns a little-endian float32 array in C order, (height, width) or (height, width, 3).
// Source: numpy.lib.format, version 1.0.
std::string EncodeNpy(const ImageF& image);
std::string EncodeNpy(const ImageF3& image);

// Encodes optical flow as Middlebury's .flo: channels 0 and 1 of `flow`, float32. Unknown flow is
// kUnknownFlow there.
// Source: "A database and evaluation methodology for optical flow", Baker et al., flow-code.
inline constexpr float kUnknownFlow = 1e10f;
std::string EncodeFlo(const ImageF3& flow);

// Returns the bits of `value` as a half float: Dynamic Replica keeps depth and flow so in 16-bit
// PNG.
uint16_t HalfBits(float value);

// Packs `bytes` as one member of gzip, without name and time. Errors: kInternal when zlib fails.
absl::StatusOr<std::string> Gzip(std::string_view bytes);

// Encodes one member of a tar archive: header, content, padding. Equal arguments give equal bytes.
// Source: POSIX.1-1988 ustar. Errors: kInvalidArgument for a name longer than 100 characters.
absl::StatusOr<std::string> TarMember(std::string_view name, std::string_view content);
// Returns the two zero blocks that end an archive.
std::string TarEnd();

}  // namespace parallax
