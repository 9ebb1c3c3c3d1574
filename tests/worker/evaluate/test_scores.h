// Score files with wanted figures, for tests of files, tables and pictures.
#pragma once

#include <fmt/core.h>

#include <optional>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "worker/evaluate/scores.h"

namespace parallax {

inline std::string Message(const absl::Status& status) {
  return std::string(ToStd(status.message()));
}

// One image of 1,000 pixels for each entry of `bad_percent`, bad at every threshold in so many
// percent of them (to a tenth).
inline Evaluation SyntheticEvaluation(const std::string& benchmark, const std::string& variant,
                                      std::optional<int64_t> seed,
                                      const std::vector<double>& bad_percent,
                                      const std::string& trainer = "builtin") {
  Evaluation evaluation{.benchmark = benchmark,
                        .headline = {.measure = BadAt(2)},
                        .figures = {{.measure = kEpeMeasure}},
                        .mimics = "nobody",
                        .run = {.variant = variant, .trainer = trainer, .seed = seed},
                        .predictor = "made up"};
  for (size_t i = 0; i < bad_percent.size(); ++i) {
    Scores scores{.pair = fmt::format("p{}", i), .width_px = 50, .height_px = 20};
    ErrorTally& tally = scores.regions["all"];
    tally.pixels = 1000;
    tally.bad.fill(static_cast<int64_t>(10 * bad_percent[i] + 0.5));
    tally.abs_error_px = 100 * bad_percent[i];
    evaluation.images.push_back(std::move(scores));
  }
  return evaluation;
}

}  // namespace parallax
