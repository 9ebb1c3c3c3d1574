// The command line of the program `worker`, and what the agent and the jobs get of it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/agent/agent.h"
#include "worker/agent/attempts/job_handler.h"
#include "worker/agent/worker_program.h"

namespace CLI {
class App;
}

namespace parallax {

// The options as they are given; see `worker --help`.
struct WorkerCommandLine {
  std::string role;
  std::string coordinator;
  int slots = 1;
  std::string name;
  std::string tags;
  std::string store;
  int threads = 0;
  int64_t memory_mb = 0;
  double grace_s = 300;
  double long_grace_s = 3600;
  double idle_exit_s = 0;
  double deadline_unix_s = 0;
  double hang_s = 1800;
  std::string outbox;
  std::string picture_root;
  bool follow_links = false;
  std::string allowed_trainers = "builtin";
  std::string trainers_dir;
  std::string benchmarks_dir;
  std::string cores_dir;
  std::string cache_dir;
  int64_t cache_gb = 20;
  bool insecure = false;
  std::string tls_dir;
  std::string health;
  bool exit_when_orphaned = false;
  bool log_json = false;
  std::string log_level = "info";
};

// Declares all options in the order of --help. `line` must outlive `app`, which writes to it.
void DeclareWorkerOptions(CLI::App& app, WorkerCommandLine& line);

// Returns the kinds of jobs of --role: "all", or names of handlers separated by commas. Errors:
// kInvalidArgument, listing the known ones.
absl::StatusOr<std::vector<std::string>> KindsOfRole(std::string_view role,
                                                     const JobHandlers& handlers);

// Returns the agent's options. Limits the memory of this process to --memory-mb. Errors:
// kInvalidArgument for addresses, names and kinds that can't be; those of MakeRpcSecurity.
absl::StatusOr<AgentOptions> AgentOptionsOf(const WorkerCommandLine& line,
                                            const JobHandlers& handlers);

// Returns what the jobs need. `options` are those of the same line.
WorkerSettings WorkerSettingsOf(const WorkerCommandLine& line, const AgentOptions& options);

}  // namespace parallax
