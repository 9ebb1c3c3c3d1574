#include "common/config/frame_maps.h"

#include <algorithm>
#include <cstdlib>

namespace parallax {
namespace {

constexpr FrameMap kRows[] = {
#include "frame_maps_rows.inc"
};

std::string Replaced(std::string text, std::string_view what, std::string_view with) {
  const size_t at = text.find(what);
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

}  // namespace

std::string_view FrameMap::stem() const {
  const size_t end = file.find("_{");
  return end == std::string_view::npos ? std::string_view() : file.substr(0, end);
}

bool FrameMap::IsIn(const v1::RenderConfig& render) const {
  return map.empty() || (map == kKeepHdr ? render.keep_hdr() : HasMap(render, map));
}

std::string FrameMap::FileOf(std::string_view eye, std::string_view way) const {
  return Replaced(Replaced(std::string(file), "{direction}", way), "{eye}", eye);
}

std::vector<std::string> FrameMap::Files() const {
  if (per == kEye) return {FileOf("left"), FileOf("right")};
  std::vector<std::string> files;
  for (const char* way : {"forward", "backward"}) {
    for (const char* side : {"left", "right"}) files.push_back(FileOf(side, way));
  }
  return files;
}

std::span<const FrameMap> FrameMaps() { return kRows; }

const std::vector<std::string>& FrameMapNames() {
  static const auto& names = *[] {
    auto* all = new std::vector<std::string>;
    for (const FrameMap& row : kRows) {
      if (row.map.empty() || row.map == FrameMap::kKeepHdr) continue;
      if (all->empty() || all->back() != row.map) all->emplace_back(row.map);
    }
    return all;
  }();
  return names;
}

bool HasMap(const v1::RenderConfig& render, std::string_view map) {
  return std::find(render.maps().begin(), render.maps().end(), map) != render.maps().end();
}

const FrameMap& FrameMapOf(std::string_view stem) {
  const auto* row = std::find_if(std::begin(kRows), std::end(kRows),
                                 [&](const auto& r) { return r.stem() == stem; });
  if (row == std::end(kRows)) std::abort();  // Stems are literals of the program.
  return *row;
}

std::string MapFile(std::string_view stem, std::string_view eye) {
  return FrameMapOf(stem).FileOf(eye);
}

}  // namespace parallax
