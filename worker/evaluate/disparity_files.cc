#include "worker/evaluate/disparity_files.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"

namespace parallax {
namespace {

constexpr float kKittiSteps = 256;   // Steps a pixel of 16-bit files, where nothing else is said.
constexpr float kDigitSteps = 1000;  // Steps a pixel of 24-bit files.
constexpr size_t kPngDepth = 24, kPngColorType = 25;  // Places in the header of a PNG.
constexpr float kNoDisparity = std::numeric_limits<float>::quiet_NaN();

absl::Status NotNpy(const std::string& what) {
  return InvalidArgument("not a map of disparities in .npy: {}", what);
}

// Numbers of steps do not tell how many of them are a pixel.
absl::Status NeedsScale(std::string_view what) {
  return InvalidArgument(
      "{}, which do not say their scale: put a line `scale: N` before the pair "
      "in its list, where N is the value of one pixel of disparity",
      what);
}

// The text after `key` in a header such as {'descr': '<f4', 'fortran_order': False, 'shape': (2,
// 3), }.
std::string_view ValueOf(std::string_view header, std::string_view key) {
  const size_t at = header.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = header.substr(at + key.size());
  value.remove_prefix(std::min(value.find_first_not_of(": '\""), value.size()));
  return value;
}

// An array as its header describes it.
struct NpyHeader {
  char kind = 0;  // 'f', 'i' or 'u'.
  size_t value_size = 0;
  bool big_endian = false, columns_first = false;
  int width = 0, height = 0;
};

// "(2, 3)..." -> 2 and 3; sides of 1 do not count beside two others.
bool ParseShape(std::string_view text, NpyHeader& header) {
  std::vector<int> sides;
  const size_t end = text.find(')');
  if (!text.starts_with('(') || end == std::string_view::npos) return false;
  text = text.substr(1, end - 1);
  while (!text.empty()) {
    int side = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), side);
    if (read.ec != std::errc() || side <= 0 || side > 1 << 16) return false;
    sides.push_back(side);
    text.remove_prefix(static_cast<size_t>(read.ptr - text.data()));
    if (!text.empty() && text[0] != ',') return false;
    text.remove_prefix(std::min(text.find_first_not_of(", "), text.size()));
  }
  while (sides.size() > 2 && sides.back() == 1) sides.pop_back();
  while (sides.size() > 2 && sides.front() == 1) sides.erase(sides.begin());
  if (sides.size() != 2) return false;
  header.height = sides[0];
  header.width = sides[1];
  return true;
}

// "<f4" and its like.
bool ParseType(std::string_view text, NpyHeader& header) {
  if (text.size() < 3) return false;
  header.big_endian = text[0] == '>';
  header.kind = text[1];
  header.value_size = static_cast<size_t>(text[2] - '0');
  const bool sized = text.size() == 3 || !(text[3] >= '0' && text[3] <= '9');
  const size_t size = header.value_size;
  return std::string_view("<>=|").find(text[0]) != std::string_view::npos && sized &&
         (header.kind == 'f' ? size == 2 || size == 4 || size == 8
                             : (header.kind == 'i' || header.kind == 'u') &&
                                   (size == 1 || size == 2 || size == 4 || size == 8));
}

float HalfToFloat(uint16_t half) {
  const int exponent = half >> 10 & 31, fraction = half & 1023;
  const float sign = half >> 15 != 0 ? -1.0f : 1.0f;
  if (exponent == 31)
    return fraction != 0 ? kNoDisparity : sign * std::numeric_limits<float>::infinity();
  const float whole = exponent == 0 ? 0.0f : 1024.0f;
  return sign * std::ldexp(whole + static_cast<float>(fraction), std::max(exponent, 1) - 25);
}

float ValueAt(const char* bytes, const NpyHeader& header) {
  uint64_t bits = 0;
  for (size_t i = 0; i < header.value_size; ++i) {
    const size_t at = header.big_endian ? i : header.value_size - 1 - i;
    bits = bits << 8 | static_cast<uint8_t>(bytes[at]);
  }
  if (header.kind == 'u') return static_cast<float>(bits);
  if (header.kind == 'i') {
    const size_t unused = 64 - 8 * header.value_size;
    return static_cast<float>(static_cast<int64_t>(bits << unused) >> unused);
  }
  if (header.value_size == 2) return HalfToFloat(static_cast<uint16_t>(bits));
  if (header.value_size == 4) return std::bit_cast<float>(static_cast<uint32_t>(bits));
  return static_cast<float>(std::bit_cast<double>(bits));
}

// Divides steps by their number a pixel; 0 steps are "none".
void ScaleSteps(ImageF& image, float steps) {
  for (float& value : image.values()) value = value == 0 ? kNoDisparity : value / steps;
}

absl::StatusOr<ImageF> FromPng(std::string_view bytes, std::optional<float> steps) {
  constexpr char kPalette = 3;
  if (bytes.size() <= kPngColorType || bytes[kPngDepth] == 16) {
    ASSIGN_OR_RETURN(const ImageU16 png, DecodePngU16(bytes));
    ImageF image(png.width(), png.height());
    std::copy(png.values().begin(), png.values().end(), image.values().begin());
    ScaleSteps(image, steps.value_or(kKittiSteps));
    return image;
  }
  if (bytes[kPngDepth] < 8 && bytes[kPngColorType] != kPalette) {
    return InvalidArgument("PNG of {} bits, wanted 8, 16 or 24", int{bytes[kPngDepth]});
  }
  ASSIGN_OR_RETURN(const ImageRgb8 png, DecodePictureRgb8(bytes));
  ImageF image(png.width(), png.height());
  bool grey = true, digits = true;
  for (size_t i = 0; i < image.pixels(); ++i) {
    const uint8_t* p = png.data() + 3 * i;
    grey &= p[0] == p[1] && p[1] == p[2];
    digits &= p[1] < 255 && p[2] < 255;
    image.values()[i] = static_cast<float>((p[0] * 255 + p[1]) * 255 + p[2]);
  }
  if (!grey && !digits) {
    return InvalidArgument("8-bit colours, no digits to the base 255: a picture for people?");
  }
  if (!grey) {
    ScaleSteps(image, steps.value_or(kDigitSteps));
    return image;
  }
  if (!steps) return NeedsScale("8-bit grey levels");
  for (size_t i = 0; i < image.pixels(); ++i) {
    image.values()[i] = static_cast<float>(png.values()[3 * i]);
  }
  ScaleSteps(image, *steps);
  return image;
}

absl::StatusOr<ImageF> FromFile(std::string_view extension, std::string_view bytes,
                                std::optional<float> steps) {
  if (extension == ".png") return FromPng(bytes, steps);
  if (extension == ".npy") return DecodeNpy(bytes, steps);
  if (extension == ".pfm" || extension == ".exr") {
    ASSIGN_OR_RETURN(ImageF image, extension == ".pfm" ? DecodePfm(bytes) : DecodeExrY(bytes));
    if (steps) ScaleSteps(image, *steps);
    return image;
  }
  return InvalidArgument("a disparity map is a .pfm, .exr, .npy or .png (16, 24 or 8 bits)");
}

}  // namespace

absl::StatusOr<ImageF> DecodeNpy(std::string_view bytes, std::optional<float> steps) {
  static_assert(std::endian::native == std::endian::little);
  if (bytes.substr(0, 6) != "\x93NUMPY" || bytes.size() < 12) return NotNpy("other bytes");
  const bool version_1 = bytes[6] == 1;
  size_t header_size = static_cast<uint8_t>(bytes[8]) + 256u * static_cast<uint8_t>(bytes[9]);
  if (!version_1) header_size += 65536u * static_cast<uint8_t>(bytes[10]);
  const size_t begin = version_1 ? 10 : 12;
  if (bytes.size() < begin + header_size) return NotNpy("it ends early");
  const std::string_view text = bytes.substr(begin, header_size);
  bytes.remove_prefix(begin + header_size);

  NpyHeader header;
  if (!ParseType(ValueOf(text, "'descr'"), header)) {
    return NotNpy("its type is none of floating-point or whole numbers");
  }
  header.columns_first = ValueOf(text, "'fortran_order'").starts_with("True");
  if (!ParseShape(ValueOf(text, "'shape'"), header)) {
    return NotNpy("its shape is not (height, width), (height, width, 1) or (1, height, width)");
  }
  ImageF image;
  const auto width = static_cast<size_t>(header.width), height = static_cast<size_t>(header.height);
  const size_t wanted = header.value_size * width * height;
  if (bytes.size() < wanted) return NotNpy("it ends early");
  if (bytes.size() > wanted) return NotNpy("bytes follow its last value");
  if (header.kind != 'f' && !steps) return NeedsScale("an .npy of whole numbers");
  image = ImageF(header.width, header.height);
  for (size_t i = 0; i < image.pixels(); ++i) {
    const size_t at = header.columns_first ? i % width * height + i / width : i;
    image.values()[i] = ValueAt(bytes.data() + at * header.value_size, header);
  }
  if (steps) ScaleSteps(image, *steps);
  return image;
}

absl::StatusOr<ImageF> ReadDisparity(const std::string& path, std::optional<float> steps) {
  std::string extension = std::filesystem::path(path).extension();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<ImageF> image = FromFile(extension, bytes, steps);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

absl::StatusOr<ImageU8> ReadMask(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  if (!bytes.starts_with("\x89PNG") || (bytes.size() > kPngDepth && bytes[kPngDepth] == 16)) {
    return InvalidArgument("{}: a mask is a PNG of at most 8 bits", path);
  }
  absl::StatusOr<ImageRgb8> picture = DecodePictureRgb8(bytes);
  if (!picture.ok()) return WithContext(picture.status(), path);
  ImageU8 mask(picture->width(), picture->height());
  for (size_t i = 0; i < mask.pixels(); ++i) {
    const uint8_t* p = picture->data() + 3 * i;
    if (p[0] != p[1] || p[1] != p[2]) {
      return InvalidArgument("{}: a mask in colours, wanted grey: 255 visible, 0 left out", path);
    }
    mask.values()[i] = p[0];
  }
  return mask;
}

absl::StatusOr<ImageF> ReadTruth(const std::string& path, std::optional<float> steps,
                                 float largest_px) {
  ASSIGN_OR_RETURN(ImageF disparity_px, ReadDisparity(path, steps));
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
