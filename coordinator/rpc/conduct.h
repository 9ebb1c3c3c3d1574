// How workers have fared of late. One that fails everything while others succeed is suspended for a
// growing time, then tried with one job: a broken machine is the quickest of all and would else eat
// through the queue. Of a worker's name: starting again does not mend a broken machine.
//
// Not thread-safe. Times are the caller's.
#pragma once

#include <map>
#include <string>

#include "common/base/clock.h"

namespace parallax {

class ConductBook {
 public:
  // An attempt of the worker's has ended. True if that has suspended it.
  bool Reported(const std::string& worker, bool succeeded, SteadyTime now);
  // <= 0: it is not.
  double SuspendedFor(const std::string& worker, SteadyTime now) const;
  // How many of the jobs that it wants it may have now.
  int TrustIn(const std::string& worker, int credit, int running, SteadyTime now) const;
  void Forget(const std::string& worker) { conduct_.erase(worker); }

 private:
  struct Conduct {
    int failures_in_row = 0;
    SteadyTime first_failure{};  // Of those.
    SteadyTime last_success{};
    double suspension_s = 0;  // The last one's length; 0: none since its last success.
    SteadyTime suspended_until{};
  };
  std::map<std::string, Conduct> conduct_;
};

}  // namespace parallax
