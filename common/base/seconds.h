// Seconds as numbers, between and after points of steady time.
#pragma once

#include "common/base/clock.h"

namespace parallax {

// `seconds` as a span of steady time, cut to whole ticks of the clock.
inline SteadyTime::duration SteadySpan(double seconds) {
  return std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(seconds));
}

inline SteadyTime SecondsAfter(SteadyTime from, double seconds) {
  return from + SteadySpan(seconds);
}

inline double SecondsBetween(SteadyTime from, SteadyTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace parallax
