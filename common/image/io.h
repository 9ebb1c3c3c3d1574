// Encodes and decodes images as PNG, OpenEXR and PFM, in memory and in files. Encoded images decode
// to the same values, and the same image always gives the same bytes. Thread-safe.
//
// Errors: Encode*: kInvalidArgument for an empty image. Decode*: kInvalidArgument that says what
// the bytes are instead. Read*: those of ReadFile and Decode*, naming the path. Write*: those of
// Encode* and WriteFile.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// zlib's level for PNG, from 1 (fast) to 9 (small). A rendered 1280x720 image takes 0.10 s and 1.04
// MB at level 1, 0.12 s and 1.01 MB at level 2, 0.16 s and 0.98 MB at level 3.
inline constexpr int kPngCompression = 1;

// Encode a PNG with the image's channels and bit depth. `compression` is zlib's level.
absl::StatusOr<std::string> EncodePng(const ImageRgb8& image, int compression = kPngCompression);
absl::StatusOr<std::string> EncodePng(const ImageU8& image, int compression = kPngCompression);
absl::StatusOr<std::string> EncodePng(const ImageU16& image, int compression = kPngCompression);

// Encodes a mask as a PNG of one bit a pixel: white where the image is not 0.
absl::StatusOr<std::string> EncodePngBits(const ImageU8& image);

// Encodes float32 with the one channel "Y", which OpenCV reads as CV_32FC1 (with
// OPENCV_IO_ENABLE_OPENEXR=1).
absl::StatusOr<std::string> EncodeExrY(const ImageF& image);
// Encodes half floats, rounded to nearest; R G B are the image's channels 0 1 2.
absl::StatusOr<std::string> EncodeExrHalfRgb(const ImageF3& image);
// Encodes float32; R G B are the image's channels 0 1 2.
absl::StatusOr<std::string> EncodeExrRgb(const ImageF3& image);
// Encodes float32 as "Pf", little-endian, the bottom row first.
absl::StatusOr<std::string> EncodePfm(const ImageF& image);
// Encodes a PFM with three channels ("PF").
absl::StatusOr<std::string> EncodePfm(const ImageF3& image);

// Decode bytes. A PNG must have the channels and bit depth of the function's name; palettes and
// fewer than 8 bits count as what they expand to. An EXR may hold halves or floats, and layers.
absl::StatusOr<ImageRgb8> DecodePngRgb8(std::string_view bytes);
absl::StatusOr<ImageU8> DecodePngU8(std::string_view bytes);
absl::StatusOr<ImageU16> DecodePngU16(std::string_view bytes);
absl::StatusOr<ImageF> DecodeExrY(std::string_view bytes);
absl::StatusOr<ImageF3> DecodeExrRgb(std::string_view bytes);
absl::StatusOr<ImageF> DecodePfm(std::string_view bytes);

// Read and decode a file.
absl::StatusOr<ImageRgb8> ReadPngRgb8(const std::string& path);
absl::StatusOr<ImageU8> ReadPngU8(const std::string& path);
absl::StatusOr<ImageU16> ReadPngU16(const std::string& path);
absl::StatusOr<ImageF> ReadExrY(const std::string& path);
absl::StatusOr<ImageF3> ReadExrRgb(const std::string& path);
absl::StatusOr<ImageF> ReadPfm(const std::string& path);

absl::Status WritePng(const std::string& path, const ImageRgb8& image,
                      int compression = kPngCompression);
absl::Status WritePng(const std::string& path, const ImageU8& image,
                      int compression = kPngCompression);
absl::Status WritePng(const std::string& path, const ImageU16& image,
                      int compression = kPngCompression);
// Encode and write a file; not durable, see common/base/system/file.h.
absl::Status WriteExrY(const std::string& path, const ImageF& image);
absl::Status WriteExrHalfRgb(const std::string& path, const ImageF3& image);
absl::Status WritePfm(const std::string& path, const ImageF& image);

}  // namespace parallax
