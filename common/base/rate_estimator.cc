#include "common/base/rate_estimator.h"

#include <algorithm>

namespace parallax {
namespace {

constexpr int kLeastSteps = 3;
constexpr double kLongestWindow = 4;  // In windows.
constexpr double kLeastSpan_s = 10;
constexpr double kLeastSpanOfOneStep_s = 30;

}  // namespace

RateEstimator::Growth RateEstimator::GrowthSince(size_t first) const {
  Growth growth;
  for (size_t i = first + 1; i < samples_.size(); ++i) {
    const double step = samples_[i].count - samples_[i - 1].count;
    if (step <= 0) continue;
    growth.sum += step;
    growth.largest = std::max(growth.largest, step);
    ++growth.steps;
  }
  return growth;
}

void RateEstimator::Add(double time_s, double count) {
  if (!samples_.empty() && count < samples_.back().count) samples_.clear();
  if (!samples_.empty() && time_s <= samples_.back().time_s) samples_.pop_back();
  // The first and the last of the samples with one count suffice.
  const size_t n = samples_.size();
  if (n >= 2 && samples_[n - 1].count == count && samples_[n - 2].count == count) {
    samples_.pop_back();
  }
  samples_.push_back({time_s, count});
  // One sample at or before the window's start stays, so that the window is always covered.
  while (samples_.size() > 2 && samples_[1].time_s <= time_s - window_s_ &&
         (samples_[1].time_s <= time_s - kLongestWindow * window_s_ ||
          GrowthSince(1).steps >= kLeastSteps)) {
    samples_.pop_front();
  }
}

std::optional<double> RateEstimator::PerSecond() const {
  if (samples_.size() < 2) return std::nullopt;
  Growth growth = GrowthSince(0);
  const double span_s = samples_.back().time_s - samples_.front().time_s;
  if (growth.sum <= 0 || span_s < kLeastSpan_s) return std::nullopt;
  if (growth.largest > growth.sum / 2) {
    if (growth.steps >= kLeastSteps) {
      growth.sum -= growth.largest;
    } else if (span_s < kLeastSpanOfOneStep_s) {
      return std::nullopt;
    }
  }
  return growth.sum / span_s;
}

std::optional<double> RateEstimator::SecondsFor(double remaining) const {
  if (remaining <= 0) return 0;
  const std::optional<double> rate = PerSecond();
  if (!rate) return std::nullopt;
  return remaining / *rate;
}

}  // namespace parallax
