// Predictions beside the truth and the error, for the pairs that went best and worst.
#pragma once

#include <string>

#include "common/base/status.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/scores.h"

namespace parallax {

struct PredictionSheetOptions {
  int best = 3, worst = 5;  // Rows; fewer where there are fewer pairs.
  int tile_width_px = 360;  // Width of one picture; a row has four.
};

// Draws rows of left picture, truth, prediction (coloured to one scale) and error (dark: none,
// bright: 5 px and more; wrong without a value: magenta), worst pair first by the headline.
// Predictions are read from PredictionPath(`work_dir`, pair), so the evaluation must have kept
// them. Errors: kNotFound for a prediction or a pair of the scores that is gone; reading as
// ReadTruth, writing as WritePng.
absl::Status DrawPredictionSheet(const Benchmark& benchmark, const Evaluation& evaluation,
                                 const std::string& work_dir, const std::string& out_png,
                                 const PredictionSheetOptions& options = {});

// Returns the error map's colours. Pixels without truth are dark grey.
ImageRgb8 ColorError(const ImageF& predicted_px, const ImageF& truth_px);
// Returns a prediction as Turbo colours of the square root of the disparity; values that are
// negative or not finite are magenta.
ImageRgb8 ColorPrediction(const ImageF& predicted_px, double full_scale_px);

}  // namespace parallax
