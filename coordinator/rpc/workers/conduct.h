// The recent record of each worker. A worker that fails all its jobs while others succeed is
// suspended for a growing time, then tried with one job: otherwise a broken machine, which fails
// quickly, would go through the whole queue. Records belong to workers' names, because restarting a
// worker does not mend its machine.
//
// Not thread-safe. The caller passes the time.
#pragma once

#include <map>
#include <string>

#include "common/base/system/clock.h"

namespace parallax {

class ConductBook {
 public:
  // Notes that an attempt of the worker has ended. Returns true if this suspends the worker.
  bool Reported(const std::string& worker, bool succeeded, SteadyTime now);
  // Returns the seconds until the worker's suspension ends; <= 0 if it is not suspended.
  double SuspendedFor(const std::string& worker, SteadyTime now) const;
  // Returns how many of the `credit` jobs that the worker asks for it may have now: none while it
  // is suspended, one on trial after a suspension (when `running` is 0), else all.
  int TrustIn(const std::string& worker, int credit, int running, SteadyTime now) const;
  void Forget(const std::string& worker) { conduct_.erase(worker); }

 private:
  struct Conduct {
    int failures_in_row = 0;
    SteadyTime first_failure{};  // Time of the first failure in the row.
    SteadyTime last_success{};
    double suspension_s = 0;  // Length of the last suspension; 0: none since its last success.
    SteadyTime suspended_until{};
  };
  std::map<std::string, Conduct> conduct_;
};

}  // namespace parallax
