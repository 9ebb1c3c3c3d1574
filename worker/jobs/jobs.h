// The kinds of jobs that this worker can do. To add one: a file here with its handler and its Make
// function, a line below, a line in jobs.cc, and its coordinator side in coordinator/queue/kinds.
#pragma once

#include "worker/agent/worker_program.h"
#include "worker/jobs/job_options.h"

namespace parallax {

std::unique_ptr<JobHandler> MakeSolveHandler();
std::unique_ptr<JobHandler> MakeRenderHandler();
std::unique_ptr<JobHandler> MakeTrainHandler(std::shared_ptr<const JobOptions> options);
std::unique_ptr<JobHandler> MakeEvaluateHandler(std::shared_ptr<const JobOptions> options);

// All of them, in the order in which work flows. `options` may be filled in until the first job.
JobHandlers MakeJobHandlers(std::shared_ptr<const JobOptions> options);

}  // namespace parallax
