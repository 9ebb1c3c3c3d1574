#include "worker/evaluate/prediction_sheet.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/image/io.h"
#include "common/image/picture_pair.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/evaluate/evaluation.h"

namespace parallax {
namespace {

constexpr int kPredictionsMargin = 24, kGap = 8, kTitle = 78, kLabel = 30;
constexpr float kFullError_px = 5;
constexpr Rgb kUnknown = {40, 42, 48};
constexpr Rgb kWrong = {255, 0, 255};

double HeadlineOf(const Evaluation& evaluation, const Scores& scores) {
  const auto region = scores.regions.find(evaluation.headline.region);
  return region == scores.regions.end() || region->second.pixels == 0
             ? 0
             : FigureOf(evaluation.headline.measure, region->second);
}

// Worst first: the worst, then the best.
std::vector<const Scores*> ChooseRows(const Evaluation& evaluation,
                                      const PredictionSheetOptions& options) {
  std::vector<const Scores*> rows;
  for (const Scores& scores : evaluation.images) rows.push_back(&scores);
  std::stable_sort(rows.begin(), rows.end(), [&](const Scores* a, const Scores* b) {
    return HeadlineOf(evaluation, *a) > HeadlineOf(evaluation, *b);
  });
  const size_t worst = static_cast<size_t>(std::max(options.worst, 0));
  const size_t best = static_cast<size_t>(std::max(options.best, 0));
  if (rows.size() > worst + best) {
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(worst),
               rows.end() - static_cast<std::ptrdiff_t>(best));
  }
  return rows;
}

struct SheetRow {
  const Scores* scores = nullptr;
  ImageRgb8 left;
  ImageF truth_px, predicted_px;
};

absl::StatusOr<SheetRow> ReadRow(const Benchmark& benchmark, const Scores& scores,
                                 const std::string& work_dir) {
  const auto pair = std::find_if(benchmark.pairs.begin(), benchmark.pairs.end(),
                                 [&](const BenchmarkPair& one) { return one.name == scores.pair; });
  if (pair == benchmark.pairs.end()) {
    return NotFound("{}: has no pair {}", benchmark.name, scores.pair);
  }
  SheetRow row{.scores = &scores};
  ASSIGN_OR_RETURN(PicturePair pictures, ReadPicturePair(pair->left, pair->right));
  row.left = std::move(pictures.left);
  ASSIGN_OR_RETURN(PairTruth truth, pair->read_truth());
  row.truth_px = std::move(truth.disparity_px);
  ASSIGN_OR_RETURN(row.predicted_px, ReadPfm(PredictionPath(work_dir, scores.pair)));
  return row;
}

std::string Caption(const Evaluation& evaluation, const Scores& scores) {
  return fmt::format("{}: {} {:.2f}, epe {:.2f} px", scores.pair, MetricName(evaluation.headline),
                     HeadlineOf(evaluation, scores),
                     FigureOf(kEpeMeasure, scores.regions.at("all")));
}

}  // namespace

ImageRgb8 ColorPrediction(const ImageF& predicted_px, double full_scale_px) {
  return Colored(predicted_px, [&](const float* value) {
    if (!std::isfinite(*value) || *value < 0) return kWrong;
    return *value > 0 ? Turbo(std::sqrt(*value / std::max(full_scale_px, 1e-6))) : Rgb{};
  });
}

ImageRgb8 ColorError(const ImageF& predicted_px, const ImageF& truth_px) {
  return Colored(truth_px, [&](const float* truth) {
    const float predicted = predicted_px.data()[truth - truth_px.data()];
    if (!(*truth > 0)) return kUnknown;
    if (!std::isfinite(predicted) || predicted < 0) return kWrong;
    return Turbo(std::abs(predicted - *truth) / kFullError_px);
  });
}

absl::Status DrawPredictionSheet(const Benchmark& benchmark, const Evaluation& evaluation,
                                 const std::string& work_dir, const std::string& out_png,
                                 const PredictionSheetOptions& options) {
  const std::vector<const Scores*> chosen = ChooseRows(evaluation, options);
  const int tile = options.tile_width_px;
  const auto height_of = [&](const Scores& scores) {
    return TileHeight(tile, scores.width_px, scores.height_px);
  };
  int height = kTitle + kPredictionsMargin;
  for (const Scores* scores : chosen) height += height_of(*scores) + kLabel + kGap;
  Canvas canvas(2 * kPredictionsMargin + 4 * tile + 3 * kGap, height);
  canvas.DrawText(kPredictionsMargin, 36,
                  FitText(evaluation.run.variant + " on " + evaluation.benchmark + ", " +
                              MetricName(evaluation.headline),
                          15, canvas.image().width() - 2 * kPredictionsMargin),
                  15, kText, true);
  const char* headings[] = {"left", "truth", "prediction", "error: blue 0, red 5 px and more"};
  for (int c = 0; c < 4; ++c) {
    canvas.DrawText(kPredictionsMargin + c * (tile + kGap), kTitle - 12, headings[c], 10, kFaint);
  }
  int y = kTitle;
  for (const Scores* scores : chosen) {
    ASSIGN_OR_RETURN(const SheetRow row, ReadRow(benchmark, *scores, work_dir));
    const int tile_height = height_of(*scores);
    const double scale_px = ColorScale(row.truth_px);
    const ImageRgb8 tiles[] = {row.left, ColorDisparity(row.truth_px, scale_px),
                               ColorPrediction(row.predicted_px, scale_px),
                               ColorError(row.predicted_px, row.truth_px)};
    for (int c = 0; c < 4; ++c) {
      canvas.DrawImage(kPredictionsMargin + c * (tile + kGap), y, tile, tile_height, tiles[c],
                       c > 0);
    }
    canvas.DrawText(kPredictionsMargin, y + tile_height + 18,
                    FitText(Caption(evaluation, *scores), 10, 4 * tile), 10, kAccent);
    y += tile_height + kLabel + kGap;
  }
  return WritePng(out_png, canvas.image(), 3);
}

}  // namespace parallax
