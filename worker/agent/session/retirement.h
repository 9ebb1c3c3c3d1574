// When a worker leaves by itself: after idling for a while, or before its allocation ends. Thus
// idle workers do not hold nodes of a batch system, and no job begins that the end of the
// allocation would cut off. Single-threaded; used by the agent's own thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "common/base/system/clock.h"

namespace parallax {

// When the worker must leave by itself.
struct RetirementOptions {
  double idle_s = 0;                   // Leave after this long without work. 0: never.
  std::optional<SteadyTime> deadline;  // Everything must be over by then.
  double margin_s = 0;                 // How long before the deadline running work must end.
};

// Watches idle time, the deadline and the length of jobs.
class Retirement {
 public:
  using AttemptKey = std::pair<int64_t, uint64_t>;  // Job and fence.

  Retirement(const RetirementOptions& options, SteadyTime now)
      : options_(options), idle_since_(now) {}

  void Began(AttemptKey attempt, SteadyTime now);
  void Ended(AttemptKey attempt, SteadyTime now);
  // Notes whether anything runs or waits in this worker now.
  void Observe(bool busy, SteadyTime now);

  // Returns whether a job as long as the longest so far would end in time.
  bool TakesWork(SteadyTime now) const;
  // Returns the reason why the worker should drain now; null while it should stay.
  const char* WhyLeave(SteadyTime now) const;
  // Returns the time at which WhyLeave may change, at the latest `until`.
  SteadyTime NextLook(SteadyTime until) const;

 private:
  // Returns the latest start for a job as long as the longest so far. Requires a deadline.
  SteadyTime LastStart() const;

  const RetirementOptions options_;
  std::map<AttemptKey, SteadyTime> running_;
  SteadyTime::duration longest_{};
  std::optional<SteadyTime> idle_since_;  // Empty while busy.
};

}  // namespace parallax
