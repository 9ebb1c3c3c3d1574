// The kinds of jobs that this worker can do. To add one, add a file with its handler and Make
// function here, two lines below, and its coordinator side in coordinator/queue/kinds.
#pragma once

#include "worker/agent/worker_program.h"
#include "worker/jobs/job_options.h"
#include "worker/jobs/sharing_handler.h"

namespace parallax {

std::unique_ptr<JobHandler> MakeSolveHandler(std::shared_ptr<const JobOptions> options);
std::unique_ptr<JobHandler> MakeRenderHandler(std::shared_ptr<const JobOptions> options);
std::unique_ptr<JobHandler> MakeTrainHandler(std::shared_ptr<const JobOptions> options);
std::unique_ptr<JobHandler> MakeEvaluateHandler(std::shared_ptr<const JobOptions> options);

// Returns all handlers, in the order in which work flows. `options` may be filled in until the
// first job.
inline JobHandlers MakeJobHandlers(std::shared_ptr<const JobOptions> options) {
  JobHandlers handlers;
  handlers.push_back(ShareCores(MakeSolveHandler(options), options));
  handlers.push_back(ShareCores(MakeRenderHandler(options), options));
  handlers.push_back(MakeTrainHandler(options));
  handlers.push_back(MakeEvaluateHandler(options));
  return handlers;
}

}  // namespace parallax
