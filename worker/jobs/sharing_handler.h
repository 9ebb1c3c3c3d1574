// Jobs whose threads are the whole worker's wait while others have all cores alone.
#pragma once

#include <memory>

#include "worker/agent/job_handler.h"
#include "worker/jobs/job_options.h"

namespace parallax {

// `handler`, whose jobs take a shared hold of `options->cores` while they run, if there are any.
std::unique_ptr<JobHandler> ShareCores(std::unique_ptr<JobHandler> handler,
                                       std::shared_ptr<const JobOptions> options);

}  // namespace parallax
