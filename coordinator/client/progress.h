// Rates, times to completion and bars. Pure but for RateEstimator's samples; not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "coordinator/client/terminal.h"

namespace parallax::client {

// How fast a count grows: over the samples of the last `window_s`, and over all of them while they
// are younger. A count grows in steps of a whole job, so a shorter window makes the rate jump.
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

// `columns` wide: the part done, the part begun (dim), the rest. Fractions are clamped to [0, 1] in
// total.
std::string ProgressBar(const Terminal& terminal, double done, double begun, int columns);

// "412 pairs/h", "-" without a rate.
std::string FormatRate(std::optional<double> per_second);
// "ETA 1:05", "" without one.
std::string FormatEta(std::optional<double> seconds);
// 0..100 without decimals; 100 only when all is done. "-" when nothing is wanted.
std::string FormatPercent(double done, double wanted);

}  // namespace parallax::client
