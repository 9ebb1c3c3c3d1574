// Inner part of common/image: decodes the files of pictures for picture_pair.cc. Thread-safe.
//
// Errors of Decode*: kInvalidArgument for a broken file, or one of a kind that is not read.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax::picture_internal {

// A picture before its values are brought to 8 bits. One of the two images is empty.
struct Decoded {
  ImageRgb8 shallow;        // A file of at most 8 bits.
  Image<uint16_t, 3> deep;  // A file of more.
  int white = 65535;        // The value of `deep` that is white in this kind of file.
  int significant = 65535;  // The largest value of the bits that the file says its camera has.
  std::string note;         // Says what of the file is damaged, but does not matter.
};

// Return whether the bytes begin as such a file does.
bool IsPng(std::string_view bytes);
bool IsJpeg(std::string_view bytes);
bool IsPnm(std::string_view bytes);

// Decode a PNG, a JPEG (upright, by its Exif orientation), or a binary PGM or PPM; grey and
// palettes become R G B, transparent pixels keep their colour.
absl::StatusOr<Decoded> DecodePng(std::string_view bytes);
absl::StatusOr<Decoded> DecodeJpeg(std::string_view bytes);
absl::StatusOr<Decoded> DecodePnm(std::string_view bytes);

}  // namespace parallax::picture_internal
