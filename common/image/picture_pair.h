// Reads the pictures that cameras took. Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// The pictures of a pair.
struct PicturePair {
  ImageRgb8 left, right;           // Equal in size.
  bool rescaled = false;           // Whether values were scaled to use 8 bits.
  std::vector<std::string> notes;  // One line each: `left.png: 16 bits, ...`.
};
// Reads the pictures that two cameras took, as ReadPictureRgb8 of jpeg.h does, and notes damage
// that loses no pixel. Where both use the lower 14 of 16 bits at most, as files of cameras of 10 to
// 14 bits do, their values are scaled, alike in both, and a note says so: white is what sBIT says,
// else the largest value. Errors: those of ReadPictureRgb8; kInvalidArgument, naming both, for
// pictures of two sizes.
absl::StatusOr<PicturePair> ReadPicturePair(const std::string& left, const std::string& right);

// Decodes the picture in `path` and returns notes on damage that loses no pixel. Errors: those of
// ReadPictureRgb8.
absl::StatusOr<std::vector<std::string>> CheckPicture(const std::string& path);

}  // namespace parallax
