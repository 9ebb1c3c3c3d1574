#include "worker/dataset/verify/verify_raw.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/image/io.h"
#include "common/math/raw_camera.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRowTolerance_px = 0.01;
constexpr double kMostOffDisparity = 0.05;  // Share of the visible pixels: edges of things.

struct RawSide {
  std::string name;
  RawIntrinsics camera;
  double reach = 0;
  ImageF3 flow;
  ImageU8 occlusion;
  ImageF disparity;  // Disparity of the rectified view; may be missing.

  // Tangents in the rectified camera's plane; nothing where that looks away.
  std::optional<Vec2d> Rectified(const Vec2d& at) const {
    const auto ray = camera.lens.Unproject(
        {(at.x() - camera.k.cx_px) / camera.k.fx_px, (at.y() - camera.k.cy_px) / camera.k.fy_px},
        reach);
    if (!ray) return std::nullopt;
    const Vec3d turned = camera.rectified_from_raw * *ray;
    if (turned.z() < 0.1) return std::nullopt;
    return Vec2d(turned.head<2>() / turned.z());
  }
};

class RawChecker {
 public:
  RawChecker(const DatasetFrame& frame, const Json& json) : frame_(frame), json_(json) {}

  std::vector<Finding> Run() {
    k_ = {json_.at("intrinsics").at("fx"), json_.at("intrinsics").at("fy"),
          json_.at("intrinsics").at("cx"), json_.at("intrinsics").at("cy")};
    for (RawSide& side : sides_) {
      ReadCamera(json_.at("raw").at(side.name), side);
      if (!ReadImages(side)) return findings_;
    }
    CheckFlow(sides_[0], sides_[1], 1);
    CheckFlow(sides_[1], sides_[0], -1);
    return findings_;
  }

 private:
  void Find(const std::string& file, const std::string& message) {
    findings_.push_back({"raw", frame_.dir + "/" + file, message});
  }

  static void ReadCamera(const Json& json, RawSide& side) {
    RawIntrinsics& camera = side.camera;
    camera.k = {json.at("fx"), json.at("fy"), json.at("cx"), json.at("cy")};
    camera.width_px = json.at("width");
    camera.height_px = json.at("height");
    const std::string lens = json.at("lens");
    using Model = LensDistortion::Model;
    camera.lens.model = lens == "brown_conrady"    ? Model::kBrownConrady
                        : lens == "kannala_brandt" ? Model::kKannalaBrandt
                                                   : Model::kNone;
    const std::vector<double> distortion = json.at("distortion");
    std::copy_n(distortion.begin(), std::min<size_t>(distortion.size(), 8), camera.lens.c.begin());
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        camera.rectified_from_raw(i, j) =
            json.at("rectified_from_raw").at(static_cast<size_t>(i)).at(static_cast<size_t>(j));
      }
    }
    side.reach = camera.lens.Reach();
  }

  template <typename ImageType>
  bool Read(const std::string& file, absl::StatusOr<ImageType> (*read)(const std::string&),
            const RawIntrinsics& camera, ImageType& image) {
    absl::StatusOr<ImageType> result = read(frame_.dir + "/" + file);
    if (!result.ok()) {
      Find(file, std::string(ToStd(result.status().message())));
      return false;
    }
    if (result->width() != camera.width_px || result->height() != camera.height_px) {
      Find(file, fmt::format("{}x{}, frame.json says {}x{}", result->width(), result->height(),
                             camera.width_px, camera.height_px));
      return false;
    }
    image = *std::move(result);
    return true;
  }

  bool ReadImages(RawSide& side) {
    ImageRgb8 color;
    if (!Read("raw_" + side.name + ".png", &ReadPngRgb8, side.camera, color) ||
        !Read("raw_flow_" + side.name + ".exr", &ReadExrRgb, side.camera, side.flow) ||
        !Read("raw_occlusion_" + side.name + ".png", &ReadPngU8, side.camera, side.occlusion)) {
      return false;
    }
    if (auto disparity = ReadExrY(frame_.dir + "/disparity_" + side.name + ".exr");
        disparity.ok()) {
      side.disparity = *std::move(disparity);
    }
    return true;
  }

  // Whether the rectified map has the disparity near the tangents `at`; true outside of it.
  bool AgreesWithMap(const RawSide& side, const Vec2d& at, double disparity) const {
    const int x = static_cast<int>(std::floor(at.x() * k_.fx_px + k_.cx_px - 0.5));
    const int y = static_cast<int>(std::floor(at.y() * k_.fy_px + k_.cy_px - 0.5));
    const ImageF& map = side.disparity;
    if (x < 0 || y < 0 || x + 1 >= map.width() || y + 1 >= map.height()) return true;
    const double slack = std::max(1.0, 0.02 * disparity);
    for (const double d : {map(x, y), map(x + 1, y), map(x, y + 1), map(x + 1, y + 1)}) {
      if (std::abs(d - disparity) <= slack) return true;
    }
    return false;
  }

  // How many rectified pixels are one raw pixel at the raw point `at`, outwards: many where the
  // distortion comes to its end, and there the digits of flow are worth less.
  double Magnification(const RawSide& side, const Vec2d& at, const Vec2d& rectified) const {
    constexpr double kStep_px = 0.01;
    const Vec2d out = at - Vec2d(side.camera.k.cx_px, side.camera.k.cy_px);
    const auto next = side.Rectified(at + kStep_px * out.normalized());
    if (!next) return 1e9;
    return (*next - rectified).norm() * k_.fx_px / kStep_px;
  }

  // `sign` 1: `from` is the left eye.
  void CheckFlow(const RawSide& from, const RawSide& to, double sign) {
    const std::string file = "raw_flow_" + from.name + ".exr";
    int64_t visible = 0, off = 0;
    for (int y = 0; y < from.flow.height(); ++y) {
      for (int x = 0; x < from.flow.width(); ++x) {
        const std::string at = fmt::format("({}, {})", x, y);
        const float* flow = from.flow.At(x, y);
        const uint8_t occluded = from.occlusion(x, y);
        if (!std::isfinite(flow[0]) || !std::isfinite(flow[1]) || (flow[2] != 0 && flow[2] != 1) ||
            (occluded != 0 && occluded != 255)) {
          return Find(file, "the first broken pixel is " + at);
        }
        const Vec2d begin(x + 0.5, y + 0.5), end = begin + Vec2d(flow[0], flow[1]);
        const bool inside = end.x() >= 0 && end.y() >= 0 && end.x() <= to.camera.width_px &&
                            end.y() <= to.camera.height_px;
        if (flow[2] == 0 || !inside) {
          if (occluded == 0) return Find(file, at + " is visible, but leads to no pixel");
          continue;
        }
        const auto a = from.Rectified(begin), b = to.Rectified(end);
        if (!a || !b) continue;
        const double row = (a->y() - b->y()) * k_.fy_px;
        const double disparity = sign * (a->x() - b->x()) * k_.fx_px;
        const double off_px = std::max(std::abs(row), -disparity);
        if (off_px > kRowTolerance_px && off_px > kRowTolerance_px * Magnification(to, end, *b)) {
          return Find(
              file,
              fmt::format(
                  "{}: its ends are {:f} px apart in rectified rows, its disparity is {:f} px", at,
                  row, disparity));
        }
        if (occluded != 0 || from.disparity.empty()) continue;
        ++visible;
        off += !AgreesWithMap(from, *a, disparity);
      }
    }
    if (static_cast<double>(off) > kMostOffDisparity * static_cast<double>(visible)) {
      Find(file, fmt::format("{} of {} visible pixels have another disparity than disparity_{}.exr",
                             off, visible, from.name));
    }
  }

  const DatasetFrame& frame_;
  const Json& json_;
  Intrinsics k_;
  RawSide sides_[2] = {{.name = "left"}, {.name = "right"}};
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> CheckRawPair(const DatasetFrame& frame, const Json& json) {
  return RawChecker(frame, json).Run();
}

}  // namespace parallax
