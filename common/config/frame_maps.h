// The table of a frame's maps: what config, writer, reader, checks, exports, sheets, Python and the
// page know of them. Its rows are in frame_maps.csv of the Python package parallax_data, from
// which CMake makes the rows here and those of the page's JavaScript. Constant; thread-safe.
//
// A row is a kind of file. A map, which render.maps names, has one row or several. To add a map:
// its rows; the pass that makes it (worker/render/passes); its check (worker/dataset/verify).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// One row. Fields are in the order of the table's columns.
struct FrameMap {
  enum Per { kEye, kDirection };  // A file for each eye, or for each direction and eye.
  enum Encoding {
    kRgb8,      // PNG, 8-bit sRGB.
    kGrey8,     // PNG, 8 bits.
    kIndex16,   // PNG, 16 bits.
    kFloatY,    // EXR, float32, channel Y.
    kFloatRgb,  // EXR, float32, R G B.
    kHalfRgb,   // EXR, half float, R G B.
  };
  static constexpr std::string_view kKeepHdr = "keep_hdr";

  std::string_view map;  // In render.maps. "": always written; kKeepHdr: render.keep_hdr.
  Per per;
  std::string_view file;  // "depth_{eye}.exr", "flow_{direction}_{eye}.exr".
  Encoding encoding;
  std::string_view unit;      // The unit of its values; "": none.
  std::string_view no_value;  // Written where there is no surface or no answer; "": never.
  // Separated by spaces: other maps that must be written, `lens` (a camera before rectification),
  // `sequence`.
  std::string_view needs;
  std::string_view pass;   // The renderer's pass that makes it.
  double bytes;            // A file's size for each pixel of the rectified picture, about.
  bool sparse;             // Not written where no pixel has a value.
  std::string_view view;   // How the page and sheets colour it; "": not shown there.
  std::string_view sheet;  // Title of its column in contact sheets; "": none.
  bool sample;             // Member of a sample of the export `webdataset`.

  // Returns the file's name without eye, direction and extension: "depth", "flow_occlusion".
  std::string_view stem() const;
  // Returns whether the file is an EXR; else it is a PNG.
  bool IsExr() const { return encoding >= kFloatY; }
  // Returns whether `render` asks for the map.
  bool IsIn(const v1::RenderConfig& render) const;
  // Returns the name of an eye's file; `way` is "forward" or "backward" for maps of directions.
  std::string FileOf(std::string_view eye, std::string_view way = {}) const;
  // Returns the names of all of its files, left before right.
  std::vector<std::string> Files() const;
};

// Returns all rows.
std::span<const FrameMap> FrameMaps();
// Returns the names that render.maps may have, in order of the table.
const std::vector<std::string>& FrameMapNames();
// Returns whether render.maps has `map`.
bool HasMap(const v1::RenderConfig& render, std::string_view map);
// Returns the row with that stem ("depth"), which must be there.
const FrameMap& FrameMapOf(std::string_view stem);
// Returns the name of an eye's file, "left" or "right", of the row with that stem.
std::string MapFile(std::string_view stem, std::string_view eye);

}  // namespace parallax
