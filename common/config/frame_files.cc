#include "common/config/frame_files.h"

#include <algorithm>

#include "common/config/frame_maps.h"

namespace parallax {
namespace {

// Sorted.
std::vector<std::string> NamesOf(const v1::RenderConfig& render, bool sparse) {
  std::vector<std::string> names;
  if (!sparse) names.emplace_back("frame.json");
  for (const FrameMap& row : FrameMaps()) {
    if (row.sparse != sparse || !row.IsIn(render)) continue;
    for (std::string& name : row.Files()) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::vector<std::string> FrameFileNames(const v1::RenderConfig& render) {
  return NamesOf(render, false);
}

bool AreFrameFiles(const std::vector<std::string>& names, const v1::RenderConfig& render) {
  const std::vector<std::string> wanted = NamesOf(render, false), sparse = NamesOf(render, true);
  std::vector<std::string> more;
  std::set_difference(names.begin(), names.end(), wanted.begin(), wanted.end(),
                      std::back_inserter(more));
  return more.size() + wanted.size() == names.size() &&
         std::includes(sparse.begin(), sparse.end(), more.begin(), more.end());
}

}  // namespace parallax
