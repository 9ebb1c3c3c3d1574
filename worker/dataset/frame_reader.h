// Reads a frame folder into memory, for pictures, checks and exports.
#pragma once

#include <cstdint>
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

// Reads frame.json of a frame's folder. Errors: kDataLoss if it is not JSON; reading as ReadFile.
absl::StatusOr<nlohmann::ordered_json> ReadFrameJson(const std::string& frame_dir);

// The rectified pair's pinhole in frame.json.
struct FrameIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // Pixels.
  int width = 0, height = 0;
};
// Throws nlohmann's exceptions where a number is missing or is none.
FrameIntrinsics IntrinsicsIn(const nlohmann::ordered_json& frame);

// A seed in frame.json: a string of decimal digits, because many readers take JSON's numbers for
// doubles; a number in older archives. nullopt: neither.
std::optional<uint64_t> SeedOf(const nlohmann::ordered_json& value);

// Reads both images and the left view's maps. Errors: kDataLoss for a map of another size than the
// image; reading as Read*.
absl::StatusOr<FrameOnDisk> ReadFrame(const std::string& frame_dir);

}  // namespace parallax
