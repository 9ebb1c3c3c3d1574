#include "worker/materials/pictures/user_picture.h"

#include <algorithm>
#include <filesystem>

#include "common/image/jpeg.h"
#include "worker/materials/kernel/surface.h"
#include "worker/materials/pictures/mip_picture.h"

namespace parallax {
namespace {

class UserPicture final : public PointMaterial {
 public:
  UserPicture(const ImageRgb8& image, uint64_t seed)
      : picture_(image, MipPicture::Values::kColor,
                 {MipPicture::Edge::kClamp, MipPicture::Edge::kClamp}) {
    Rng rng(SceneSeed{seed}, "user picture");
    roughness_ = Draw(rng, 0.3, 0.7);
  }

  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    // Pictures are taken to be half a metre wide where the renderer doesn't know.
    const float width = point.footprint_uv > 0 ? point.footprint_uv : 2 * point.footprint_m;
    return {.base_color =
                picture_.At(noise::Saturate(point.uv.x()), noise::Saturate(point.uv.y()), width),
            .roughness = roughness_};
  }

 private:
  const MipPicture picture_;
  float roughness_ = 0.5f;
};

std::string& PictureRoot() {
  static auto* root = new std::string;
  return *root;
}

std::string& ContentRoot() {
  static auto* root = new std::string;
  return *root;
}

// `path` with links resolved; empty unless it is below `root`, relative to which it is named.
std::string Below(const std::string& root_name, const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path root = fs::weakly_canonical(root_name, error);
  if (!root.has_filename() && root.has_relative_path()) root = root.parent_path();
  const fs::path full = error ? fs::path() : fs::weakly_canonical(root / path, error);
  const auto [root_end, unused] = std::mismatch(root.begin(), root.end(), full.begin(), full.end());
  return !error && root_end == root.end() ? full.string() : "";
}

}  // namespace

void SetContentRoot(std::string root) { ContentRoot() = std::move(root); }

void SetPictureRoot(std::string root) { PictureRoot() = std::move(root); }

absl::StatusOr<std::string> BelowPictureRoot(const std::string& path) {
  if (!ContentRoot().empty() && !path.empty() && path.front() == '/') {
    if (std::string brought = Below(ContentRoot(), path); !brought.empty()) return brought;
  }
  if (PictureRoot().empty()) {
    return FailedPrecondition(
        "own content {}: this worker has no folder for it; its operator names one with "
        "--picture-root",
        path);
  }
  if (std::string found = Below(PictureRoot(), path); !found.empty()) return found;
  return FailedPrecondition("own content {} is not below this worker's --picture-root {}", path,
                            PictureRoot());
}

absl::StatusOr<std::unique_ptr<const Material>> MakeUserPicture(const std::string& file,
                                                                uint64_t seed) {
  ASSIGN_OR_RETURN(const std::string path, BelowPictureRoot(file));
  ASSIGN_OR_RETURN(const ImageRgb8 image, ReadPictureRgb8(path));
  return std::make_unique<UserPicture>(image, seed);
}

}  // namespace parallax
