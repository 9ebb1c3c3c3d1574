// Reads a frame folder into memory, for pictures, checks and exports.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// A frame in memory. Maps that were not written are empty images.
struct FrameOnDisk {
  nlohmann::ordered_json json;  // frame.json
  ImageRgb8 left, right;
  ImageF left_disparity_px;
  ImageU8 left_occlusion;
  ImageU16 left_objects, left_materials;
  ImageF3 left_normals;
};

// Reads frame.json of a frame's folder. Errors: kDataLoss if it is not JSON; those of ReadFile.
absl::StatusOr<nlohmann::ordered_json> ReadFrameJson(const std::string& frame_dir);

// Returns what `read` returns, which reads the frame.json of this folder with nlohmann's functions.
// Errors: kDataLoss naming the file where they throw, because something in it is missing or of
// another type; those of `read`.
template <typename Read>
auto CatchJson(const std::string& frame_dir, Read read) -> decltype(read()) {
  try {
    return read();
  } catch (const nlohmann::json::exception& error) {
    return DataLoss("{}/frame.json: {}", frame_dir, error.what());
  }
}

// The rectified pair's pinhole in frame.json.
struct FrameIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // Pixels.
  int width = 0, height = 0;
};
// Returns the intrinsics in a frame.json. Throws nlohmann's exceptions if a number is missing or of
// another type.
FrameIntrinsics IntrinsicsIn(const nlohmann::ordered_json& frame);

// Returns a seed of frame.json; nothing if `value` is no seed. Seeds are strings of decimal digits,
// because many readers of JSON turn numbers into doubles; in older archives they are numbers.
std::optional<uint64_t> SeedOf(const nlohmann::ordered_json& value);

// Reads both images and the left view's maps. Errors: kDataLoss for a map of another size than the
// image; those of reading the files.
absl::StatusOr<FrameOnDisk> ReadFrame(const std::string& frame_dir);

}  // namespace parallax
