#include "worker/jobs/files/behind_truth.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "common/base/system/file.h"
#include "common/config/frame_maps.h"
#include "common/image/io.h"
#include "common/math/types.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;
using PathOf = std::function<std::string(const std::string&)>;

constexpr int kMostLayers = 4;
constexpr uint8_t kMoreLayers = 128;
constexpr double kReprojection = 0.01;  // Relative to the depth, as of first surfaces.
constexpr double kStepBack_m = 2e-3;    // The face of a wall belongs to the side that sees it.
constexpr const char* kEyes[2] = {"left", "right"};

// The numbers of frame.json that layers need.
struct FrameNumbers {
  double fx = 1, fy = 1, cx = 0, cy = 0, baseline_m = 1;
  Eigen::Matrix4d world_from_eye[2];
  std::vector<bool> clear = std::vector<bool>(1 << 16);  // Materials.
  std::vector<Eigen::AlignedBox3d> interiors;
};

FrameNumbers NumbersIn(const Json& json) {
  FrameNumbers numbers;
  const Json& k = json.at("intrinsics");
  numbers.fx = k.at("fx"), numbers.fy = k.at("fy"), numbers.cx = k.at("cx"),
  numbers.cy = k.at("cy");
  numbers.baseline_m = json.at("baseline_m");
  for (int eye = 0; eye < 2; ++eye) {
    const Json& rows = json.at(std::string("world_from_") + kEyes[eye]);
    for (size_t i = 0; i < 16; ++i) {
      numbers.world_from_eye[eye](static_cast<int>(i / 4), static_cast<int>(i % 4)) =
          rows.at(i / 4).at(i % 4);
    }
  }
  for (const auto& [index, material] : json.at("materials").items()) {
    const auto place = static_cast<size_t>(std::stoul(index));
    if (place < numbers.clear.size()) numbers.clear[place] = material.contains("clear");
  }
  for (const Json& box : json.at("layers").at("interiors_m")) {
    const auto corner = [&](size_t end) {
      const Json& at = box.at(end);
      return Vec3d(at.at(0).get<double>(), at.at(1).get<double>(), at.at(2).get<double>());
    };
    numbers.interiors.emplace_back(corner(0), corner(1));
  }
  return numbers;
}

// One eye's maps, read as first surfaces and then made those of the last layer.
struct BehindEye {
  ImageU8 count, masks, occlusion;
  ImageF disparity;
  ImageU16 objects, materials;
};

template <typename ImageType>
absl::Status Read(const PathOf& path_of, const std::string& stem, const char* eye,
                  absl::StatusOr<ImageType> (*read)(const std::string&), const ImageU8& size,
                  ImageType* image) {
  const std::string file = MapFile(stem, eye), path = path_of(file);
  if (path.empty()) {
    return FailedPrecondition("no {}, which the truth behind see-through surfaces needs", file);
  }
  ASSIGN_OR_RETURN(*image, read(path));
  if (size.empty() || (image->width() == size.width() && image->height() == size.height())) {
    return absl::OkStatus();
  }
  return DataLoss("{} and {} are of different sizes", file, MapFile("layers", eye));
}

bool IsExterior(const FrameNumbers& numbers, int eye, int x, int y, double disparity_px) {
  if (numbers.interiors.empty()) return false;
  const Vec3d ray((x + 0.5 - numbers.cx) / numbers.fx, (y + 0.5 - numbers.cy) / numbers.fy, 1);
  const double depth_m = numbers.fx * numbers.baseline_m / disparity_px;
  const Vec3d at = ray * depth_m - kStepBack_m * ray.normalized();
  const Eigen::Matrix4d& pose = numbers.world_from_eye[eye];
  const Vec3d point = pose.topLeftCorner<3, 3>() * at + Vec3d(pose.topRightCorner<3, 1>());
  return std::none_of(numbers.interiors.begin(), numbers.interiors.end(),
                      [&](const auto& box) { return box.contains(point); });
}

// Puts the pixels' last layers in place of the first.
absl::Status TakeLast(const PathOf& path_of, const FrameNumbers& numbers, int eye, BehindEye* out) {
  const int most = std::accumulate(
      out->count.values().begin(), out->count.values().end(), 0,
      [](int sum, uint8_t value) { return std::max<int>(sum, value & ~kMoreLayers); });
  for (int n = 2; n <= std::min(most, kMostLayers); ++n) {
    const std::string number = std::to_string(n);
    ImageF disparity;
    ImageU16 objects, materials;
    const ImageU8& size = out->count;
    RETURN_IF_ERROR(Read(path_of, "disparity" + number, kEyes[eye], &ReadExrY, size, &disparity));
    RETURN_IF_ERROR(Read(path_of, "objects" + number, kEyes[eye], &ReadPngU16, size, &objects));
    RETURN_IF_ERROR(Read(path_of, "materials" + number, kEyes[eye], &ReadPngU16, size, &materials));
    for (size_t i = 0; i < out->count.pixels(); ++i) {
      if ((out->count.values()[i] & ~kMoreLayers) != n) continue;
      const float d = disparity.values()[i];
      out->disparity.values()[i] = d;
      out->objects.values()[i] = objects.values()[i];
      out->materials.values()[i] = materials.values()[i];
      const auto x = static_cast<int>(i % static_cast<size_t>(size.width()));
      const auto y = static_cast<int>(i / static_cast<size_t>(size.width()));
      const bool exterior = d > 0 && IsExterior(numbers, eye, x, y, double{d});
      out->masks.values()[i] = exterior ? kMaskExterior : 0;
    }
  }
  for (size_t i = 0; i < out->count.pixels(); ++i) {
    const bool more = (out->count.values()[i] & kMoreLayers) != 0;
    if (!more && !numbers.clear[out->materials.values()[i]]) continue;
    out->disparity.values()[i] = 0;
    out->objects.values()[i] = out->materials.values()[i] = 0;
    out->masks.values()[i] = kMaskSky;
  }
  return absl::OkStatus();
}

// Marks what the other eye does not see of the last layers: the rule of first surfaces, written in
// disparities.
void MarkOccluded(BehindEye* eye, const BehindEye& other, double sign) {
  const int width = eye->disparity.width();
  const auto agrees = [](double a, double d) {
    return a > 0 && std::abs(1 / a - 1 / d) <= kReprojection / d;
  };
  for (int y = 0; y < eye->disparity.height(); ++y) {
    for (int x = 0; x < width; ++x) {
      const double d = double{eye->disparity(x, y)};
      bool visible = !(d > 0) && !(other.disparity(x, y) > 0);
      const double at = x + 0.5 + sign * d;
      if (d > 0 && at >= 0 && at < width) {
        const double c = std::clamp(at - 0.5, 0.0, width - 1.0);
        const int x0 = static_cast<int>(c), x1 = std::min(x0 + 1, width - 1);
        const double a = double{other.disparity(x0, y)}, b = double{other.disparity(x1, y)};
        const double t = c - x0;
        visible =
            agrees(a, d) || agrees(b, d) || (a > 0 && b > 0 && agrees((1 - t) * a + t * b, d));
      }
      eye->occlusion(x, y) = visible ? 0 : 255;
    }
  }
}

}  // namespace

std::vector<std::string> FilesForBehindTruth() {
  std::vector<std::string> files = {"frame.json"};
  for (const FrameMap& row : FrameMaps()) {
    if (row.map != "layers" && row.stem() != "disparity" && row.stem() != "objects" &&
        row.stem() != "materials" && row.stem() != "masks") {
      continue;
    }
    for (std::string& file : row.Files()) files.push_back(std::move(file));
  }
  return files;
}

absl::StatusOr<std::map<std::string, std::string>> MakeBehindTruth(const PathOf& path_of) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path_of("frame.json")));
  FrameNumbers numbers;
  BehindEye eyes[2];
  for (int eye = 0; eye < 2; ++eye) {
    BehindEye& maps = eyes[eye];
    RETURN_IF_ERROR(Read(path_of, "layers", kEyes[eye], &ReadPngU8, {}, &maps.count));
    const ImageU8& size = maps.count;
    RETURN_IF_ERROR(Read(path_of, "disparity", kEyes[eye], &ReadExrY, size, &maps.disparity));
    RETURN_IF_ERROR(Read(path_of, "objects", kEyes[eye], &ReadPngU16, size, &maps.objects));
    RETURN_IF_ERROR(Read(path_of, "materials", kEyes[eye], &ReadPngU16, size, &maps.materials));
    RETURN_IF_ERROR(Read(path_of, "masks", kEyes[eye], &ReadPngU8, size, &maps.masks));
    maps.occlusion = ImageU8(size.width(), size.height());
  }
  try {
    numbers = NumbersIn(Json::parse(text));
  } catch (const Json::exception& error) {
    return DataLoss("frame.json: {}", error.what());
  }
  for (int eye = 0; eye < 2; ++eye) {
    RETURN_IF_ERROR(TakeLast(path_of, numbers, eye, &eyes[eye]));
  }
  MarkOccluded(&eyes[0], eyes[1], -1);
  MarkOccluded(&eyes[1], eyes[0], 1);
  std::map<std::string, std::string> made;
  for (int eye = 0; eye < 2; ++eye) {
    const BehindEye& maps = eyes[eye];
    ASSIGN_OR_RETURN(made[MapFile("disparity", kEyes[eye])], EncodeExrY(maps.disparity));
    ASSIGN_OR_RETURN(made[MapFile("occlusion", kEyes[eye])], EncodePng(maps.occlusion));
    ASSIGN_OR_RETURN(made[MapFile("masks", kEyes[eye])], EncodePng(maps.masks));
    ASSIGN_OR_RETURN(made[MapFile("objects", kEyes[eye])], EncodePng(maps.objects));
    ASSIGN_OR_RETURN(made[MapFile("materials", kEyes[eye])], EncodePng(maps.materials));
  }
  return made;
}

}  // namespace parallax
