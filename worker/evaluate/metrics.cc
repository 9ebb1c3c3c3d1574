#include "worker/evaluate/metrics.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace parallax {
namespace {

std::string ThresholdText(double threshold_px) { return fmt::format("{:g}", threshold_px); }

absl::StatusOr<Measure> ParseMeasure(std::string_view name) {
  if (name == "d1") return Measure{.kind = Measure::Kind::kD1};
  if (name == "epe") return Measure{.kind = Measure::Kind::kEpe};
  if (name == "rmse") return Measure{.kind = Measure::Kind::kRmse};
  if (name == "log") return kLogMeasure;
  std::string known = "d1, epe, rmse, log";
  for (size_t i = 0; i < kThresholdsPx.size(); ++i) {
    const Measure bad{.threshold = i};
    if (MeasureName(bad) == name) return bad;
    known += ", " + MeasureName(bad);
  }
  return InvalidArgument("there is no metric '{}'; there are {}", name, known);
}

// The sum over pixels of the octaves of error between the first threshold and the last.
double OctavesBeyond(const ErrorTally& tally) {
  double sum = 0;
  for (size_t i = 1; i < kThresholdsPx.size(); ++i) {
    const double octaves = std::log2(kThresholdsPx[i] / kThresholdsPx[i - 1]);
    sum += octaves * static_cast<double>(tally.bad[i - 1] + tally.bad[i]) / 2;
  }
  return sum;
}

}  // namespace

void ErrorTally::Add(float predicted_px, float truth_px, int width_px) {
  ++pixels;
  const bool finite = std::isfinite(predicted_px);
  const bool valid = finite && predicted_px >= 0;
  const float worst = std::max(truth_px, static_cast<float>(width_px) - truth_px);
  const float error = finite ? std::abs(predicted_px - truth_px) : worst;
  if (!valid) ++invalid;
  abs_error_px += double{error};
  squared_error_px2 += double{error} * double{error};
  for (size_t i = 0; i < kThresholdsPx.size(); ++i) {
    if (!valid || double{error} > kThresholdsPx[i]) ++bad[i];
  }
  if (!valid || (error > 3.0f && error > 0.05f * truth_px)) ++d1;
}

ErrorTally& ErrorTally::operator+=(const ErrorTally& other) {
  pixels += other.pixels;
  invalid += other.invalid;
  abs_error_px += other.abs_error_px;
  squared_error_px2 += other.squared_error_px2;
  for (size_t i = 0; i < bad.size(); ++i) bad[i] += other.bad[i];
  d1 += other.d1;
  return *this;
}

Measure BadAt(double threshold_px) {
  const auto found = std::find(kThresholdsPx.begin(), kThresholdsPx.end(), threshold_px);
  if (found == kThresholdsPx.end()) std::abort();
  return {.threshold = static_cast<size_t>(found - kThresholdsPx.begin())};
}

std::string MeasureName(const Measure& measure) {
  switch (measure.kind) {
    case Measure::Kind::kBad:
      return "bad-" + ThresholdText(kThresholdsPx[measure.threshold]);
    case Measure::Kind::kD1:
      return "d1";
    case Measure::Kind::kEpe:
      return "epe";
    case Measure::Kind::kRmse:
      return "rmse";
    case Measure::Kind::kLog:
      return "log";
  }
  return "";
}

std::string MetricName(const Metric& metric) {
  return MeasureName(metric.measure) + " " + metric.region + (metric.pooled ? " pooled" : "");
}

absl::StatusOr<Metric> ParseMetric(std::string_view name) {
  std::istringstream words{std::string(name)};
  std::string measure, region = "all", pooled;
  words >> measure >> region >> pooled;
  Metric metric{.region = region};
  ASSIGN_OR_RETURN(metric.measure, ParseMeasure(measure));
  if (!pooled.empty() && pooled != "pooled") {
    return InvalidArgument("metric '{}': wanted MEASURE [REGION [pooled]]", name);
  }
  metric.pooled = !pooled.empty();
  return metric;
}

Quotient QuotientOf(const Measure& measure, const ErrorTally& tally) {
  const auto pixels = static_cast<double>(tally.pixels);
  switch (measure.kind) {
    case Measure::Kind::kBad:
      return {100.0 * static_cast<double>(tally.bad[measure.threshold]), pixels};
    case Measure::Kind::kD1:
      return {100.0 * static_cast<double>(tally.d1), pixels};
    case Measure::Kind::kEpe:
      return {tally.abs_error_px, pixels};
    case Measure::Kind::kRmse:
      return {tally.squared_error_px2, pixels};
    case Measure::Kind::kLog:
      return {OctavesBeyond(tally), pixels};
  }
  return {};
}

double FigureOf(const Measure& measure, const ErrorTally& tally) {
  if (tally.pixels == 0) return std::numeric_limits<double>::quiet_NaN();
  const Quotient quotient = QuotientOf(measure, tally);
  const double value = quotient.numerator / quotient.denominator;
  return measure.kind == Measure::Kind::kRmse ? std::sqrt(value) : value;
}

ErrorTally TallyErrors(const ImageF& predicted_px, const ImageF& truth_px, const ImageU8& region) {
  ErrorTally tally;
  for (size_t i = 0; i < truth_px.pixels(); ++i) {
    if (!(truth_px.values()[i] > 0) || (!region.empty() && region.values()[i] == 0)) continue;
    tally.Add(predicted_px.values()[i], truth_px.values()[i], truth_px.width());
  }
  return tally;
}

}  // namespace parallax
