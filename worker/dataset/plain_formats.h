// Bytes of the plain formats that exports need beside images: numpy arrays and tar archives.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// A two-dimensional little-endian float32 array in C order, (height, width).
// Source: numpy.lib.format, version 1.0.
std::string EncodeNpy(const ImageF& image);

// Optical flow as Middlebury's .flo: channels 0 and 1 of `flow`, float32. Unknown flow is
// kUnknownFlow there.
// Source: "A database and evaluation methodology for optical flow", Baker et al., flow-code.
inline constexpr float kUnknownFlow = 1e10f;
std::string EncodeFlo(const ImageF3& flow);

// float32 as half floats whose bits are 16-bit numbers: how Dynamic Replica keeps depth and flow in
// PNG.
uint16_t HalfBits(float value);

// gzip, of one member without name and time. Errors: kInternal for what zlib says.
absl::StatusOr<std::string> Gzip(std::string_view bytes);

// One member of a tar archive: header, content, padding. The same arguments give the same bytes.
// Source: POSIX.1-1988 ustar. Errors: kInvalidArgument for a name longer than 100 characters.
absl::StatusOr<std::string> TarMember(std::string_view name, std::string_view content);
// What ends an archive.
std::string TarEnd();

}  // namespace parallax
