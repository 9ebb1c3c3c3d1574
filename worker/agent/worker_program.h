// The program `worker` without its jobs: command line, log, signals, exit status. worker/main.cc
// adds the real jobs, tests add others.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// The part of the command line that jobs need.
struct WorkerSettings {
  int slots = 1;
  int threads = 0;            // For all jobs together; > 0.
  std::string picture_root;   // The folder whose pictures studies may use; empty: none.
  bool follow_links = false;  // Whether links in such folders may lead out of them.
  std::vector<std::string> allowed_trainers;  // Programs that may train and predict here.
  std::string trainers_dir;                   // Their YAML files; may be empty.
  // Public benchmarks as users download them; may be empty.
  std::string benchmarks_dir;
  std::string cores_dir;    // Workers with the same folder share cores.
  std::string cache_dir;    // Keeps pairs and own content for later use.
  int64_t cache_bytes = 0;  // Pairs may take so much, own content as well.
};

// The exit statuses of the process. They are part of its interface and never renumbered.
enum WorkerExit : int {
  kWorkerDrained = 0,     // All leased work is finished and reported.
  kWorkerFailed = 1,      // The store, the outbox or another local resource failed.
  kWorkerUsage = 2,       // Bad arguments.
  kWorkerRefused = 3,     // The coordinator refused this worker.
  kWorkerIncomplete = 4,  // Stopped with work handed back, or with reports still in the outbox.
  kWorkerOrphaned = 5,    // --exit-when-orphaned, and the parent died.
  kWorkerHung = 6,        // A job hung and was reported as failed; start the worker again.
};

// Runs the program. `handlers` are all jobs that it can do; --role chooses among them.
// `before_work` is called once, when the command line is valid, and returns the tags by which the
// worker tells what its jobs can do, beside those of --tags; its error ends the program. Returns
// the exit status, or ends the process when a job does not stop.
using BeforeWorkFn = std::function<absl::StatusOr<std::vector<std::string>>(const WorkerSettings&)>;
int RunWorkerProgram(int argc, char** argv, JobHandlers handlers,
                     const BeforeWorkFn& before_work = nullptr);

}  // namespace parallax
