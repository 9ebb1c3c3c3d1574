// The source of time. Code takes a Clock& rather than reading the system's clock, so that tests can
// set the time. Implementations are thread-safe.
#pragma once

#include <chrono>

namespace parallax {

using SteadyTime = std::chrono::steady_clock::time_point;

class Clock {
 public:
  virtual ~Clock() = default;
  // Seconds since 1970-01-01 UTC by the wall clock, which may jump. For people, and for deadlines
  // that are kept across restarts.
  virtual double UnixSeconds() = 0;
  // Returns the time of a clock that never jumps and does not survive a restart. For durations and
  // leases.
  virtual SteadyTime Steady() = 0;
  // Returns the machine's clocks.
  static Clock& System();
};

}  // namespace parallax
