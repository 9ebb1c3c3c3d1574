#include "worker/materials/user_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/image/jpeg.h"
#include "worker/materials/surface.h"

namespace parallax {
namespace {

constexpr int kMaxPixels = 1024;

// Linear colours, halved again and again down to a pixel: the picture from near and far.
struct Level {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;

  const Vec3f& At(int x, int y) const {
    x = std::clamp(x, 0, width - 1);
    y = std::clamp(y, 0, height - 1);
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  Vec3f Bilinear(float u, float v) const {
    const float x = u * static_cast<float>(width) - 0.5f, y = v * static_cast<float>(height) - 0.5f;
    const int i = noise::FloorInt(x), j = noise::FloorInt(y);
    const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
    return Mix(Mix(At(i, j), At(i + 1, j), s), Mix(At(i, j + 1), At(i + 1, j + 1), s), t);
  }
};

Level Halved(const Level& fine) {
  Level out{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out.pixels.push_back(0.25f * (fine.At(2 * x, 2 * y) + fine.At(2 * x + 1, 2 * y) +
                                    fine.At(2 * x, 2 * y + 1) + fine.At(2 * x + 1, 2 * y + 1)));
    }
  }
  return out;
}

class UserPicture final : public PointMaterial {
 public:
  UserPicture(const ImageRgb8& image, uint64_t seed) {
    Rng rng(SceneSeed{seed}, "user picture");
    roughness_ = Draw(rng, 0.3, 0.7);
    Level level{image.width(), image.height(), {}};
    level.pixels.reserve(image.pixels());
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const uint8_t* p = image.At(x, y);
        level.pixels.push_back(Albedo(SrgbColor(static_cast<uint32_t>(p[0]) << 16 |
                                                static_cast<uint32_t>(p[1]) << 8 | p[2])));
      }
    }
    while (std::max(level.width, level.height) > kMaxPixels) level = Halved(level);
    levels_.push_back(std::move(level));
    while (std::max(levels_.back().width, levels_.back().height) > 1) {
      levels_.push_back(Halved(levels_.back()));
    }
  }

  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    // Pictures are taken to be half a metre wide where the renderer doesn't know.
    const float width = point.footprint_uv > 0 ? point.footprint_uv : 2 * point.footprint_m;
    const auto size = static_cast<float>(std::max(levels_[0].width, levels_[0].height));
    const float level = std::clamp(std::log2(std::max(1e-6f, width * size)), 0.0f,
                                   static_cast<float>(levels_.size() - 1));
    const auto low = static_cast<size_t>(level);
    const size_t high = std::min(low + 1, levels_.size() - 1);
    const float u = noise::Saturate(point.uv.x()), v = 1 - noise::Saturate(point.uv.y());
    SurfaceSample out;
    out.base_color = Mix(levels_[low].Bilinear(u, v), levels_[high].Bilinear(u, v),
                         level - static_cast<float>(low));
    out.roughness = roughness_;
    return out;
  }

 private:
  std::vector<Level> levels_;
  float roughness_ = 0.5f;
};

std::string& PictureRoot() {
  static auto* root = new std::string;
  return *root;
}

}  // namespace

void SetPictureRoot(std::string root) { PictureRoot() = std::move(root); }

absl::StatusOr<std::string> BelowPictureRoot(const std::string& path) {
  namespace fs = std::filesystem;
  if (PictureRoot().empty()) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "picture_dir: this worker reads no pictures; its operator names their folder "
                     "with --picture-root");
  }
  std::error_code error;
  fs::path root = fs::weakly_canonical(PictureRoot(), error);
  if (!root.has_filename() && root.has_relative_path()) root = root.parent_path();
  const fs::path full = error ? fs::path() : fs::weakly_canonical(root / path, error);
  const auto [root_end, unused] = std::mismatch(root.begin(), root.end(), full.begin(), full.end());
  if (!error && root_end == root.end()) return full.string();
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      "picture_dir: " + path + " is not below this worker's --picture-root " + PictureRoot());
}

absl::StatusOr<std::unique_ptr<const Material>> MakeUserPicture(const std::string& file,
                                                                uint64_t seed) {
  ASSIGN_OR_RETURN(const std::string path, BelowPictureRoot(file));
  ASSIGN_OR_RETURN(const ImageRgb8 image, ReadPictureRgb8(path));
  return std::make_unique<UserPicture>(image, seed);
}

}  // namespace parallax
