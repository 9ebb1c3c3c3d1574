// The tags by which a worker tells the coordinator which trainers and benchmarks it has.
#pragma once

#include <string>
#include <vector>

#include "worker/jobs/job_options.h"

namespace parallax {

// Returns a tag for each allowed trainer whose program is here, for each benchmark in the worker's
// folder, and for the trained network that comes with Parallax.
std::vector<std::string> AbilityTagsOf(const JobOptions& options);

}  // namespace parallax
