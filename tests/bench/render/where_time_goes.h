// A sampling profiler for benchmarks: where this process' CPU time goes, by the library whose code
// runs. A timer of CPU time interrupts every 2 ms; the handler only counts.
#pragma once

#include <cstdint>

namespace parallax::bench {

struct TimeShares {
  int64_t samples = 0;
  double embree = 0;  // Shares of the samples, in [0, 1].
  double denoiser = 0;
  double program = 0;  // Our own code.
};

// One at a time in a process. Counts only while `counting` is on.
class WhereTimeGoes {
 public:
  WhereTimeGoes();
  ~WhereTimeGoes();
  WhereTimeGoes(const WhereTimeGoes&) = delete;
  WhereTimeGoes& operator=(const WhereTimeGoes&) = delete;

  static void Count(bool counting);
  static TimeShares Shares();
};

}  // namespace parallax::bench
