// The kinds of jobs that this worker can do. To add one: a file here with its handler and its Make
// function, a line below, a line in jobs.cc, and its coordinator side in coordinator/queue/kinds.
#pragma once

#include "worker/agent/worker_program.h"

namespace parallax {

std::unique_ptr<JobHandler> MakeSolveHandler();
std::unique_ptr<JobHandler> MakeRenderHandler();

// All of them, in the order in which work flows.
JobHandlers MakeJobHandlers();

}  // namespace parallax
