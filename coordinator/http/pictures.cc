#include "coordinator/http/pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/image/io.h"
#include "common/image/jpeg.h"

namespace parallax {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr int kJpegQuality = 84;
constexpr int kMakers = 2;

// Each pixel is the mean of the pixels that it covers.
ImageRgb8 Reduced(const ImageRgb8& image, int width_px) {
  const int width = std::min(width_px, image.width());
  const int height = std::max(1, image.height() * width / image.width());
  ImageRgb8 small(width, height);
  for (int y = 0; y < height; ++y) {
    const int top = y * image.height() / height, end = (y + 1) * image.height() / height;
    for (int x = 0; x < width; ++x) {
      const int left = x * image.width() / width, right = (x + 1) * image.width() / width;
      int sum[3] = {0, 0, 0};
      for (int v = top; v < end; ++v) {
        for (int u = left; u < right; ++u) {
          for (int c = 0; c < 3; ++c) sum[c] += image(u, v, c);
        }
      }
      const int count = (end - top) * (right - left);
      for (int c = 0; c < 3; ++c) {
        small(x, y, c) = static_cast<uint8_t>((sum[c] + count / 2) / count);
      }
    }
  }
  return small;
}

template <typename T>
std::string BytesOf(const Image<T>& map) {
  const uint32_t size[2] = {static_cast<uint32_t>(map.width()),
                            static_cast<uint32_t>(map.height())};
  std::string bytes(sizeof size + map.pixels() * sizeof(T), '\0');
  std::memcpy(bytes.data(), size, sizeof size);
  std::memcpy(bytes.data() + sizeof size, map.data(), map.pixels() * sizeof(T));
  return bytes;
}

absl::StatusOr<std::string> MapBytes(const std::string& path, const std::string& file) {
  if (path.ends_with(".exr")) {
    ASSIGN_OR_RETURN(const ImageF map, DecodeExrY(file));
    return BytesOf(map);
  }
  if (const absl::StatusOr<ImageU16> map = DecodePngU16(file); map.ok()) return BytesOf(*map);
  ASSIGN_OR_RETURN(const ImageU8 bits, DecodePngU8(file));
  ImageU16 map(bits.width(), bits.height());
  std::copy(bits.values().begin(), bits.values().end(), map.values().begin());
  return BytesOf(map);
}

}  // namespace

class Pictures::Turn {
 public:
  explicit Turn(Pictures& pictures) : pictures_(pictures) {
    std::unique_lock lock(pictures_.turns_mu_);
    pictures_.turn_.wait(lock, [this] { return pictures_.making_ < kMakers; });
    ++pictures_.making_;
  }
  ~Turn() {
    {
      std::lock_guard lock(pictures_.turns_mu_);
      --pictures_.making_;
    }
    pictures_.turn_.notify_one();
  }

 private:
  Pictures& pictures_;
};

Pictures::Pictures(const Store* store, size_t cache_bytes)
    : store_(store), cache_bytes_(cache_bytes) {}

absl::StatusOr<std::string> Pictures::File(const std::string& path) const {
  if (store_ == nullptr) return NotFound("this coordinator shows no files");
  return store_->Get(path);
}

absl::StatusOr<std::string> Pictures::Jpeg(const std::string& path, int width_px) {
  const std::string key = fmt::format("{}?{}", path, width_px);
  if (std::string kept = Cached(key); !kept.empty()) return kept;
  ASSIGN_OR_RETURN(const std::string file, File(path));
  const Turn turn(*this);
  ASSIGN_OR_RETURN(const ImageRgb8 image, DecodePngRgb8(file));
  ASSIGN_OR_RETURN(std::string bytes, EncodeJpeg(Reduced(image, width_px), kJpegQuality));
  Keep(key, bytes);
  return bytes;
}

absl::StatusOr<std::string> Pictures::Map(const std::string& path) {
  if (std::string kept = Cached(path); !kept.empty()) return kept;
  ASSIGN_OR_RETURN(const std::string file, File(path));
  const Turn turn(*this);
  ASSIGN_OR_RETURN(std::string bytes, MapBytes(path, file));
  Keep(path, bytes);
  return bytes;
}

absl::StatusOr<std::string> Pictures::Normals(const std::string& path) {
  const std::string key = path + "?normals";
  if (std::string kept = Cached(key); !kept.empty()) return kept;
  ASSIGN_OR_RETURN(const std::string file, File(path));
  const Turn turn(*this);
  ASSIGN_OR_RETURN(const ImageF3 normals, DecodeExrRgb(file));
  ImageRgb8 picture(normals.width(), normals.height());
  std::transform(
      normals.values().begin(), normals.values().end(), picture.values().begin(),
      [](float n) { return static_cast<uint8_t>(std::clamp(127.5f * (n + 1), 0.0f, 255.0f)); });
  ASSIGN_OR_RETURN(std::string bytes, EncodeJpeg(picture, kJpegQuality));
  Keep(key, bytes);
  return bytes;
}

std::string Pictures::Cached(const std::string& key) {
  std::lock_guard lock(mu_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return "";
  newest_.splice(newest_.begin(), newest_, found->second);
  return found->second->second;
}

void Pictures::Keep(const std::string& key, const std::string& bytes) {
  std::lock_guard lock(mu_);
  if (bytes.size() > cache_bytes_ || by_key_.count(key) > 0) return;
  newest_.emplace_front(key, bytes);
  by_key_[key] = newest_.begin();
  bytes_ += bytes.size();
  while (bytes_ > cache_bytes_) {
    bytes_ -= newest_.back().second.size();
    by_key_.erase(newest_.back().first);
    newest_.pop_back();
  }
}

}  // namespace parallax
