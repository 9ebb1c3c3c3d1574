#include "common/image/hdr.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/names.h"
#include "common/image/picture_size.h"

namespace parallax {
namespace {

using Rgbe = std::array<uint8_t, 4>;

// The last line of a header, as in "-Y 512 +X 1024". Scanlines run along the second axis.
struct Resolution {
  bool rows = true;           // Scanlines are rows; else columns.
  bool lines_up = false;      // From the bottom row, or the right column.
  bool pixels_back = false;   // Each scanline from the right, or from the bottom.
  int lines = 0, pixels = 0;  // Scanlines, and pixels of each.
  int width() const { return rows ? pixels : lines; }
  int height() const { return rows ? lines : pixels; }
};

// Takes a line without its end, be it LF or CR LF.
std::string_view TakeLine(std::string_view& bytes) {
  const size_t end = std::min(bytes.find('\n'), bytes.size());
  std::string_view line = bytes.substr(0, end);
  bytes.remove_prefix(std::min(end + 1, bytes.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// Takes "-Y 512": a sign, the axis, its length; 0 where the text is something else.
int TakeAxis(std::string_view& line, char& sign, char& axis) {
  if (line.size() < 4 || line[2] != ' ') return 0;
  sign = line[0];
  axis = line[1];
  line.remove_prefix(std::min(line.find_first_not_of(' ', 2), line.size()));
  int length = 0;
  const auto read = std::from_chars(line.data(), line.data() + line.size(), length);
  line.remove_prefix(static_cast<size_t>(read.ptr - line.data()));
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return read.ec == std::errc() && (sign == '-' || sign == '+') ? length : 0;
}

absl::StatusOr<Resolution> ParseResolution(std::string_view line) {
  char first_sign = 0, first = 0, second_sign = 0, second = 0;
  std::string_view rest = line;
  Resolution found;
  found.lines = TakeAxis(rest, first_sign, first);
  found.pixels = TakeAxis(rest, second_sign, second);
  found.rows = first == 'Y';
  const bool axes = found.rows ? second == 'X' : first == 'X' && second == 'Y';
  if (!axes || !rest.empty() || found.lines <= 0 || found.pixels <= 0) {
    return InvalidArgument("broken .hdr: its size is {}, wanted such as -Y 512 +X 1024",
                           Quoted(line.substr(0, 40)));
  }
  // Y counts upwards and X to the right: -Y begins at the top, -X at the right.
  found.lines_up = first_sign == (found.rows ? '+' : '-');
  found.pixels_back = second_sign == (found.rows ? '-' : '+');
  RETURN_IF_ERROR(
      picture_internal::CheckPictureSize(".hdr", found.width(), found.height(), sizeof(float) * 3));
  return found;
}

// Decodes scanlines one after the other. Each of its functions returns false where the bytes end
// early or do not fit the scanline.
class Scanlines {
 public:
  explicit Scanlines(std::string_view bytes) : bytes_(bytes) {}

  bool Read(std::vector<Rgbe>& line) {
    if (bytes_.size() < 4) return false;
    const auto at = [this](size_t i) { return static_cast<uint8_t>(bytes_[i]); };
    const size_t length = line.size();
    const bool split = length >= 8 && length < 0x8000 && at(0) == 2 && at(1) == 2 && at(2) < 0x80;
    if (!split) return ReadPixels(line);
    if ((size_t{at(2)} << 8 | at(3)) != length) return false;
    bytes_.remove_prefix(4);
    for (size_t channel = 0; channel < 4; ++channel) {
      if (!ReadChannel(line, channel)) return false;
    }
    return true;
  }

  size_t left() const { return bytes_.size(); }

 private:
  // Plain pixels, and in the older encoding runs of the pixel before: 1 1 1 and their number, whose
  // higher bytes follow in further runs.
  bool ReadPixels(std::vector<Rgbe>& line) {
    int shift = 0;
    for (size_t x = 0; x < line.size();) {
      if (bytes_.size() < 4) return false;
      Rgbe pixel;
      for (size_t c = 0; c < 4; ++c) pixel[c] = static_cast<uint8_t>(bytes_[c]);
      bytes_.remove_prefix(4);
      if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
        line[x++] = pixel;
        shift = 0;
        continue;
      }
      if (shift > 16) return false;
      const size_t run = size_t{pixel[3]} << shift;
      if (x == 0 || run > line.size() - x) return false;
      std::fill_n(line.begin() + static_cast<std::ptrdiff_t>(x), run, line[x - 1]);
      x += run;
      shift += 8;
    }
    return true;
  }

  // The newer encoding: each channel for itself, a count and so many values, or above 128 a run.
  bool ReadChannel(std::vector<Rgbe>& line, size_t channel) {
    for (size_t x = 0; x < line.size();) {
      if (bytes_.empty()) return false;
      const auto code = static_cast<uint8_t>(bytes_[0]);
      const bool run = code > 128;
      const size_t count = run ? code & 127u : code, taken = run ? 2 : 1 + count;
      if (count == 0 || count > line.size() - x || bytes_.size() < taken) return false;
      for (size_t i = 0; i < count; ++i) {
        line[x++][channel] = static_cast<uint8_t>(bytes_[run ? 1 : 1 + i]);
      }
      bytes_.remove_prefix(taken);
    }
    return true;
  }

  std::string_view bytes_;
};

}  // namespace

absl::StatusOr<ImageF3> DecodeHdr(std::string_view bytes) {
  if (bytes.substr(0, 2) != "#?") return InvalidArgument("not a .hdr of Radiance's");
  TakeLine(bytes);
  for (std::string_view line; !(line = TakeLine(bytes)).empty();) {
    if (line.starts_with("FORMAT=") && line.find("32-bit_rle_rgbe") == line.npos) {
      return InvalidArgument(".hdr with {}, wanted FORMAT=32-bit_rle_rgbe",
                             Quoted(line.substr(0, 40)));
    }
    if (bytes.empty()) return InvalidArgument("broken .hdr: its header does not end");
  }
  ASSIGN_OR_RETURN(const Resolution size, ParseResolution(TakeLine(bytes)));
  if (bytes.size() < 4 * static_cast<size_t>(size.lines)) {
    return InvalidArgument("broken .hdr: ends early, after {} bytes of pixels", bytes.size());
  }
  ImageF3 image(size.width(), size.height());
  std::vector<Rgbe> line(static_cast<size_t>(size.pixels));
  Scanlines scanlines(bytes);
  for (int i = 0; i < size.lines; ++i) {
    if (!scanlines.Read(line)) {
      return InvalidArgument("broken .hdr: scanline {} of {} ends early or does not fit", i + 1,
                             size.lines);
    }
    const int across = size.lines_up ? size.lines - 1 - i : i;
    for (int j = 0; j < size.pixels; ++j) {
      const int along = size.pixels_back ? size.pixels - 1 - j : j;
      const Rgbe& pixel = line[static_cast<size_t>(j)];
      const float unit = pixel[3] == 0 ? 0 : std::ldexp(1.0f, int{pixel[3]} - (128 + 8));
      float* out = size.rows ? image.At(along, across) : image.At(across, along);
      for (size_t c = 0; c < 3; ++c) out[c] = static_cast<float>(pixel[c]) * unit;
    }
  }
  if (scanlines.left() > 0) {
    return InvalidArgument("broken .hdr: {} bytes follow its last pixel", scanlines.left());
  }
  return image;
}

}  // namespace parallax
