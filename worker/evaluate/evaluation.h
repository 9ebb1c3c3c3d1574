// Evaluates one predictor on one benchmark.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/evaluate/scores.h"

namespace parallax {

struct EvaluateOptions {
  RunIdentity run;       // Identity of the predictions' network.
  std::string work_dir;  // Made if missing: lists, logs, reduced pictures, predictions.
  // Leaves the predictions in PredictionPath(); they take 4 bytes a pixel.
  bool keep_predictions = false;
  int max_pairs = 0;  // Limit, spread evenly over the benchmark's pairs; 0: all.
  CancelToken cancel;
  Clock* clock = &Clock::System();
  // Called with what is odd about a pair that is scored nevertheless, one line; see PreparePair.
  std::function<void(const std::string&)> note = [](const std::string&) {};
  // Told the number of pairs that a stage is done with: "shrink" or "check", "predict", "score".
  std::function<void(std::string_view stage, int done, int total)> progress = [](std::string_view,
                                                                                 int, int) {};
};

// Predicts all pairs, then scores each against its truth. Nothing is scored unless every pair has a
// prediction of the right size.
//
// Errors: as the predictor's; kNotFound naming the first pair without a prediction;
// kInvalidArgument for a prediction of another size than its picture, and for pictures and truth
// that don't fit; as PreparePair; kDataLoss for a map of truth in which nothing is known;
// kCancelled in each stage; reading as ReadTruth.
absl::StatusOr<Evaluation> Evaluate(Predictor& predictor, const Benchmark& benchmark,
                                    const EvaluateOptions& options);

// Returns the path of a pair's prediction during an evaluation, and with keep_predictions after it.
std::string PredictionPath(const std::string& work_dir, const std::string& pair);

// Errors of one image. Errors: kInvalidArgument for a prediction of another size than the truth.
absl::StatusOr<Scores> ScorePair(const std::string& pair, const ImageF& predicted_px,
                                 const PairTruth& truth);

// Returns the benchmark with `max_pairs` of its pairs, spread evenly over them; unchanged for 0.
Benchmark Thinned(Benchmark benchmark, int max_pairs);

}  // namespace parallax
