// Pictures and other files that lie beside a mesh.
#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>

#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/image/jpeg.h"
#include "worker/assets/files/mesh_parts.h"
#include "worker/materials/pictures/picture_folder.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

// "a%20b" -> "a b"
std::string WithoutPercents(const std::string& name) {
  std::string out;
  for (size_t i = 0; i < name.size(); ++i) {
    const int high = i + 2 < name.size() ? HexDigit(name[i + 1]) : -1;
    const int low = high >= 0 ? HexDigit(name[i + 2]) : -1;
    if (name[i] != '%' || low < 0 || (high == 0 && low == 0)) {
      out += name[i];
      continue;
    }
    out += static_cast<char>(16 * high + low);
    i += 2;
  }
  return out;
}

std::string WithoutQuotes(std::string_view name) {
  constexpr std::string_view kAround = " \t\r\n\"'";
  name.remove_prefix(std::min(name.find_first_not_of(kAround), name.size()));
  return std::string(name.substr(0, name.find_last_not_of(kAround) + 1));
}

bool LeadsElsewhere(const std::string& name) {
  const fs::path path(name);
  return name.empty() || path.is_absolute() || (name.size() > 1 && name[1] == ':') ||
         name.find("://") != name.npos || std::find(path.begin(), path.end(), "..") != path.end();
}

// Whether walks of content have the file: those of systems are no content.
bool IsContent(const fs::path& name) {
  return std::none_of(name.begin(), name.end(), [](const fs::path& part) {
    return part != "." && IsForeignName(part.string());
  });
}

// The name of the file below `folder` whose name differs in the case of letters only. Errors:
// kNotFound for none, and for several.
absl::StatusOr<std::string> FindInAnyCase(const std::string& folder, const std::string& name) {
  std::vector<std::string> found = {""};
  for (const fs::path& part : fs::path(name).lexically_normal()) {
    std::vector<std::string> deeper;
    for (const std::string& below : found) {
      std::error_code error;
      fs::directory_iterator at(fs::path(folder.empty() ? "." : folder) / below, error);
      for (const fs::directory_iterator end; !error && at != end; at.increment(error)) {
        const std::string seen = at->path().filename().string();
        if (Lower(seen) == Lower(part.string())) {
          deeper.push_back(below.empty() ? seen : below + "/" + seen);
        }
      }
    }
    found = std::move(deeper);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) return NotFound("no such file");
  return NotFound("no such file, and {} that differ in the case of letters", found.size());
}

}  // namespace

absl::StatusOr<std::string> FindBeside(const std::string& folder, const std::string& name) {
  const std::string plain = WithoutQuotes(name);
  std::string slashed = plain;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  std::string last;
  for (const std::string& meant :
       {name, plain, slashed, WithoutPercents(plain), WithoutPercents(slashed)}) {
    if (LeadsElsewhere(meant)) {
      if (meant == slashed) {
        return InvalidArgument("{} lies elsewhere, wanted one beside it", Quoted(plain));
      }
      continue;
    }
    std::error_code error;
    const fs::path normal = fs::path(meant).lexically_normal();
    if (IsContent(normal) && fs::is_regular_file(fs::path(folder) / normal, error)) {
      return normal.string();
    }
    last = meant;
  }
  absl::StatusOr<std::string> found = FindInAnyCase(folder, last);
  if (found.ok() && IsContent(*found)) return found;
  return NotFound("{}: {}", plain, found.ok() ? "no such file" : ToStd(found.status().message()));
}

absl::StatusOr<ImageRgb8> DecodeShrunk(std::string_view bytes, const std::string& name) {
  absl::StatusOr<ImageRgb8> decoded = DecodePictureRgb8(bytes);
  if (!decoded.ok()) {
    return InvalidArgument("its picture {} is {}", name, ToStd(decoded.status().message()));
  }
  constexpr int kMost = 1024;
  ImageRgb8 image = *std::move(decoded);
  while (std::max(image.width(), image.height()) > kMost) {
    ImageRgb8 half(std::max(1, image.width() / 2), std::max(1, image.height() / 2));
    for (int y = 0; y < half.height(); ++y) {
      for (int x = 0; x < half.width(); ++x) {
        const int x1 = std::min(2 * x + 1, image.width() - 1);
        const int y1 = std::min(2 * y + 1, image.height() - 1);
        for (int c = 0; c < 3; ++c) {
          half(x, y, c) = static_cast<uint8_t>((image(2 * x, 2 * y, c) + image(x1, 2 * y, c) +
                                                image(2 * x, y1, c) + image(x1, y1, c) + 2) /
                                               4);
        }
      }
    }
    image = std::move(half);
  }
  return image;
}

absl::StatusOr<ImageRgb8> ReadBeside(const std::string& folder, const std::string& name) {
  const absl::StatusOr<std::string> found = FindBeside(folder, name);
  if (!found.ok()) return InvalidArgument("its picture {}", ToStd(found.status().message()));
  // Only these count for the mesh's hash and are brought along.
  const std::string ending = Lower(fs::path(*found).extension().string());
  if (ending != ".png" && ending != ".jpg" && ending != ".jpeg") {
    return InvalidArgument("its picture {} is named like none, wanted .png, .jpg or .jpeg", *found);
  }
  const absl::StatusOr<std::string> bytes = ReadFile((fs::path(folder) / *found).string());
  if (!bytes.ok()) {
    return InvalidArgument("its picture {}: {}", *found, ToStd(bytes.status().message()));
  }
  return DecodeShrunk(*bytes, *found);
}

}  // namespace parallax
