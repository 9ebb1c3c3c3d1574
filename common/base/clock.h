// Time comes in as a Clock&, so that tests own it. Thread-safe.
#pragma once

#include <chrono>

namespace parallax {

using SteadyTime = std::chrono::steady_clock::time_point;

class Clock {
 public:
  virtual ~Clock() = default;
  // Wall clock: for people and for deadlines kept across restarts.
  virtual double UnixSeconds() = 0;
  virtual SteadyTime Steady() = 0;  // Never jumps: for durations and leases.
  static Clock& System();           // The machine's.
};

}  // namespace parallax
