// The program `worker` but for the work: command line, log, signals, exit status. worker/main.cc
// adds the real jobs, tests add others.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "worker/agent/job_handler.h"

namespace parallax {

struct WorkerSettings {
  int slots = 1;
  int threads = 0;           // For all jobs together; > 0.
  std::string picture_root;  // The folder whose pictures studies may use; empty: none.
  std::vector<std::string> allowed_trainers;  // Programs that train and predict here.
  std::string trainers_dir;                   // Their YAML files; may be empty.
  std::string benchmarks_dir;                 // Public sets as users download them; may be empty.
  std::string cores_dir;                      // Workers that have the same one share cores.
  std::string cache_dir;                      // For files of the store that are needed again.
  int64_t cache_bytes = 0;
};

// The exit statuses of the process. They are part of its interface and never renumbered.
enum WorkerExit : int {
  kWorkerDrained = 0,     // All it had taken is finished and reported.
  kWorkerFailed = 1,      // Store, outbox or another part of this machine can't be used.
  kWorkerUsage = 2,       // Bad arguments.
  kWorkerRefused = 3,     // The coordinator does not want this worker.
  kWorkerIncomplete = 4,  // Stopped with work handed back, or with reports still in the outbox.
  kWorkerOrphaned = 5,    // --exit-when-orphaned, and the parent died.
  kWorkerHung = 6,        // A job hung and was reported as failed; start the worker again.
};

// `handlers` are all that this program can do; --role says which of them it does. `before_work` is
// called once, when the command line is right; its error ends the program. Returns the exit status,
// or ends the process by itself when a job doesn't stop.
int RunWorkerProgram(
    int argc, char** argv, JobHandlers handlers,
    const std::function<absl::Status(const WorkerSettings&)>& before_work = nullptr);

// Kinds of jobs by --role: "all", or names of handlers with commas between them.
// Errors: kInvalidArgument that names those there are.
absl::StatusOr<std::vector<std::string>> KindsOfRole(std::string_view role,
                                                     const JobHandlers& handlers);

}  // namespace parallax
