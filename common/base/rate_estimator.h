// Estimates how fast a count grows, and when it will reach a target.
#pragma once

#include <deque>
#include <optional>

namespace parallax {

// The rate over the samples of the last `window_s` seconds, or over all samples while they span
// less. A count grows in steps of a whole job, so the window reaches back, by up to four times its
// length, until it has three steps. Work that was there already comes in one step that is larger
// than all others together; such a step is left out as soon as there are two others. Until there
// is evidence, there is no rate: samples of 10 s, or of 30 s if one step makes up more than half of
// the growth. Not thread-safe.
class RateEstimator {
 public:
  explicit RateEstimator(double window_s = 600) : window_s_(window_s) {}

  // Adds a sample. Times must not decrease; a sample at the time of the last one replaces it. If
  // the count falls, all earlier samples are forgotten.
  void Add(double time_s, double count);
  // Returns the rate per second; absent without evidence.
  std::optional<double> PerSecond() const;
  // Returns the seconds until the count has grown by `remaining`; 0 if nothing remains, absent
  // without a rate.
  std::optional<double> SecondsFor(double remaining) const;

 private:
  struct Sample {
    double time_s;
    double count;
  };
  struct Growth {
    double sum = 0;
    double largest = 0;
    int steps = 0;
  };
  Growth GrowthSince(size_t first) const;

  double window_s_;
  std::deque<Sample> samples_;
};

}  // namespace parallax
