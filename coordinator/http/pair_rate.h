// Pairs published per hour over a sliding window.
#pragma once

#include <deque>

#include "common/base/clock.h"

namespace parallax {

// Not thread-safe.
class PairRate {
 public:
  explicit PairRate(double window_s) : window_s_(window_s) {}

  // `total` only grows but for studies that fall out of the listing; a fall starts the window anew.
  void Add(SteadyTime now, int64_t total) {
    if (!samples_.empty() && total < samples_.back().total) samples_.clear();
    samples_.push_back({now, total});
    while (samples_.size() > 2 && Seconds(now - samples_[1].at) >= window_s_) samples_.pop_front();
  }

  double per_hour() const {
    if (samples_.size() < 2) return 0;
    const double span_s = Seconds(samples_.back().at - samples_.front().at);
    if (span_s <= 0) return 0;
    return 3600.0 * static_cast<double>(samples_.back().total - samples_.front().total) / span_s;
  }

 private:
  struct Sample {
    SteadyTime at;
    int64_t total;
  };
  static double Seconds(SteadyTime::duration span) {
    return std::chrono::duration<double>(span).count();
  }

  const double window_s_;
  std::deque<Sample> samples_;
};

}  // namespace parallax
