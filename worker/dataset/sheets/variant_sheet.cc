#include "worker/dataset/sheets/variant_sheet.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <vector>

#include "common/config/config.h"
#include "common/image/io.h"
#include "worker/dataset/archive/archive_index.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr int kVariantsMargin = 24, kGap = 8, kTitle = 60, kLabel = 24, kBlockTitle = 34;

std::set<FrameId> CommonKeys(const Dataset& dataset) {
  std::map<FrameId, size_t> count;
  for (const DatasetVariant& variant : dataset.variants) {
    for (const DatasetFrame& frame : variant.frames) ++count[{frame.scene, frame.rig}];
  }
  std::set<FrameId> common;
  for (const auto& [key, variants] : count) {
    if (variants == dataset.variants.size()) common.insert(key);
  }
  return common;
}

// The variants in the order of the study's lock file; they lie on disk by name.
void SortAsInStudy(const std::string& dir, std::vector<DatasetVariant>& variants) {
  const absl::StatusOr<v1::StudySpec> study = LoadStudy(dir + "/study.lock.yaml");
  if (!study.ok()) return;
  const auto place = [&](const std::string& name) {
    int i = 0;
    while (i < study->variants_size() && study->variants(i).name() != name) ++i;
    return i;
  };
  std::stable_sort(variants.begin(), variants.end(),
                   [&](const auto& a, const auto& b) { return place(a.name) < place(b.name); });
}

// The scale that suits the variant with the largest disparities, so that other baselines show and
// no picture is of one colour. 0 without disparity maps.
absl::StatusOr<double> SharedScale(const Dataset& dataset, const FrameId& key) {
  double full_scale_px = 0;
  for (const DatasetVariant& variant : dataset.variants) {
    const std::string path = variant.dir + "/" + FramePath(key) + "/disparity_left.exr";
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    ASSIGN_OR_RETURN(const ImageF disparity_px, ReadExrY(path));
    full_scale_px = std::max(full_scale_px, ColorScale(disparity_px, 20));
  }
  return full_scale_px;
}

// Draws a line as large as fits, from `size_px` downwards.
void DrawFitted(Canvas& canvas, int y, const std::string& text, double size_px, const Rgb& color,
                bool bold) {
  constexpr double kLeastPx = 7;
  const int width = canvas.image().width() - 2 * kVariantsMargin;
  while (size_px > kLeastPx && Canvas::TextWidth(text, size_px) > width) size_px -= 0.5;
  canvas.DrawText(kVariantsMargin, y, FitText(text, size_px, width), size_px, color, bold);
}

}  // namespace

absl::StatusOr<VariantSheetResult> MakeVariantSheet(const std::string& dir,
                                                    const std::string& out_png,
                                                    const VariantSheetOptions& options) {
  ASSIGN_OR_RETURN(Dataset dataset, ReadDataset(dir));
  if (dataset.variants.size() < 2) {
    return FailedPrecondition("{}: has one variant, so there is nothing to compare", dir);
  }
  const std::set<FrameId> common = CommonKeys(dataset);
  if (common.empty()) {
    return FailedPrecondition("{}: no pair is common to all variants", dir);
  }
  SortAsInStudy(dataset.dir, dataset.variants);
  const std::vector<FrameId> all(common.begin(), common.end());
  const std::vector<size_t> blocks = Spread(all.size(), options.max_pairs);
  const int columns = std::clamp(options.columns, 1, static_cast<int>(dataset.variants.size()));
  const int rows = (static_cast<int>(dataset.variants.size()) + columns - 1) / columns;
  const int tile = std::max(options.tile_width_px, 80);

  VariantSheetResult result;
  result.sheet_png = out_png;
  result.pairs_common = static_cast<int>(all.size());
  for (const DatasetVariant& variant : dataset.variants) result.variants.push_back(variant.name);

  ASSIGN_OR_RETURN(const ImageRgb8 first,
                   ReadPngRgb8(dataset.variants[0].dir + "/" + FramePath(all[0]) + "/left.png"));
  const int tile_height = TileHeight(tile, first.width(), first.height());
  const int block_height = kBlockTitle + rows * (tile_height + kLabel + kGap);
  Canvas canvas(2 * kVariantsMargin + columns * tile + (columns - 1) * kGap,
                kTitle + static_cast<int>(blocks.size()) * block_height + kVariantsMargin);
  const std::string name = std::filesystem::path(dataset.dir).filename();
  DrawFitted(canvas, 32, name + ": the same pair in each of its variants", 15, kText, true);
  DrawFitted(canvas, 52, "left images; disparities of a pair to one scale", 10, kFaint, false);
  for (size_t b = 0; b < blocks.size(); ++b) {
    const FrameId key = all[blocks[b]];
    const int top = kTitle + static_cast<int>(b) * block_height;
    canvas.DrawText(kVariantsMargin, top + 20,
                    fmt::format("scene {}, rig {}", key.first, key.second), 11, kFaint);
    ASSIGN_OR_RETURN(const double full_scale_px, SharedScale(dataset, key));
    result.full_scale_px.push_back(full_scale_px);
    for (size_t v = 0; v < dataset.variants.size(); ++v) {
      const DatasetVariant& variant = dataset.variants[v];
      const int x = kVariantsMargin + static_cast<int>(v) % columns * (tile + kGap);
      const int y =
          top + kBlockTitle + static_cast<int>(v) / columns * (tile_height + kLabel + kGap);
      ASSIGN_OR_RETURN(const FrameOnDisk frame, ReadFrame(variant.dir + "/" + FramePath(key)));
      canvas.DrawImage(x, y, tile, tile_height, frame.left);
      if (full_scale_px > 0 && !frame.left_disparity_px.empty()) {
        const int width = tile / 3, height = tile_height / 3;
        const int right = x + tile - width, bottom = y + tile_height - height;
        canvas.FillBox(right - 2, bottom - 2, width + 2, height + 2, kGround);
        canvas.DrawImage(right, bottom, width, height,
                         ColorDisparity(frame.left_disparity_px, full_scale_px), true);
      }
      canvas.DrawText(x, y + tile_height + 16, FitText(variant.name, 11, tile), 11, kAccent);
    }
    ++result.pairs;
  }
  RETURN_IF_ERROR(WritePng(out_png, canvas.image(), 3));
  return result;
}

}  // namespace parallax
