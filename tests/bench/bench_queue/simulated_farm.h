// Workers without work: each has its own connection, says Hello, gives credit, beats, and reports
// every lease at once as done. A slot asks for its next job when its report is answered, so a farm
// has at most workers x slots requests under way.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "samples.h"

namespace parallax {

struct FarmOptions {
  std::string address;
  std::string name = "simulated";  // Prefix of the workers' names.
  int workers = 256;
  int slots = 1;  // Of each.
};

// What all workers of a farm count together.
struct FarmTally {
  std::atomic<int64_t> leases{0};
  std::atomic<int64_t> completions{0};  // Answered OK.
  std::atomic<int64_t> pairs{0};        // That these published.
  std::atomic<int64_t> refused{0};      // Reports with any other answer.
  std::atomic<int64_t> broken{0};       // Calls and streams that ended with an error.
  Samples lease_ms;                     // From giving credit to the lease.
  Samples report_ms;                    // From sending a report to its answer.
};

class SimulatedFarm {
 public:
  // Connects; the workers begin at once. `tally` outlives the farm.
  static absl::StatusOr<std::unique_ptr<SimulatedFarm>> Start(const FarmOptions& options,
                                                              FarmTally& tally);
  ~SimulatedFarm();  // Breaks what is left of streams and waits for calls under way.

  // No more credit; what is leased is still reported.
  void StopAsking();

 private:
  class Worker;
  SimulatedFarm();
  void Beat();

  std::atomic<bool> asking_{true};
  std::vector<std::unique_ptr<Worker>> workers_;
  class Timer;
  std::unique_ptr<Timer> timer_;
};

}  // namespace parallax
