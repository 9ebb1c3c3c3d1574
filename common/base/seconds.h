// Converts between points of steady time and seconds as numbers.
#pragma once

#include "common/base/system/clock.h"

namespace parallax {

// Returns `seconds` as a span of steady time, cut to whole ticks of the clock.
inline SteadyTime::duration SteadySpan(double seconds) {
  return std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(seconds));
}

// Returns the point of time `seconds` after `from`; before it if negative.
inline SteadyTime SecondsAfter(SteadyTime from, double seconds) {
  return from + SteadySpan(seconds);
}

// Returns the seconds from `from` to `to`; negative if `to` is earlier.
inline double SecondsBetween(SteadyTime from, SteadyTime to) {
  return std::chrono::duration<double>(to - from).count();
}

// Returns the seconds from `from` to now.
inline double SecondsSince(SteadyTime from) {
  return SecondsBetween(from, std::chrono::steady_clock::now());
}

}  // namespace parallax
