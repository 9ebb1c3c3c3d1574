// A frame folder back in memory, for pictures, checks and exports.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Maps that were not written are empty images.
struct FrameOnDisk {
  nlohmann::ordered_json json;  // frame.json
  ImageRgb8 left, right;
  ImageF left_disparity_px;
  ImageU8 left_occlusion;
  ImageU16 left_objects, left_materials;
  ImageF3 left_normals;
};

absl::StatusOr<nlohmann::ordered_json> ReadFrameJson(const std::string& frame_dir);

// The left view's maps and both images. Errors: kDataLoss for a map of another size than the image;
// reading as Read*.
absl::StatusOr<FrameOnDisk> ReadFrame(const std::string& frame_dir);

}  // namespace parallax
