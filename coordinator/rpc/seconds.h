// Seconds as numbers, between and after points of steady time.
#pragma once

#include "common/base/clock.h"

namespace parallax {

inline SteadyTime SecondsAfter(SteadyTime from, double seconds) {
  return from +
         std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(seconds));
}

inline double SecondsBetween(SteadyTime from, SteadyTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace parallax
