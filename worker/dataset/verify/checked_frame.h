// A frame whose numbers and maps are in memory to be checked, with the list of what is found wrong
// in it. Private to worker/dataset. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/image/image.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/frame/frame_images.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// The picture and maps of one view, all of the frame's size. One that is not there is empty.
struct CheckedEye {
  std::string name;  // "left" or "right".
  Eigen::Matrix4d world_from_eye = Eigen::Matrix4d::Identity();
  ImageRgb8 color = {};
  ImageF depth = {};      // Metres.
  ImageF disparity = {};  // Pixels.
  ImageU8 occlusion = {}, exact_occlusion = {}, masks = {};
  ImageU16 objects = {}, materials = {};
  ImageF3 normals = {};
};

struct CheckedFrame {
  const DatasetFrame& index;       // Its line of the index. Must outlive the frame.
  std::vector<Finding>& findings;  // Must outlive the frame.
  nlohmann::ordered_json json = {};
  FrameIntrinsics k = {};
  double baseline_m = 0;
  std::array<CheckedEye, 2> eyes = {CheckedEye{"left"}, CheckedEye{"right"}};

  // Reads an eye's file of the row with that stem. One that is not there leaves the image empty;
  // one that can't be read, or of another size than frame.json says, is a finding, too.
  template <typename ImageType>
  void ReadMap(std::string_view stem, const CheckedEye& eye, ImageType* image) const {
    ImageType read;
    const absl::Status status = parallax::ReadMap(index.dir, stem, eye.name, &read);
    Take(MapFile(stem, eye.name), status, std::move(read), image);
  }
  // Sets `image` to what was read of `file` with that status, as ReadMap does.
  template <typename ImageType>
  void Take(const std::string& file, const absl::Status& status, ImageType read,
            ImageType* image) const {
    if (IsUsable(file, status, read.width(), read.height())) *image = std::move(read);
  }

  // Appends a finding in `file` of the frame's folder; "": in the folder itself.
  void Find(const char* check, const std::string& file, const std::string& message) const;

  // Counts the pixels whose number `bad` accepts. Appends a finding that describes the first, if
  // they are more than the share `tolerated` of all.
  template <typename Bad, typename Describe>
  void Pixels(const char* check, const std::string& file, const Bad& bad, const Describe& describe,
              double tolerated = 0) const;

 private:
  bool IsUsable(const std::string& file, const absl::Status& status, int width, int height) const;
  void FindPixels(const char* check, const std::string& file, size_t count, size_t first,
                  const std::string& message) const;
};

// Reads frame.json. Returns nothing if its intrinsics, baseline or poses can't be read or are not
// positive, which is then in `findings`.
std::optional<CheckedFrame> ReadNumbers(const DatasetFrame& index, std::vector<Finding>& findings);

// Reads the pictures and maps that are there. One that can't be read, or of another size than
// frame.json says, is a finding and stays empty.
void ReadMaps(CheckedFrame& frame);

template <typename Bad, typename Describe>
void CheckedFrame::Pixels(const char* check, const std::string& file, const Bad& bad,
                          const Describe& describe, double tolerated) const {
  const size_t total = static_cast<size_t>(k.width) * static_cast<size_t>(k.height);
  size_t count = 0, first = 0;
  for (size_t i = 0; i < total; ++i) {
    if (!bad(i)) continue;
    if (count++ == 0) first = i;
  }
  if (static_cast<double>(count) <= tolerated * static_cast<double>(total)) return;
  FindPixels(check, file, count, first, describe(first));
}

}  // namespace parallax
