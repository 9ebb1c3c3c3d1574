#include "common/config/frame_files.h"

#include <algorithm>

namespace parallax {
namespace {

constexpr struct {
  const char* map;
  const char* extension;
} kMaps[] = {{"depth", ".exr"},   {"disparity", ".exr"},      {"occlusion", ".png"},
             {"objects", ".png"}, {"materials", ".png"},      {"normals", ".exr"},
             {"masks", ".png"},   {"exact_occlusion", ".png"}};

}  // namespace

std::vector<std::string> FrameFileNames(const v1::RenderConfig& render) {
  std::vector<std::string> names = {"frame.json", "left.png", "right.png"};
  for (const auto& [map, extension] : kMaps) {
    if (std::find(render.maps().begin(), render.maps().end(), map) == render.maps().end()) continue;
    for (const char* eye : {"_left", "_right"}) names.push_back(std::string(map) + eye + extension);
  }
  if (render.keep_hdr()) names.insert(names.end(), {kLinearFiles[0], kLinearFiles[1]});
  if (std::find(render.maps().begin(), render.maps().end(), "raw") != render.maps().end()) {
    for (const char* eye : {"left", "right"}) {
      names.push_back(std::string("raw_") + eye + ".png");
      names.push_back(std::string("raw_flow_") + eye + ".exr");
      names.push_back(std::string("raw_occlusion_") + eye + ".png");
    }
  }
  if (std::find(render.maps().begin(), render.maps().end(), "flow") != render.maps().end()) {
    for (const char* direction : {"forward", "backward"}) {
      for (const char* eye : {"_left", "_right"}) {
        names.push_back(std::string("flow_") + direction + eye + ".exr");
        names.push_back(std::string("flow_occlusion_") + direction + eye + ".png");
      }
    }
  }
  if (std::find(render.maps().begin(), render.maps().end(), "infrared") != render.maps().end()) {
    names.insert(names.end(), {kInfraredFiles[0], kInfraredFiles[1]});
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace parallax
