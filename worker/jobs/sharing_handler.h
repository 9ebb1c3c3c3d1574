// Makes jobs that use the worker's shared threads wait while others hold all cores exclusively.
#pragma once

#include <memory>

#include "worker/agent/attempts/job_handler.h"
#include "worker/jobs/job_options.h"

namespace parallax {

// Wraps `handler` so that its jobs take a shared hold of `options->cores`, if set, while they run.
std::unique_ptr<JobHandler> ShareCores(std::unique_ptr<JobHandler> handler,
                                       std::shared_ptr<const JobOptions> options);

}  // namespace parallax
