// The program `worker` but for the work: command line, log, signals, exit status. worker/main.cc
// adds the real stages, tests add others.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "worker/agent/job_runner.h"

namespace parallax {

struct WorkerSettings {
  int slots = 1;
  int threads = 0;           // For all jobs together; > 0.
  std::string picture_root;  // The folder whose pictures studies may use; empty: none.
};

// What the process says when it ends. Part of the interface: never renumbered.
enum WorkerExit : int {
  kWorkerDrained = 0,     // All it had taken is finished and reported.
  kWorkerFailed = 1,      // Store, outbox or another part of this machine can't be used.
  kWorkerUsage = 2,       // Bad arguments.
  kWorkerRefused = 3,     // The coordinator does not want this worker.
  kWorkerIncomplete = 4,  // Stopped with work handed back, or with reports still in the outbox.
  kWorkerOrphaned = 5,    // --exit-when-orphaned, and the parent died.
  kWorkerHung = 6,        // A job hung and was reported as failed; start the worker again.
};

using MakeRunner = std::function<std::unique_ptr<JobRunner>(const WorkerSettings& settings)>;

// Returns the exit status, or ends the process by itself when a job doesn't stop.
int RunWorkerProgram(int argc, char** argv, const MakeRunner& make_runner);

}  // namespace parallax
