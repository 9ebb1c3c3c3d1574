// The worker daemon: keeps one stream to the coordinator, leases jobs as slots become free, runs
// each through its kind's JobHandler and reports the result.
//
// - Running jobs go on while the coordinator restarts; it then adopts them or stops them.
// - A lease counts from the sending of the last heartbeat that was answered. When it expires, the
// work stops, because the coordinator may have given the job to another worker.
// - Finished work is in the outbox from before it is sent until it is answered.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_handler.h"
#include "worker/agent/health.h"
#include "worker/agent/session/report_sender.h"

namespace parallax {

// Options of the agent; most come from the command line.
struct AgentOptions {
  RpcAddress coordinator;
  RpcSecurity security;
  std::string name;                // See CheckWorkerName. Unique among the coordinator's workers.
  std::vector<std::string> kinds;  // Kinds of jobs that it takes; each has a handler.
  int slots = 1;                   // Jobs that run at a time.
  int cores = 1;
  int64_t memory_mb = 0;
  std::vector<std::string> tags;
  std::string version;
  std::string build_id;
  StageVersions versions;  // The versions of the runner's stages.
  std::string instance;    // Names this process; a restart under the same name has another.
  std::string machine;     // Where it runs; equal for all workers of a machine.
  // Overrides the coordinator's: the same store under another path of this machine.
  std::string store_uri;
  std::string outbox_root;     // Folder of all outboxes of this machine; see outbox.h.
  double grace_s = 300;        // From Drain() until running work is handed back.
  double long_grace_s = 3600;  // The same from DrainLong().
  // The worker drains by itself after idling for so long; 0: never.
  double idle_exit_s = 0;
  // Seconds since 1970 by which the process must be gone: it drains --grace before, and takes no
  // job that would not end by then. 0: none.
  double deadline_unix_s = 0;
  // How long stopped work may take to notice before the agent leaves without it.
  double hand_back_s = 3;
  // A job that reports no progress for so long is reported as failed, and the worker drains,
  // because a stuck thread can only be ended with its process. 0: never.
  double hang_s = 1800;
  // Reports that may wait for the coordinator besides running jobs. At this number the agent takes
  // no new work until some are answered.
  int max_pending_reports = 64;
  double connect_timeout_s = 5;
  double store_look_s = 2;  // Time between two looks whether the store is there.
  // A slot whose job ends within this time (by its progress) already asks for its next job. 0: only
  // when it is free. A job leased ahead waits here so long instead of running elsewhere.
  double ahead_s = 1;
  double backoff_base_s = 0.1;
  double backoff_cap_s = 5;
  ReportSenderOptions reports;
};

// The outcome of Agent::Run.
struct AgentSummary {
  int64_t succeeded = 0;
  int64_t failed = 0;
  int64_t handed_back = 0;
  size_t reports_left = 0;  // In the outbox, for the next worker on this machine.
  int stuck = 0;            // Jobs that did not stop when told; ~Agent would wait for them.
  int hung = 0;             // The part of `stuck` that AgentOptions::hang_s gave up.
};

// The daemon. Thread-safe.
class Agent {
 public:
  // Opens the outbox. `handlers` and `clock` outlive the agent.
  // Errors: kInvalidArgument for options; those of Outbox::Open and ConnectRpc.
  static absl::StatusOr<std::unique_ptr<Agent>> Create(const AgentOptions& options,
                                                       const JobHandlers& handlers, Clock& clock);
  virtual ~Agent() = default;  // Stops running jobs and waits for them.

  // Works until it is drained, and retries an unreachable coordinator indefinitely. Call once.
  // Errors that no retry mends: kInvalidArgument, kUnimplemented, kPermissionDenied,
  // kUnauthenticated, kFailedPrecondition from the coordinator; kAlreadyExists when another worker
  // of this name came; those of OpenStore.
  virtual absl::StatusOr<AgentSummary> Run() = 0;

  // Takes no new work, and ends Run() when all is finished and reported, or after the grace.
  virtual void Drain() = 0;
  // Drains like Drain(), but with the long grace. A later Drain() shortens it.
  virtual void DrainLong() = 0;
  // Hands back running jobs and ends Run() soon.
  virtual void HandBack() = 0;

  // Returns the answers for health probes.
  virtual WorkerHealth Health() const = 0;
};

}  // namespace parallax
