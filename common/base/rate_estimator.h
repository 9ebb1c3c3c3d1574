// How fast a count grows, and when it will be full.
#pragma once

#include <deque>
#include <optional>

namespace parallax {

// The rate over the samples of the last `window_s`, and over all of them while they are younger. A
// count grows in steps of a whole job, so a shorter window makes the rate jump. Not thread-safe.
class RateEstimator {
 public:
  explicit RateEstimator(double window_s = 600) : window_s_(window_s) {}

  // Times must not decrease; a sample at the time of the last one replaces it. A falling count
  // starts anew.
  void Add(double time_s, double count);
  // Per second. Absent before the count has grown.
  std::optional<double> PerSecond() const;
  // Seconds until the count has grown by `remaining`; 0 when nothing remains. Absent without a
  // rate.
  std::optional<double> SecondsFor(double remaining) const;

 private:
  struct Sample {
    double time_s;
    double count;
  };
  double window_s_;
  std::deque<Sample> samples_;
};

}  // namespace parallax
