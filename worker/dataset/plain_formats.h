// Bytes of the plain formats that exports need beside images: numpy arrays and tar archives.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// A little-endian float32 array in C order, (height, width) or (height, width, 3).
// Source: numpy.lib.format, version 1.0.
std::string EncodeNpy(const ImageF& image);
std::string EncodeNpy(const ImageF3& image);

// One member of a tar archive: header, content, padding. The same arguments give the same bytes.
// Source: POSIX.1-1988 ustar. Errors: kInvalidArgument for a name longer than 100 characters.
absl::StatusOr<std::string> TarMember(std::string_view name, std::string_view content);
// What ends an archive.
std::string TarEnd();

}  // namespace parallax
