// The work of the simulated farm: its kinds of jobs, a worker that does all of them, and its
// reports.
#pragma once

#include <string>

#include "coordinator/queue/job_queue.h"

namespace parallax::faults {

// The built-in kinds, and noop jobs of each study, which wait for its pairs and for each other.
const KindRegistry& Kinds();
WorkerFacts LivingWorker(const std::string& name);
v1::CompleteRequest AnswerOf(const v1::Lease& lease, const std::string& worker);

}  // namespace parallax::faults
