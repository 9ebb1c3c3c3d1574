// Errors of a predicted disparity map against the truth, counted so that both a mean over images
// and a pool of all pixels can be formed afterwards.
//
// Rules that hold for every benchmark: error = |predicted - truth| in float32, as the evaluation
// scripts of the networks compute it; all thresholds are strict (error > t). A prediction that is
// not finite, or negative, is wrong: it is bad at every threshold. A negative one keeps its error;
// one that is not finite counts with the largest error that a disparity in [0, image width] can
// have there, so that leaving pixels out never gives a better figure than predicting them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// Thresholds in pixels at which bad pixels are counted.
inline constexpr std::array<double, 8> kThresholdsPx = {0.5, 1, 2, 3, 4, 5, 6, 8};

// Counts and sums over the pixels of one region of one or more images.
struct ErrorTally {
  int64_t pixels = 0;                               // With truth.
  int64_t invalid = 0;                              // Predictions that are negative or not finite.
  double abs_error_px = 0;                          // Sum of errors.
  double squared_error_px2 = 0;                     // Sum of their squares.
  std::array<int64_t, kThresholdsPx.size()> bad{};  // Pixels with error > kThresholdsPx[i].
  int64_t d1 = 0;  // Pixels with error > 3 px and > 5 % of the truth.   Source: KITTI 2015 devkit.

  // Counts one pixel whose true disparity is `truth_px` > 0, in an image `width_px` wide.
  void Add(float predicted_px, float truth_px, int width_px);
  ErrorTally& operator+=(const ErrorTally& other);
  bool operator==(const ErrorTally&) const = default;
};

// A kind of figure of a tally; lower is better: "bad-2" (percent), "d1" (percent), "epe" (pixels),
// "rmse" (pixels) or "log" (octaves): the mean of log2(error / 0.5 px), errors held between 0.5 and
// 8 px. It is the area under bad-t over log2 t, by the trapezoids between kThresholdsPx, so all
// sizes of error count where bad-2 knows two.
struct Measure {
  enum class Kind { kBad, kD1, kEpe, kRmse, kLog };
  Kind kind = Kind::kBad;
  size_t threshold = 2;  // Index into kThresholdsPx, for kBad.

  bool operator==(const Measure&) const = default;
};

// Returns the share of bad pixels at one of kThresholdsPx (compared exactly; anything else ends the
// process).
Measure BadAt(double threshold_px);
inline constexpr Measure kD1Measure = {.kind = Measure::Kind::kD1};
inline constexpr Measure kEpeMeasure = {.kind = Measure::Kind::kEpe};
inline constexpr Measure kLogMeasure = {.kind = Measure::Kind::kLog};

// A measure, the region where it is taken, and how images are combined.
struct Metric {
  Measure measure;
  std::string region = "all";  // "all": every pixel with truth; "nocc": those visible to both eyes.
  bool pooled = false;         // All pixels of all images together; else the mean over images.

  bool operator==(const Metric&) const = default;
};

// Returns the name of a measure: "bad-2", "bad-0.5", "d1", "epe", "rmse", "log".
std::string MeasureName(const Measure& measure);
// Returns the name of a metric: "bad-2 nocc", "d1 all pooled".
std::string MetricName(const Metric& metric);
// Parses a name that MetricName returns. Errors: kInvalidArgument listing the known names.
absl::StatusOr<Metric> ParseMetric(std::string_view name);

// The figure as numerator / denominator, so that pooling adds both. For kRmse the quotient is the
// mean square; `FigureOf` takes its root.
struct Quotient {
  double numerator = 0;
  double denominator = 0;
};
Quotient QuotientOf(const Measure& measure, const ErrorTally& tally);

// Returns the figure of a tally, in percent or pixels; NaN for a tally without pixels.
double FigureOf(const Measure& measure, const ErrorTally& tally);

// Counts the pixels where `truth_px` > 0 and `region` (if not empty) is not 0. All images have the
// same size.
ErrorTally TallyErrors(const ImageF& predicted_px, const ImageF& truth_px, const ImageU8& region);

}  // namespace parallax
