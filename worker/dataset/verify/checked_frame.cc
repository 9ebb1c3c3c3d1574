#include "worker/dataset/verify/checked_frame.h"

#include <fmt/core.h>

#include "common/image/io.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

void ReadPose(const Json& rows, Eigen::Matrix4d& pose) {
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      pose(static_cast<int>(i), static_cast<int>(j)) = rows.at(i).at(j).get<double>();
    }
  }
}

template <typename ImageType>
void Read(const CheckedFrame& frame, const std::string& file,
          absl::StatusOr<ImageType> (*read)(const std::string&), ImageType& image) {
  absl::StatusOr<ImageType> result = read(frame.index.dir + "/" + file);
  if (absl::IsNotFound(result.status())) return;  // CheckFiles knows what must be there.
  if (!result.ok()) {
    frame.Find("image", file, std::string(ToStd(result.status().message())));
    return;
  }
  if (result->width() != frame.k.width || result->height() != frame.k.height) {
    frame.Find("size", file,
               fmt::format("{}x{}, frame.json says {}x{}", result->width(), result->height(),
                           frame.k.width, frame.k.height));
    return;
  }
  image = *std::move(result);
}

}  // namespace

void CheckedFrame::Find(const char* check, const std::string& file,
                        const std::string& message) const {
  findings.push_back({check, index.dir + (file.empty() ? "" : "/" + file), message});
}

void CheckedFrame::FindPixels(const char* check, const std::string& file, size_t count,
                              size_t first, const std::string& message) const {
  const auto w = static_cast<size_t>(k.width), h = static_cast<size_t>(k.height);
  Find(check, file,
       fmt::format("{} of {} pixels, the first at ({}, {}): {}", count, w * h, first % w, first / w,
                   message));
}

std::optional<CheckedFrame> ReadNumbers(const DatasetFrame& index, std::vector<Finding>& findings) {
  CheckedFrame frame{index, findings};
  absl::StatusOr<Json> json = ReadFrameJson(index.dir);
  if (!json.ok()) {
    frame.Find("frame.json", "frame.json", std::string(ToStd(json.status().message())));
    return std::nullopt;
  }
  frame.json = *std::move(json);
  try {
    frame.k = IntrinsicsIn(frame.json);
    frame.baseline_m = frame.json.at("baseline_m");
    for (CheckedEye& eye : frame.eyes) {
      ReadPose(frame.json.at("world_from_" + eye.name), eye.world_from_eye);
    }
  } catch (const Json::exception& error) {
    frame.Find("frame.json", "frame.json", error.what());
    return std::nullopt;
  }
  const FrameIntrinsics& k = frame.k;
  if (!(k.fx > 0 && k.fy > 0 && k.width > 0 && k.height > 0 && frame.baseline_m > 0)) {
    frame.Find("frame.json", "frame.json", "intrinsics and baseline must be positive");
    return std::nullopt;
  }
  return frame;
}

void ReadMaps(CheckedFrame& frame) {
  for (CheckedEye& eye : frame.eyes) {
    Read(frame, eye.name + ".png", &ReadPngRgb8, eye.color);
    Read(frame, "depth_" + eye.name + ".exr", &ReadExrY, eye.depth);
    Read(frame, "disparity_" + eye.name + ".exr", &ReadExrY, eye.disparity);
    Read(frame, "occlusion_" + eye.name + ".png", &ReadPngU8, eye.occlusion);
    Read(frame, "exact_occlusion_" + eye.name + ".png", &ReadPngU8, eye.exact_occlusion);
    Read(frame, "masks_" + eye.name + ".png", &ReadPngU8, eye.masks);
    Read(frame, "objects_" + eye.name + ".png", &ReadPngU16, eye.objects);
    Read(frame, "materials_" + eye.name + ".png", &ReadPngU16, eye.materials);
    Read(frame, "normals_" + eye.name + ".exr", &ReadExrRgb, eye.normals);
  }
}

}  // namespace parallax
