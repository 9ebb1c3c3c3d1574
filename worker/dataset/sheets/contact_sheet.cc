#include "worker/dataset/sheets/contact_sheet.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "common/config/frame_maps.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_images.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/frame_statistics.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/dataset/sheets/histogram_page.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kSheetMargin = 28, kGap = 8, kHeader = 96, kLegendRows = 10, kLegendRow = 15;
constexpr int kLegendLines = 6;  // Without a list of objects or materials.
constexpr int kRowGap = 26;

double NumberAt(const Json& json, const char* a, const char* b = nullptr) {
  const Json* node = json.contains(a) ? &json[a] : nullptr;
  if (node != nullptr && b != nullptr) {
    node = node->is_object() && node->contains(b) ? &(*node)[b] : nullptr;
  }
  return node != nullptr && node->is_number() ? node->get<double>() : 0;
}

// Swatch and name of the indices with the most pixels, in two columns.
void DrawLegend(Canvas& canvas, int x, int y, int width, const ImageU16& indices,
                const Json& table) {
  std::vector<int64_t> counts(1 << 16);
  for (const uint16_t index : indices.values()) ++counts[index];
  std::vector<std::pair<int64_t, uint32_t>> order;
  for (uint32_t i = 1; i < counts.size(); ++i) {
    if (counts[i] > 0) order.emplace_back(-counts[i], i);
  }
  std::sort(order.begin(), order.end());
  const int column_width = width / 2;
  const size_t room = 2 * kLegendRows;
  for (size_t i = 0; i < std::min(order.size(), room); ++i) {
    const int cx = x + static_cast<int>(i) / kLegendRows * column_width;
    const int cy = y + static_cast<int>(i) % kLegendRows * kLegendRow;
    if (i + 1 == room && order.size() > room) {
      canvas.DrawText(cx + 15, cy + 9, fmt::format("{} more", order.size() - room + 1), 7.5,
                      kFaint);
      break;
    }
    const uint32_t index = order[i].second;
    const std::string key = std::to_string(index);
    const std::string name = table.contains(key) ? table[key].value("name", key) : key;
    canvas.FillBox(cx, cy, 10, 10, IndexColor(index));
    canvas.DrawText(cx + 15, cy + 9, FitText(name, 7.5, column_width - 20), 7.5);
  }
}

void DrawColorBar(Canvas& canvas, int x, int y, int width, double full_scale_px) {
  for (int i = 0; i < width; ++i) canvas.FillBox(x + i, y, 1, 10, Turbo(i / double(width - 1)));
  canvas.DrawText(x, y + 26, "0", 8, kFaint);
  // The scale goes by square roots.
  const std::string middle = fmt::format("{:.0f}", full_scale_px / 4);
  const std::string end = fmt::format("{:.0f} px", full_scale_px);
  canvas.DrawText(x + (width - Canvas::TextWidth(middle, 8)) / 2, y + 26, middle, 8, kFaint);
  canvas.DrawText(x + width - Canvas::TextWidth(end, 8), y + 26, end, 8, kFaint);
}

struct Row {
  std::string name;  // Path below the dataset's folder.
  std::string dir;
  FrameOnDisk frame;
  WarpDifference warp;
};

void DrawFacts(Canvas& canvas, int x, int y, int width, const Row& row) {
  const Json& json = row.frame.json;
  const std::string room = json.contains("room") && json["room"].is_string()
                               ? json["room"].get<std::string>()
                               : std::string();
  const std::string lines[] = {
      room,
      fmt::format("baseline {:.3f} m   focal {:.0f} px", NumberAt(json, "baseline_m"),
                  NumberAt(json, "intrinsics", "fx")),
      fmt::format("depth {:.2f} to {:.2f} m", NumberAt(json, "near_m"), NumberAt(json, "far_m")),
      fmt::format("disparity up to {:.0f} px", NumberAt(json, "statistics", "max_disparity_px")),
      fmt::format("mean intensity {:.0f}   occluded {:.1f} %",
                  NumberAt(json, "statistics", "mean_intensity"),
                  100 * NumberAt(json, "statistics", "occluded_fraction")),
  };
  canvas.DrawText(x, y + 10, FitText(row.name, 8.5, width), 8.5, kText, true);
  int line_y = y + 26;
  for (const std::string& line : lines) {
    if (line.empty()) continue;
    canvas.DrawText(x, line_y, FitText(line, 8, width), 8, kFaint);
    line_y += kLegendRow;
  }
}

void DrawWarp(Canvas& canvas, int x, int y, const WarpDifference& warp) {
  if (warp.median < 0) return;
  canvas.DrawText(x, y + 10, "right warped onto left,", 8, kFaint);
  canvas.DrawText(x, y + 26, "difference outside occlusions:", 8, kFaint);
  canvas.DrawText(x, y + 42,
                  fmt::format("median {:.2f}   mean {:.2f}   90 % {:.1f}  of 255", warp.median,
                              warp.mean, warp.p90),
                  8, kText);
}

// ---- Columns
// The inputs of one tile and its legend.
struct Cell {
  const Row& row;
  double full_scale_px;  // The disparity of the last colour.
  int x, y, width;       // Place of the legend.
};

struct Column {
  std::string title;
  std::string file;  // In a frame's folder; a column whose file no frame has is left out.
  const FrameMap* map = nullptr;  // Null: an eye's picture.
  // Indices: neighbouring pixels are not mixed.
  bool exact() const { return map && map->encoding == FrameMap::kIndex16; }
  int legend_lines() const { return exact() ? kLegendRows : kLegendLines; }
};

std::vector<Column> AllColumns() {
  std::vector<Column> columns = {{"left", "left.png"}, {"right", "right.png"}};
  for (const FrameMap& row : FrameMaps()) {
    if (!row.sheet.empty()) columns.push_back({std::string(row.sheet), row.FileOf("left"), &row});
  }
  return columns;
}

// Reads a column's map and draws its legend. Returns the tile; empty if the frame has no such file.
absl::StatusOr<ImageRgb8> DrawCell(Canvas& canvas, const Column& column, const Cell& cell) {
  const std::string& dir = cell.row.dir;
  const auto say = [&](int line, const char* text) {
    canvas.DrawText(cell.x, cell.y + 10 + 16 * line, text, 8, kFaint);
  };
  if (!column.map) {
    const bool is_left = column.file == "left.png";
    if (is_left) DrawFacts(canvas, cell.x, cell.y, cell.width, cell.row);
    if (!is_left) DrawWarp(canvas, cell.x, cell.y, cell.row.warp);
    return is_left ? cell.row.frame.left : cell.row.frame.right;
  }
  const FrameMap& map = *column.map;
  switch (map.encoding) {
    case FrameMap::kFloatY: {
      ImageF disparity;
      RETURN_IF_ERROR(ReadMapIfThere(dir, map.stem(), "left", &disparity));
      if (disparity.empty()) return ImageRgb8();
      DrawColorBar(canvas, cell.x, cell.y, cell.width, cell.full_scale_px);
      return ColorDisparity(disparity, cell.full_scale_px);
    }
    case FrameMap::kIndex16: {
      ImageU16 indices;
      RETURN_IF_ERROR(ReadMapIfThere(dir, map.stem(), "left", &indices));
      if (indices.empty()) return ImageRgb8();
      if (const auto table = cell.row.frame.json.find(std::string(map.view));
          table != cell.row.frame.json.end()) {
        DrawLegend(canvas, cell.x, cell.y, cell.width, indices, *table);
      }
      return ColorIndices(indices);
    }
    case FrameMap::kHalfRgb: {
      ImageF3 normals;
      RETURN_IF_ERROR(ReadMapIfThere(dir, map.stem(), "left", &normals));
      if (normals.empty()) return ImageRgb8();
      say(0, "camera's frame: red right, green up,");
      say(1, "blue towards the camera");
      return ColorNormals(normals);
    }
    default: {
      ImageU8 mask;
      RETURN_IF_ERROR(ReadMapIfThere(dir, map.stem(), "left", &mask));
      if (mask.empty()) return ImageRgb8();
      say(0, "white: hidden from or outside the right view");
      return ColorOcclusion(mask);
    }
  }
}

// The columns that at least one of the frames has a file for.
std::vector<Column> ColumnsOf(const std::vector<std::string>& frames) {
  std::vector<Column> columns;
  for (const Column& column : AllColumns()) {
    const bool found = std::any_of(frames.begin(), frames.end(), [&](const std::string& frame) {
      std::error_code error;
      return fs::exists(fs::path(frame) / column.file, error);
    });
    if (found) columns.push_back(column);
  }
  return columns;
}

absl::Status DrawRow(Canvas& canvas, const std::vector<Column>& columns, int y, int tile_width,
                     int tile_height, const Row& row) {
  const FrameOnDisk& frame = row.frame;
  // One close leg of a chair must not darken the rest.
  const double full_scale_px = ColorScale(frame.left_disparity_px, 100);
  int x = kSheetMargin;
  for (const Column& column : columns) {
    ASSIGN_OR_RETURN(
        const ImageRgb8 tile,
        DrawCell(canvas, column, {row, full_scale_px, x, y + tile_height + 10, tile_width}));
    canvas.FillBox(x, y, tile_width, tile_height, kPanel);
    if (tile.empty()) {
      canvas.DrawText(x + 12, y + tile_height / 2, "not written", 10, kFaint);
    } else {
      canvas.DrawImage(x, y, tile_width, tile_height, tile, column.exact());
    }
    x += tile_width + kGap;
  }
  return absl::OkStatus();
}

std::string TitleOf(const std::string& dir) {
  fs::path path = fs::absolute(dir).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  return path.filename();
}

std::string HistogramPath(const std::string& sheet) {
  const fs::path path(sheet);
  return path.parent_path() / (path.stem().string() + "_histograms.png");
}

double MedianOf(std::vector<double> values) {
  if (values.empty()) return -1;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> FindFrames(const std::string& dir) {
  std::error_code error;
  std::vector<std::string> frames;
  fs::recursive_directory_iterator it(dir, error), end;
  if (error) return ErrnoError(error.value(), "open " + dir);
  if (fs::exists(fs::path(dir) / "frame.json", error)) return std::vector<std::string>{dir};
  for (; it != end; it.increment(error)) {
    if (error) return ErrnoError(error.value(), "list " + dir);
    if (!it->is_directory(error) || it->is_symlink(error)) continue;
    const std::string name = it->path().filename();
    if (name[0] == '.') {  // A store's attempts, half-brought frames.
      it.disable_recursion_pending();
    } else if (fs::exists(it->path() / "frame.json", error)) {
      frames.push_back(it->path());
      it.disable_recursion_pending();
    }
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

absl::StatusOr<ContactSheetResult> MakeContactSheet(const std::string& dir,
                                                    const std::string& out_png,
                                                    const ContactSheetOptions& options) {
  ASSIGN_OR_RETURN(const std::vector<std::string> found, FindFrames(dir));
  if (found.empty()) {
    return NotFound("{}: no frame (a folder with frame.json) in it", dir);
  }
  ContactSheetResult result;
  result.frames_found = static_cast<int>(found.size());
  std::vector<std::string> chosen;
  for (const size_t i : Spread(found.size(), options.max_frames)) chosen.push_back(found[i]);

  // All rows have the height of the first frame's shape.
  ASSIGN_OR_RETURN(const FrameOnDisk first, ReadFrame(chosen[0]));
  const int tile_width = std::max(options.tile_width_px, 120);
  const int tile_height = TileHeight(tile_width, first.left.width(), first.left.height());
  const std::vector<Column> columns = ColumnsOf(chosen);
  int lines = 0;
  for (const Column& column : columns) lines = std::max(lines, column.legend_lines());
  const int row_height = tile_height + 10 + lines * kLegendRow + kRowGap;
  const auto count_of_columns = static_cast<int>(columns.size());
  Canvas canvas(2 * kSheetMargin + count_of_columns * (tile_width + kGap) - kGap,
                kHeader + static_cast<int>(chosen.size()) * row_height + kSheetMargin);
  canvas.DrawText(kSheetMargin, 46, TitleOf(dir), 19, kText, true);
  const std::string count = fmt::format("{} of {}{}", chosen.size(), found.size(),
                                        found.size() == 1 ? " pair" : " pairs");
  canvas.DrawText(canvas.image().width() - kSheetMargin - Canvas::TextWidth(count, 12), 46, count,
                  12, kFaint);
  for (int i = 0; i < count_of_columns; ++i) {
    canvas.DrawText(kSheetMargin + i * (tile_width + kGap), kHeader - 12,
                    columns[static_cast<size_t>(i)].title, 10.5, kAccent);
  }

  std::vector<double> medians;
  for (size_t i = 0; i < chosen.size(); ++i) {
    Row row;
    ASSIGN_OR_RETURN(row.frame, ReadFrame(chosen[i]));
    row.dir = chosen[i];
    row.name = fs::path(chosen[i]).lexically_relative(dir).string();
    if (!row.frame.left_disparity_px.empty() && !row.frame.left_occlusion.empty()) {
      row.warp = WarpCheck(row.frame.left, row.frame.right, row.frame.left_disparity_px,
                           row.frame.left_occlusion);
      if (row.warp.median >= 0) medians.push_back(row.warp.median);
    }
    RETURN_IF_ERROR(DrawRow(canvas, columns, kHeader + static_cast<int>(i) * row_height, tile_width,
                            tile_height, row));
  }
  result.frames = static_cast<int>(chosen.size());
  result.warp_median_difference = MedianOf(medians);
  result.sheet_png = out_png;
  result.histogram_png = HistogramPath(out_png);
  RETURN_IF_ERROR(WritePng(out_png, canvas.image(), 3));
  ASSIGN_OR_RETURN(const HistogramData data, SumHistograms(found));
  RETURN_IF_ERROR(WritePng(result.histogram_png, DrawHistogramPage(TitleOf(dir), data), 3));
  return result;
}

}  // namespace parallax
