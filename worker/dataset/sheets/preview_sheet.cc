#include "worker/dataset/sheets/preview_sheet.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr int kMargin = 24, kColumnGap = 10, kFactsWidth = 250, kTop = 110, kBetweenRows = 18;
constexpr int kFactsLine = 17, kLeastRow = 9 * kFactsLine, kScaleHeight = 30;
constexpr int kLinesInRaw = 7;
constexpr double kOutside = 0.002;  // Share of disparities beyond each end of the colours.
constexpr Rgb kBeyond = {255, 255, 255}, kBelow = {120, 120, 120};

// Shares that make a study's author think again.
constexpr double kManyBelow = 0.05, kManyBeyond = 0.05;

std::string PercentText(double share) {
  return share > 0 && share < 0.0005 ? "< 0.1 %" : fmt::format("{:.1f} %", 100 * share);
}

std::string PxText(double px) { return fmt::format("{:.{}f}", px, px < 10 ? 1 : 0); }

int ColumnX(int column) {
  return kMargin + kFactsWidth + kColumnGap + column * (kPreviewWidth_px + kColumnGap);
}

// The raw pair is drawn below the rectified one.
int RawY(const PreviewPair& pair) {
  return std::max(pair.left.height() + kScaleHeight, kLeastRow) + kColumnGap;
}

int RowHeight(const PreviewRow& row) {
  if (!row.pair) return 3 * kFactsLine;
  const PreviewPair& pair = *row.pair;
  if (pair.raw_left.empty()) return RawY(pair) - kColumnGap;
  return RawY(pair) + std::max(pair.raw_left.height(), pair.raw_right.height());
}

struct FactsText {
  std::string text;
  Rgb color = kText;
};

void DrawFacts(Canvas& canvas, int x, int y, const std::vector<FactsText>& lines) {
  for (const FactsText& line : lines) {
    y += kFactsLine;
    canvas.DrawText(x, y, FitText(line.text, 8, kFactsWidth), 8, line.color);
  }
}

void DrawFigures(Canvas& canvas, int x, int y, const PreviewRow& row) {
  const v1::Rig& rig = row.pair->rig;
  const DisparityFigures& figures = row.pair->disparities;
  std::vector<FactsText> lines = {
      {fmt::format("{} x {} px, focal {:.0f} px", rig.width_px(), rig.height_px(), rig.fx_px()),
       kFaint},
      {fmt::format("baseline {:.3f} m", rig.baseline_m()), kFaint},
      {fmt::format("disparity {} to {} px", PxText(figures.min_px), PxText(figures.max_px))},
      {fmt::format("mean {} px, median {} px", PxText(figures.mean_px), PxText(figures.median_px))},
      {"below 1 px: " + PercentText(figures.share_below_1px),
       figures.share_below_1px > kManyBelow ? kWarn : kText},
      {"beyond 192 px: " + PercentText(figures.share_beyond_192px),
       figures.share_beyond_192px > kManyBeyond ? kWarn : kText},
      {"no surface: " + PercentText(figures.share_no_surface), kFaint}};
  if (!row.note.empty()) lines.push_back({row.note, kFaint});
  DrawFacts(canvas, x, y, lines);
}

void DrawRowFigures(Canvas& canvas, int x, int y, const RowFigures& rows) {
  DrawFacts(canvas, x, y,
            {{"before rectification", kFaint},
             {"lines: rows of the rectified pair", kFaint},
             {"rows of a point differ by"},
             {fmt::format("{:.1f} px, at most {:.1f} px", rows.raw_mean_px, rows.raw_max_px)},
             {fmt::format("rectified: at most {:.2f} px", rows.rectified_max_px)}});
}

// Where a disparity lies on the scale of colours, which goes by square roots: 0 to 1.
double PlaceOnScale(const DisparityScale& scale, double px) {
  const double low = std::sqrt(scale.low_px), high = std::sqrt(scale.high_px);
  return high > low ? (std::sqrt(px) - low) / (high - low) : 1;
}

// The colours of a disparity that is not 0, with the limits of training marked.
Rgb ColorOf(const DisparityScale& scale, double px) {
  if (px < kLeastUsefulDisparity_px) return kBelow;
  if (px > kMostTrainedDisparity_px) return kBeyond;
  return Turbo(PlaceOnScale(scale, px));
}

ImageRgb8 ColorLimits(const ImageF& disparity_px, const DisparityScale& scale) {
  return Colored(disparity_px, [&](const float* disparity) {
    return *disparity > 0 ? ColorOf(scale, *disparity) : Rgb{};
  });
}

void DrawScale(Canvas& canvas, int x, int y, int width, const DisparityScale& scale) {
  const auto at = [&](double place) {
    const double low = std::sqrt(scale.low_px), high = std::sqrt(scale.high_px);
    return std::pow(low + place * (high - low), 2);
  };
  for (int i = 0; i < width; ++i) {
    canvas.FillBox(x + i, y, 1, 8, ColorOf(scale, at(i / double(std::max(width - 1, 1)))));
  }
  const std::string middle = PxText(at(0.5)), end = PxText(scale.high_px) + " px";
  canvas.DrawText(x, y + 21, PxText(scale.low_px), 8, kFaint);
  canvas.DrawText(x + (width - Canvas::TextWidth(middle, 8)) / 2, y + 21, middle, 8, kFaint);
  canvas.DrawText(x + width - Canvas::TextWidth(end, 8), y + 21, end, 8, kFaint);
}

// Draws the raw picture of an eye with rows of the rectified pair.
void DrawRaw(Canvas& canvas, int x, int y, const PreviewPair& pair, int eye) {
  const ImageRgb8& picture = eye == 0 ? pair.raw_left : pair.raw_right;
  const v1::RawCamera& camera = eye == 0 ? pair.rig.raw_left() : pair.rig.raw_right();
  canvas.DrawImage(x, y, picture.width(), picture.height(), picture);
  const double scale = static_cast<double>(picture.width()) / camera.width_px();
  for (int line = 0; line < kLinesInRaw; ++line) {
    const double row_px = pair.rig.height_px() * (line + 0.5) / kLinesInRaw;
    for (const Vec2d& point : RowInRaw(pair.rig, eye, row_px)) {
      const int px = static_cast<int>(std::floor(scale * point.x()));
      const int py = static_cast<int>(std::floor(scale * point.y()));
      if (px < 0 || py < 0 || px >= picture.width() || py >= picture.height()) continue;
      canvas.FillBox(x + px, y + py, 1, 1, IndexColor(static_cast<uint32_t>(line) + 1));
    }
  }
}

void DrawPreviewRow(Canvas& canvas, int y, const PreviewRow& row, const DisparityScale& scale) {
  canvas.DrawText(kMargin, y + 10, FitText(row.name, 10, kFactsWidth), 10, kAccent, true);
  if (!row.pair) {
    const int width = canvas.image().width() - 2 * kMargin;
    canvas.DrawText(kMargin, y + 10 + kFactsLine, FitText(row.note, 8, width), 8, kWarn);
    return;
  }
  const PreviewPair& pair = *row.pair;
  DrawFigures(canvas, kMargin, y + 10, row);
  const int width = pair.left.width(), height = pair.left.height();
  canvas.DrawImage(ColumnX(0), y, width, height, pair.left);
  canvas.DrawImage(ColumnX(1), y, width, height, pair.right);
  canvas.DrawImage(ColumnX(2), y, width, height, ColorLimits(pair.disparity_px, scale),
                   /*exact=*/true);
  DrawScale(canvas, ColumnX(2), y + height + 6, width, scale);
  if (pair.raw_left.empty()) return;
  const int raw_y = y + RawY(pair);
  DrawRowFigures(canvas, kMargin, raw_y - 7, pair.rows);
  DrawRaw(canvas, ColumnX(0), raw_y, pair, 0);
  DrawRaw(canvas, ColumnX(1), raw_y, pair, 1);
}

}  // namespace

DisparityScale ScaleOf(const std::vector<PreviewRow>& rows) {
  std::vector<float> seen;
  for (const PreviewRow& row : rows) {
    if (!row.pair) continue;
    for (const float value : row.pair->disparity_px.values()) {
      if (value >= kLeastUsefulDisparity_px && value <= kMostTrainedDisparity_px) {
        seen.push_back(value);
      }
    }
  }
  if (seen.empty()) return {};
  const auto rank = [&](double share) {
    const auto place =
        seen.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(seen.size() - 1));
    std::nth_element(seen.begin(), place, seen.end());
    return static_cast<double>(*place);
  };
  return {rank(kOutside), rank(1 - kOutside)};
}

ImageRgb8 DrawPreviewSheet(const PreviewText& text, const std::vector<PreviewRow>& rows) {
  int height = kTop + (text.last_line.empty() ? 0 : kFactsLine) + kMargin;
  for (const PreviewRow& row : rows) height += RowHeight(row) + kBetweenRows;
  Canvas canvas(ColumnX(3) - kColumnGap + kMargin, height);
  const int width = canvas.image().width() - 2 * kMargin;
  canvas.DrawText(kMargin, 34, FitText(text.title, 14, width), 14, kText, true);
  canvas.DrawText(kMargin, 56, FitText(text.below_title, 8.5, width), 8.5, kFaint);
  canvas.DrawText(kMargin, 74,
                  "disparities: one scale of colours; white: beyond 192 px, which trainers leave "
                  "out; grey: below 1 px; black: no surface",
                  8.5, kFaint);
  constexpr const char* kTitles[] = {"left", "right", "disparity"};
  for (int i = 0; i < 3; ++i) {
    canvas.DrawText(ColumnX(i), kTop - 10, kTitles[i], 9, kText, true);
  }
  const DisparityScale scale = ScaleOf(rows);
  int y = kTop;
  for (const PreviewRow& row : rows) {
    DrawPreviewRow(canvas, y, row, scale);
    y += RowHeight(row) + kBetweenRows;
  }
  canvas.DrawText(kMargin, y + 6, FitText(text.last_line, 8.5, width), 8.5, kFaint);
  return canvas.image();
}

}  // namespace parallax
