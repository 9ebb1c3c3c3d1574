#include "common/base/rate_estimator.h"

namespace parallax {

void RateEstimator::Add(double time_s, double count) {
  if (!samples_.empty() && count < samples_.back().count) samples_.clear();
  if (!samples_.empty() && time_s <= samples_.back().time_s) samples_.pop_back();
  samples_.push_back({time_s, count});
  // One sample at or before the window's start stays, so that the window is always covered.
  while (samples_.size() > 2 && samples_[1].time_s <= time_s - window_s_) samples_.pop_front();
}

std::optional<double> RateEstimator::PerSecond() const {
  if (samples_.size() < 2) return std::nullopt;
  const Sample& first = samples_.front();
  const Sample& last = samples_.back();
  if (last.count <= first.count || last.time_s <= first.time_s) return std::nullopt;
  return (last.count - first.count) / (last.time_s - first.time_s);
}

std::optional<double> RateEstimator::SecondsFor(double remaining) const {
  if (remaining <= 0) return 0;
  const std::optional<double> rate = PerSecond();
  if (!rate) return std::nullopt;
  return remaining / *rate;
}

}  // namespace parallax
