// One run of the simulated farm, decided by its seed alone.
#pragma once

#include <string>
#include <vector>

#include "tests/faults/simulate/points.h"
#include "tests/faults/simulate/world.h"

namespace parallax::faults {

struct RunOptions {
  uint64_t seed = 1;
  bool tells = false;  // Keep the story.
  Mutation mutation;
  // The faults end after so many events, through which the coordinator lives; 0: the seed decides.
  int64_t events = 0;
};

struct RunResult {
  std::vector<std::string> complaints;  // Empty: nothing was found.
  std::string story;
  double virtual_s = 0;
  int64_t events = 0;
  int64_t jobs = 0;      // Done.
  int64_t stale = 0;     // Late reports that were refused.
  int64_t starts = 0;    // Of the coordinator.
  bool refused = false;  // It ended for damage to its database.
  Points points;         // Steps of the queue's commands that it came to.
  // With RunOptions::events: the old processes held so many bytes more than new ones on the same
  // database; the size of this database.
  double grown_bytes = 0;
  double database_bytes = 0;
};

RunResult RunSeed(const RunOptions& options);

}  // namespace parallax::faults
