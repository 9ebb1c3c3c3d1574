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

}  // namespace

void CheckedFrame::Find(const char* check, const std::string& file,
                        const std::string& message) const {
  findings.push_back({check, index.dir + (file.empty() ? "" : "/" + file), message});
}

bool CheckedFrame::IsUsable(const std::string& file, const absl::Status& status, int width,
                            int height) const {
  if (absl::IsNotFound(status)) return false;  // CheckFiles knows what must be there.
  if (!status.ok()) {
    Find("image", file, std::string(ToStd(status.message())));
    return false;
  }
  if (width == k.width && height == k.height) return true;
  Find("size", file, fmt::format("{}x{}, frame.json says {}x{}", width, height, k.width, k.height));
  return false;
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
    const absl::StatusOr<ImageRgb8> color = ReadPngRgb8(frame.index.dir + "/" + eye.name + ".png");
    frame.Take(eye.name + ".png", color.status(), color.ok() ? *color : ImageRgb8(), &eye.color);
    frame.ReadMap("depth", eye, &eye.depth);
    frame.ReadMap("disparity", eye, &eye.disparity);
    frame.ReadMap("occlusion", eye, &eye.occlusion);
    frame.ReadMap("exact_occlusion", eye, &eye.exact_occlusion);
    frame.ReadMap("masks", eye, &eye.masks);
    frame.ReadMap("objects", eye, &eye.objects);
    frame.ReadMap("materials", eye, &eye.materials);
    frame.ReadMap("normals", eye, &eye.normals);
  }
}

}  // namespace parallax
