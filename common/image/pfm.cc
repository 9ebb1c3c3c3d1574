#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/image/picture_size.h"

namespace parallax {
namespace {

constexpr std::string_view kBlanks = " \n\r\t";

// Takes the next word of a PFM header; the white space after it stays.
std::string_view TakeWord(std::string_view& bytes) {
  const size_t begin = bytes.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  const size_t end = bytes.find_first_of(kBlanks, begin);
  if (end == std::string_view::npos || end > 64) return {};
  const std::string_view word = bytes.substr(begin, end - begin);
  bytes.remove_prefix(end);
  return word;
}

template <typename Number>
Number NumberOf(std::string_view word) {
  Number value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? value : 0;
}

// Returns whether `gap` may stand between a header and its data: one blank, or blanks and the end
// of the line as some system writes it.
bool EndsHeader(std::string_view gap) {
  if (gap.size() == 1) return kBlanks.find(gap[0]) != std::string_view::npos;
  const size_t blanks = std::min(gap.find_first_not_of(" \t"), gap.size());
  const std::string_view line_end = gap.substr(blanks);
  return line_end == "\n" || line_end == "\r\n" || line_end == "\r";
}

template <int channels>
absl::StatusOr<std::string> EncodeRows(const char* kind, const Image<float, channels>& image) {
  static_assert(std::endian::native == std::endian::little);
  if (image.empty()) return InvalidArgument("PFM of an empty image");
  std::string bytes = fmt::format("{}\n{} {}\n-1\n", kind, image.width(), image.height());
  const size_t row_bytes = sizeof(float) * channels * static_cast<size_t>(image.width());
  for (int y = image.height() - 1; y >= 0; --y) {
    bytes.append(reinterpret_cast<const char*>(image.At(0, y)), row_bytes);
  }
  return bytes;
}

}  // namespace

absl::StatusOr<std::string> EncodePfm(const ImageF& image) { return EncodeRows("Pf", image); }
absl::StatusOr<std::string> EncodePfm(const ImageF3& image) { return EncodeRows("PF", image); }

absl::StatusOr<ImageF> DecodePfm(std::string_view bytes) {
  if (TakeWord(bytes) != "Pf") return InvalidArgument("not a one-channel PFM");
  const int width = NumberOf<int>(TakeWord(bytes)), height = NumberOf<int>(TakeWord(bytes));
  std::string_view scale_word = TakeWord(bytes);
  if (scale_word.starts_with('+')) scale_word.remove_prefix(1);
  const double scale = NumberOf<double>(scale_word);
  RETURN_IF_ERROR(picture_internal::CheckPictureSize("PFM", width, height, sizeof(float)));
  if (!(std::abs(scale) > 0)) {
    return InvalidArgument("PFM with the scale {}, wanted a number other than 0",
                           Quoted(scale_word));
  }
  const size_t row_bytes = sizeof(float) * static_cast<size_t>(width);
  const size_t wanted = row_bytes * static_cast<size_t>(height);
  if (bytes.size() <= wanted) return InvalidArgument("PFM ends early");
  if (!EndsHeader(bytes.substr(0, bytes.size() - wanted))) {
    return InvalidArgument("PFM with {} bytes after its scale, wanted the end of the line and {}",
                           bytes.size(), wanted);
  }
  bytes.remove_prefix(bytes.size() - wanted);
  ImageF image(width, height);
  for (int y = height - 1; y >= 0; --y) {
    std::memcpy(image.At(0, y), bytes.data(), row_bytes);
    bytes.remove_prefix(row_bytes);
  }
  if (scale < 0) return image;  // Little-endian.
  for (float& value : image.values()) {
    value = std::bit_cast<float>(__builtin_bswap32(std::bit_cast<uint32_t>(value)));
  }
  return image;
}

absl::StatusOr<ImageF> ReadPfm(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<ImageF> image = DecodePfm(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

absl::Status WritePfm(const std::string& path, const ImageF& image) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodePfm(image));
  return WriteFile(path, bytes);
}

}  // namespace parallax
