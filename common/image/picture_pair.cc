// Pictures of any kind as 8-bit R G B.
#include "common/image/picture_pair.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/jpeg.h"
#include "common/image/picture_codecs.h"
#include "common/image/picture_size.h"

namespace parallax {
namespace {

using picture_internal::Decoded;

// Cameras of 10 to 14 bits leave the upper bits of a file's 16 unused.
constexpr int kMostOfFewBits = (1 << 14) - 1;

absl::StatusOr<Decoded> Decode(std::string_view bytes) {
  if (picture_internal::IsPng(bytes)) return picture_internal::DecodePng(bytes);
  if (picture_internal::IsJpeg(bytes)) return picture_internal::DecodeJpeg(bytes);
  if (picture_internal::IsPnm(bytes)) return picture_internal::DecodePnm(bytes);
  return InvalidArgument("neither a PNG nor a JPEG, PGM or PPM: convert it to one of them");
}

absl::StatusOr<Decoded> ReadDecoded(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<Decoded> decoded = Decode(bytes);
  if (!decoded.ok()) return WithContext(decoded.status(), path);
  return decoded;
}

// The value of a camera's picture that becomes white; 0 for 8 bits. A file that uses only its lower
// bits counts in steps of its camera: the largest that its sBIT allows, or else the largest there
// is.
int WhiteOf(const Decoded& decoded) {
  const auto& values = decoded.deep.values();
  if (values.empty() || decoded.white < 65535) return values.empty() ? 0 : decoded.white;
  const int largest = *std::max_element(values.begin(), values.end());
  if (largest <= decoded.significant && decoded.significant < 65535) return decoded.significant;
  return largest > 0 && largest <= kMostOfFewBits ? largest : 65535;
}

// `white` is a value that becomes 255; 65535 keeps the upper 8 of 16 bits.
ImageRgb8 Scaled(Decoded&& decoded, int white) {
  if (decoded.deep.empty()) return std::move(decoded.shallow);
  ImageRgb8 image(decoded.deep.width(), decoded.deep.height());
  for (size_t i = 0; i < image.values().size(); ++i) {
    const int value = decoded.deep.values()[i];
    image.values()[i] = static_cast<uint8_t>(
        white == 65535 ? value >> 8 : std::min(255, (value * 255 + white / 2) / white));
  }
  return image;
}

void AddNotes(const std::string& path, const Decoded& decoded, int white,
              std::vector<std::string>& notes) {
  if (!decoded.note.empty()) notes.push_back(path + ": read, but damaged: " + decoded.note);
  if (decoded.deep.empty() || white == 65535) return;
  notes.push_back(fmt::format("{}: 16 bits, of which it uses the lower ones: {} is taken as white",
                              path, white));
}

}  // namespace

absl::StatusOr<ImageRgb8> DecodePictureRgb8(std::string_view bytes) {
  ASSIGN_OR_RETURN(Decoded decoded, Decode(bytes));
  return Scaled(std::move(decoded), decoded.white);
}

absl::StatusOr<ImageRgb8> ReadPictureRgb8(const std::string& path) {
  ASSIGN_OR_RETURN(Decoded decoded, ReadDecoded(path));
  return Scaled(std::move(decoded), decoded.white);
}

absl::StatusOr<std::vector<std::string>> CheckPicture(const std::string& path) {
  ASSIGN_OR_RETURN(const Decoded decoded, ReadDecoded(path));
  std::vector<std::string> notes;
  AddNotes(path, decoded, 65535, notes);
  return notes;
}

absl::StatusOr<PicturePair> ReadPicturePair(const std::string& left, const std::string& right) {
  ASSIGN_OR_RETURN(Decoded first, ReadDecoded(left));
  ASSIGN_OR_RETURN(Decoded second, ReadDecoded(right));
  const int white = std::max(WhiteOf(first), WhiteOf(second));
  PicturePair pair;
  AddNotes(left, first, white, pair.notes);
  AddNotes(right, second, white, pair.notes);
  pair.rescaled = (!first.deep.empty() || !second.deep.empty()) && white != 65535;
  pair.left = Scaled(std::move(first), white);
  pair.right = Scaled(std::move(second), white);
  if (pair.left.width() != pair.right.width() || pair.left.height() != pair.right.height()) {
    return InvalidArgument("{}: {}x{}, but {} has {}x{}", right, pair.right.width(),
                           pair.right.height(), left, pair.left.width(), pair.left.height());
  }
  return pair;
}

// ---- PGM and PPM.   Source: netpbm, pgm(5) and ppm(5).

namespace picture_internal {
namespace {

// Takes a number of the header, and the blanks and comments before it; -1 where none exists.
int TakeNumber(std::string_view& bytes) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  for (;;) {
    bytes.remove_prefix(std::min(bytes.find_first_not_of(kBlanks), bytes.size()));
    if (!bytes.starts_with('#')) break;
    bytes.remove_prefix(std::min(bytes.find('\n'), bytes.size()));
  }
  int value = -1;
  const auto read = std::from_chars(bytes.data(), bytes.data() + bytes.size(), value);
  bytes.remove_prefix(static_cast<size_t>(read.ptr - bytes.data()));
  return read.ec == std::errc() ? value : -1;
}

}  // namespace

bool IsPnm(std::string_view bytes) {
  return bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6') &&
         std::string_view(" \t\r\n#").find(bytes[2]) != std::string_view::npos;
}

absl::StatusOr<Decoded> DecodePnm(std::string_view bytes) {
  const size_t channels = bytes[1] == '5' ? 1 : 3;
  bytes.remove_prefix(2);
  const int width = TakeNumber(bytes), height = TakeNumber(bytes), most = TakeNumber(bytes);
  if (width <= 0 || height <= 0 || most <= 0 || most > 65535 || bytes.empty()) {
    return InvalidArgument("broken PGM or PPM: its header");
  }
  RETURN_IF_ERROR(CheckPictureSize("PGM or PPM", width, height, 6));
  bytes.remove_prefix(1);
  const size_t value_bytes = most > 255 ? 2 : 1;
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  if (bytes.size() != pixels * channels * value_bytes) {
    return InvalidArgument("broken PGM or PPM: {} bytes of pixels, wanted {}", bytes.size(),
                           pixels * channels * value_bytes);
  }
  Decoded decoded{.deep = Image<uint16_t, 3>(width, height), .white = most};
  for (size_t i = 0; i < 3 * pixels; ++i) {
    const size_t at = channels == 3 ? i : i / 3;
    const auto byte = [&](size_t n) { return static_cast<uint8_t>(bytes[at * value_bytes + n]); };
    decoded.deep.values()[i] =
        static_cast<uint16_t>(value_bytes == 1 ? byte(0) : byte(0) << 8 | byte(1));
  }
  if (most != 255) return decoded;
  decoded.shallow = Scaled(std::move(decoded), 255);
  decoded.deep = {};
  return decoded;
}

}  // namespace picture_internal
}  // namespace parallax
