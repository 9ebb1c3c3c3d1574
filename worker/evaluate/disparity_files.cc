#include "worker/evaluate/disparity_files.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "common/base/system/file.h"
#include "common/image/io.h"

namespace parallax {
namespace {

absl::Status NotNpy(const std::string& what) {
  return InvalidArgument("not a map of disparities in .npy: {}", what);
}

// The text after `key` in a header such as {'descr': '<f4', 'fortran_order': False, 'shape': (2,
// 3), }.
std::string_view ValueOf(std::string_view header, std::string_view key) {
  const size_t at = header.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = header.substr(at + key.size());
  value.remove_prefix(std::min(value.find_first_not_of(": '"), value.size()));
  return value;
}

// "2, 3)..." -> 2 and 3.
bool ParseShape(std::string_view text, int& height, int& width) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, height);
  if (first.ec != std::errc() || end - first.ptr < 3) return false;
  const auto second = std::from_chars(first.ptr + 2, end, width);
  return second.ec == std::errc() && second.ptr < end && *second.ptr == ')' && height > 0 &&
         width > 0 && height <= 1 << 16 && width <= 1 << 16;
}

template <typename T>
ImageF FromRaw(std::string_view bytes, int width, int height) {
  ImageF image(width, height);
  for (size_t i = 0; i < image.pixels(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    image.values()[i] = static_cast<float>(value);
  }
  return image;
}

absl::StatusOr<ImageF> ReadNpy(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<ImageF> image = DecodeNpy(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

absl::StatusOr<ImageF> ReadPng16(const std::string& path, float scale) {
  ASSIGN_OR_RETURN(const ImageU16 png, ReadPngU16(path));
  ImageF image(png.width(), png.height());
  for (size_t i = 0; i < png.pixels(); ++i) {
    const uint16_t value = png.values()[i];
    image.values()[i] =
        value == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(value) / scale;
  }
  return image;
}

}  // namespace

absl::StatusOr<ImageF> DecodeNpy(std::string_view bytes) {
  static_assert(std::endian::native == std::endian::little);
  if (bytes.substr(0, 6) != "\x93NUMPY" || bytes.size() < 12) return NotNpy("other bytes");
  const bool version_1 = bytes[6] == 1;
  size_t header_size = static_cast<uint8_t>(bytes[8]) + 256u * static_cast<uint8_t>(bytes[9]);
  if (!version_1) header_size += 65536u * static_cast<uint8_t>(bytes[10]);
  const size_t begin = version_1 ? 10 : 12;
  if (bytes.size() < begin + header_size) return NotNpy("it ends early");
  const std::string_view header = bytes.substr(begin, header_size);
  bytes.remove_prefix(begin + header_size);

  const std::string_view type = ValueOf(header, "'descr'").substr(0, 3);
  if (type != "<f4" && type != "<f8") return NotNpy("its type is not <f4 or <f8");
  if (!ValueOf(header, "'fortran_order'").starts_with("False")) return NotNpy("Fortran order");
  std::string_view shape = ValueOf(header, "'shape'");
  int height = 0, width = 0;
  if (shape.empty() || !ParseShape(shape.substr(1), height, width)) {
    return NotNpy("its shape is not (height, width)");
  }
  const size_t value_size = type == "<f4" ? 4 : 8;
  if (bytes.size() < value_size * static_cast<size_t>(height) * static_cast<size_t>(width)) {
    return NotNpy("it ends early");
  }
  return value_size == 4 ? FromRaw<float>(bytes, width, height)
                         : FromRaw<double>(bytes, width, height);
}

absl::StatusOr<ImageF> ReadDisparity(const std::string& path, float png_scale) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".pfm") return ReadPfm(path);
  if (extension == ".exr") return ReadExrY(path);
  if (extension == ".npy") return ReadNpy(path);
  if (extension == ".png") return ReadPng16(path, png_scale);
  return InvalidArgument("{}: a disparity map is a .pfm, .exr, .npy or 16-bit .png", path);
}

absl::StatusOr<ImageF> ReadTruth(const std::string& path, float png_scale, float largest_px) {
  ASSIGN_OR_RETURN(ImageF disparity_px, ReadDisparity(path, png_scale));
  return KnownTruth(std::move(disparity_px), largest_px);
}

ImageF KnownTruth(ImageF disparity_px, float largest_px) {
  for (float& value : disparity_px.values()) {
    if (!(value > 0 && value < largest_px)) value = 0;
  }
  return disparity_px;
}

absl::StatusOr<std::string> EncodeDisparityPng(const ImageF& disparity_px) {
  ImageU16 png(disparity_px.width(), disparity_px.height());
  for (size_t i = 0; i < png.pixels(); ++i) {
    const float value = disparity_px.values()[i];
    if (!std::isfinite(value) || value <= 0) continue;
    png.values()[i] = static_cast<uint16_t>(std::clamp(std::round(value * 256), 1.0f, 65535.0f));
  }
  return EncodePng(png);
}

ImageF SubsampleDisparity(const ImageF& disparity_px, int step) {
  ImageF small((disparity_px.width() + step - 1) / step, (disparity_px.height() + step - 1) / step);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      small(x, y) = disparity_px(x * step, y * step) / static_cast<float>(step);
    }
  }
  return small;
}

ImageU8 Subsample(const ImageU8& image, int step) {
  ImageU8 small((image.width() + step - 1) / step, (image.height() + step - 1) / step);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) small(x, y) = image(x * step, y * step);
  }
  return small;
}

}  // namespace parallax
