#include "worker/dataset/verify/verify_infrared.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/config/frame_files.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/render/truth/infrared.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFewestDots = 60;         // Fewer say nothing on average.
constexpr double kDarkest = 0.05;       // Reflectance of what hardly shows a dot.
constexpr double kSeenLight = 0.02;     // Linear, after exposure: some 5 levels even in the dark.
constexpr double kLeastContrast = 1;    // Levels.
constexpr double kMostInShadow = 0.25;  // Share of the contrast of lit dots.
constexpr float kSameDepth = 0.01f, kNearer = 0.04f;
constexpr int kInner = 4, kOuter = 6;  // Pixels around a dot that it is compared with.
constexpr uint8_t kShowsOther = kMaskTransparent | kMaskMirror;

// Expected dots of a picture and their contrast to their surroundings.
struct DotSums {
  int count = 0;
  double contrast = 0;  // Levels, all together.
  double expected = 0;  // Linear, after exposure, on what hardly shows a dot.
  double Mean() const { return contrast / std::max(1, count); }
};

class InfraredChecker {
 public:
  InfraredChecker(const DatasetFrame& frame, const Json& json) : frame_(frame), json_(json) {}

  std::vector<Finding> Run() {
    k_ = IntrinsicsIn(json_);
    for (int eye = 0; eye < 2; ++eye) ReadEye(eye);
    const Json& infrared = json_.at("infrared");
    exposure_ = infrared.at("exposure");
    if (!findings_.empty() || !infrared.contains("projector") || !ReadProjector(infrared)) {
      return findings_;
    }
    if (depth_[0].empty() || depth_[1].empty()) return findings_;
    FindNearest();
    for (int eye = 0; eye < 2; ++eye) CheckDots(eye);
    return findings_;
  }

 private:
  void Find(const std::string& file, const std::string& message) {
    findings_.push_back({"infrared", frame_.dir + "/" + file, message});
  }

  void ReadEye(int eye) {
    const std::string name = kInfraredFiles[eye];
    absl::StatusOr<ImageU8> picture = ReadPngU8(frame_.dir + "/" + name);
    if (!picture.ok()) return Find(name, std::string(ToStd(picture.status().message())));
    if (picture->width() != k_.width || picture->height() != k_.height) {
      return Find(name, fmt::format("{}x{}, frame.json says {}x{}", picture->width(),
                                    picture->height(), k_.width, k_.height));
    }
    infrared_[eye] = *std::move(picture);
    const std::string end = eye == 0 ? "left" : "right";
    if (auto depth = ReadExrY(frame_.dir + "/depth_" + end + ".exr"); depth.ok() && Fits(*depth)) {
      depth_[eye] = *std::move(depth);
    }
    if (auto masks = ReadPngU8(frame_.dir + "/masks_" + end + ".png"); masks.ok() && Fits(*masks)) {
      masks_[eye] = *std::move(masks);
    }
  }

  template <typename ImageType>
  bool Fits(const ImageType& image) const {
    return image.width() == k_.width && image.height() == k_.height;
  }

  bool ReadProjector(const Json& infrared) {
    const Json& json = infrared.at("projector");
    v1::Projector projector;
    projector.set_place_m(json.at("place_m"));
    projector.set_power_w(json.at("power_w"));
    projector.set_dots(json.at("dots"));
    projector.set_horizontal_fov_rad(json.at("horizontal_fov_rad"));
    projector.set_vertical_fov_rad(json.at("vertical_fov_rad"));
    projector.set_dot_rad(json.at("dot_rad"));
    const auto seed = SeedOf(json.at("seed"));
    if (!seed) {
      Find("frame.json", "the projector's seed is no number");
      return false;
    }
    projector.set_seed(*seed);
    absl::StatusOr<DotPattern> pattern = DotPattern::Make(projector);
    if (!pattern.ok()) {
      Find("frame.json", std::string(ToStd(pattern.status().message())));
      return false;
    }
    pattern_ = *std::move(pattern);
    const double baseline_m = json_.at("baseline_m");
    // The projector's distance from each eye, along +x.
    away_m_[0] = projector.place_m();
    away_m_[1] = projector.place_m() - baseline_m;
    return true;
  }

  // Column at which the projector, as a camera of the eyes' kind, sees the middle of a pixel.
  double ColumnOf(int eye, int x, float depth) const {
    return x + 0.5 - k_.fx * away_m_[eye] / double{depth};
  }

  // The projector's own depth, as far as the eyes see what it lights. Its rows are theirs.
  void FindNearest() {
    nearest_ = ImageF(k_.width, k_.height, INFINITY);
    for (int eye = 0; eye < 2; ++eye) {
      for (int y = 0; y < k_.height; ++y) {
        for (int x = 0; x < k_.width; ++x) {
          const float z = depth_[eye](x, y);
          if (!(z > 0)) continue;
          const double column = std::floor(ColumnOf(eye, x, z));
          if (!(column >= 0 && column < k_.width)) continue;
          float& nearest = nearest_(static_cast<int>(column), y);
          nearest = std::min(nearest, z);
        }
      }
    }
  }

  // 1: lit; -1: in the shadow of something; 0: not sure.
  int LitAt(int eye, int x, int y) const {
    const float z = depth_[eye](x, y);
    const int column = static_cast<int>(std::floor(ColumnOf(eye, x, z)));
    if (column < 2 || column + 2 >= k_.width) return 0;
    bool all_same = true, all_nearer = true;
    for (int dx = -2; dx <= 2; ++dx) {
      const float nearest = nearest_(column + dx, y);
      all_same = all_same && (nearest == INFINITY || std::abs(nearest - z) <= kSameDepth * z);
      all_nearer = all_nearer && nearest < (1 - kNearer) * z;
    }
    return all_same ? 1 : all_nearer ? -1 : 0;
  }

  // Irradiance, W/m^2, were there no shadows, on a surface that faces the projector.
  ImageF Irradiance(int eye) const {
    ImageF light(k_.width, k_.height);
    for (int y = 0; y < k_.height; ++y) {
      for (int x = 0; x < k_.width; ++x) {
        const double z = double{depth_[eye](x, y)};
        if (!(z > 0)) continue;
        const Vec3f to =
            Vec3d((x + 0.5 - k_.cx) / k_.fx * z - away_m_[eye], (y + 0.5 - k_.cy) / k_.fy * z, z)
                .cast<float>();
        const SampleFootprint footprint{Vec3f(static_cast<float>(z / k_.fx), 0, 0),
                                        Vec3f(0, static_cast<float>(z / k_.fy), 0)};
        light(x, y) = pattern_->Intensity(to, footprint) / to.squaredNorm();
      }
    }
    return light;
  }

  // How much brighter the picture is there than around it, where the pattern is dark.
  std::optional<double> ContrastAt(int eye, int x, int y, const ImageF& light) const {
    double sum = 0;
    int count = 0;
    for (int dy = -kOuter; dy <= kOuter; ++dy) {
      for (int dx = -kOuter; dx <= kOuter; ++dx) {
        if (std::max(std::abs(dx), std::abs(dy)) < kInner) continue;
        const float z = depth_[eye](x + dx, y + dy), here = depth_[eye](x, y);
        if (std::abs(z - here) > 0.05f * here) continue;
        if (light(x + dx, y + dy) > 0.01f * light(x, y)) continue;
        sum += infrared_[eye](x + dx, y + dy);
        ++count;
      }
    }
    if (count < 20) return std::nullopt;
    return infrared_[eye](x, y) - sum / count;
  }

  void CheckDots(int eye) {
    const ImageF light = Irradiance(eye);
    DotSums lit, shadowed;
    for (int y = kOuter; y + kOuter < k_.height; ++y) {
      for (int x = kOuter; x + kOuter < k_.width; ++x) {
        if (!IsDot(light, x, y)) continue;
        if (!masks_[eye].empty() && (masks_[eye](x, y) & kShowsOther) != 0) continue;
        const int how = LitAt(eye, x, y);
        const auto contrast = how == 0 ? std::nullopt : ContrastAt(eye, x, y, light);
        if (!contrast) continue;
        DotSums& sums = how > 0 ? lit : shadowed;
        ++sums.count;
        sums.contrast += *contrast;
        sums.expected +=
            double{light(x, y)} * kDarkest * M_1_PI * exposure_ / double{kAmbientInfrared};
      }
    }
    Judge(eye, lit, shadowed);
  }

  static bool IsDot(const ImageF& light, int x, int y) {
    const float here = light(x, y);
    if (!(here > 0)) return false;
    for (int k = 0; k < 9; ++k) {
      if (k != 4 && light(x + k % 3 - 1, y + k / 3 - 1) >= here) return false;
    }
    return true;
  }

  void Judge(int eye, const DotSums& lit, const DotSums& shadowed) {
    if (lit.count < kFewestDots || lit.expected / lit.count < kSeenLight) return;
    if (lit.Mean() < kLeastContrast) {
      return Find(kInfraredFiles[eye],
                  fmt::format("dots do not stand where depth says: at {} places it is {:.2f} "
                              "levels brighter than around",
                              lit.count, lit.Mean()));
    }
    if (shadowed.count < kFewestDots || shadowed.Mean() <= kMostInShadow * lit.Mean()) return;
    Find(kInfraredFiles[eye], fmt::format("dots stand in the projector's shadow: {} places there "
                                          "are {:.2f} levels brighter than around, lit ones {:.2f}",
                                          shadowed.count, shadowed.Mean(), lit.Mean()));
  }

  const DatasetFrame& frame_;
  const Json& json_;
  FrameIntrinsics k_;
  double exposure_ = 1;
  std::optional<DotPattern> pattern_;
  double away_m_[2] = {0, 0};
  ImageU8 infrared_[2], masks_[2];
  ImageF depth_[2], nearest_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> CheckInfrared(const DatasetFrame& frame, const Json& json) {
  return InfraredChecker(frame, json).Run();
}

}  // namespace parallax
