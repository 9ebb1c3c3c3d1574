#include <fmt/core.h>

#include <bit>
#include <charconv>
#include <cstring>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/io.h"

namespace parallax {
namespace {

// The next token of a PFM header and the one white space after it.
std::string_view TakeToken(std::string_view& bytes) {
  const size_t begin = bytes.find_first_not_of(" \n\r\t");
  if (begin == std::string_view::npos) return {};
  const size_t end = bytes.find_first_of(" \n\r\t", begin);
  if (end == std::string_view::npos || end > 64) return {};
  const std::string_view token = bytes.substr(begin, end - begin);
  bytes.remove_prefix(end + 1);
  return token;
}

int ParseSide(std::string_view token) {
  int value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc() && end == token.data() + token.size() && value <= 1 << 16 ? value : 0;
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
  if (TakeToken(bytes) != "Pf") return InvalidArgument("not a one-channel PFM");
  const int width = ParseSide(TakeToken(bytes)), height = ParseSide(TakeToken(bytes));
  const std::string_view scale = TakeToken(bytes);
  if (width <= 0 || height <= 0) return InvalidArgument("PFM of an impossible size");
  if (scale.empty() || scale[0] != '-') {
    return InvalidArgument("PFM in big-endian order, wanted a negative scale");
  }
  const size_t row_bytes = sizeof(float) * static_cast<size_t>(width);
  if (bytes.size() < row_bytes * static_cast<size_t>(height)) {
    return InvalidArgument("PFM ends early");
  }
  ImageF image(width, height);
  for (int y = height - 1; y >= 0; --y) {
    std::memcpy(image.At(0, y), bytes.data(), row_bytes);
    bytes.remove_prefix(row_bytes);
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
