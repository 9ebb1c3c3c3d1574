#include "worker/dataset/frame/frame_reader.h"

#include <charconv>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_images.h"

namespace parallax {
absl::StatusOr<nlohmann::ordered_json> ReadFrameJson(const std::string& frame_dir) {
  const std::string path = frame_dir + "/frame.json";
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  nlohmann::ordered_json json =
      nlohmann::ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return DataLoss("{}: not JSON", path);
  return json;
}

FrameIntrinsics IntrinsicsIn(const nlohmann::ordered_json& frame) {
  const nlohmann::ordered_json& k = frame.at("intrinsics");
  return {k.at("fx"), k.at("fy"), k.at("cx"), k.at("cy"), k.at("width"), k.at("height")};
}

std::optional<uint64_t> SeedOf(const nlohmann::ordered_json& value) {
  if (value.is_number_unsigned()) return value.get<uint64_t>();
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return seed;
}

absl::StatusOr<FrameOnDisk> ReadFrame(const std::string& dir) {
  FrameOnDisk frame;
  ASSIGN_OR_RETURN(frame.json, ReadFrameJson(dir));
  ASSIGN_OR_RETURN(frame.left, ReadPngRgb8(dir + "/left.png"));
  ASSIGN_OR_RETURN(frame.right, ReadPngRgb8(dir + "/right.png"));
  RETURN_IF_ERROR(ReadMapIfThere(dir, "disparity", "left", &frame.left_disparity_px));
  RETURN_IF_ERROR(ReadMapIfThere(dir, "occlusion", "left", &frame.left_occlusion));
  RETURN_IF_ERROR(ReadMapIfThere(dir, "objects", "left", &frame.left_objects));
  RETURN_IF_ERROR(ReadMapIfThere(dir, "materials", "left", &frame.left_materials));
  RETURN_IF_ERROR(ReadMapIfThere(dir, "normals", "left", &frame.left_normals));
  const auto fits = [&](const auto& image) {
    return image.empty() ||
           (image.width() == frame.left.width() && image.height() == frame.left.height());
  };
  if (!fits(frame.right) || !fits(frame.left_disparity_px) || !fits(frame.left_occlusion) ||
      !fits(frame.left_objects) || !fits(frame.left_materials) || !fits(frame.left_normals)) {
    return DataLoss("{}: maps of different sizes", dir);
  }
  return frame;
}

}  // namespace parallax
