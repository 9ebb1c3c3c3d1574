// Leases READY jobs to workers with credit, and tracks which workers are alive.
//
// For a worker with credit, the dispatcher asks the queue once. If the worker gets less than it
// asked for, it is hungry until the queue reports that work may be ready again. Then hungry workers
// of a class (equal abilities) ask in a growing window, which closes when some of them get nothing.
// So a thousand idle workers do not rush to the queue for one job.
//
// Thread-safe. One thread of its own sends all leases; the queue's thread only leaves notes for it.
// Without that thread, Work() does its part.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/why_waiting.h"
#include "coordinator/rpc/workers/worker_link.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class Dispatcher final : public JobQueueObserver {
 public:
  // Becomes the queue's observer. All arguments must outlive the dispatcher. A worker whose stream
  // broke is lost after `reconnect_grace_s` seconds.
  Dispatcher(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s,
             bool own_thread = true);
  ~Dispatcher() override;  // Calls Stop().

  // Registers a worker: adopts the attempts that it rightly holds, and closes an older stream of
  // the same name. Calls `welcome` with the adopted attempts; `welcome` must send the Welcome
  // message, which thus precedes any lease. Blocks for a commit. Errors: kAborted while a worker of
  // the same name is being taken in, or its earlier leases are being given up; the queue's.
  absl::Status Join(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
                    const std::function<void(const std::vector<v1::AttemptId>&)>& welcome);
  // Pass on the worker's messages. They are ignored unless `link` is the worker's current stream.
  void AddCredit(const std::string& worker, const WorkerLink* link, const v1::Credit& credit);
  // Renews the worker's leases, and answers on `link` even if it is an older stream: the attempts
  // that it does not hold any more, then that it was heard.
  void Heard(const std::string& worker, WorkerLink* link, const v1::Heartbeat& heartbeat);
  void Left(const std::string& worker, const WorkerLink* link);
  // Notes the end of an attempt. A worker that fails all its jobs while others succeed is
  // suspended; see ConductBook.
  void Reported(const std::string& worker, bool succeeded);

  // Stops leasing until it is called with false, because there is no place for results. What runs
  // goes on.
  void HoldLeases(bool hold);

  std::vector<v1::WorkerStatus> Workers() const;
  std::vector<WorkerGroup> WorkerGroups() const;  // See Fleet::Groups.
  ServerMetrics Metrics() const;                  // Without `reports`, `stages` and `work`.
  // Returns the connected workers whose names match the pattern; see CheckDrain.
  std::vector<std::string> ConnectedLike(const std::string& pattern) const;

  // Without a thread of its own: does all that is due now. Returns when it must be called again,
  // if nothing happens before.
  SteadyTime Work();

  // Stops leasing: waits for the queue's pending answers, gives the leases in them back and closes
  // all links. Idempotent.
  void Stop();

  // JobQueueObserver, called from the queue's thread.
  void OnWorkReady() override;
  void OnStop(const std::string& worker, const v1::AttemptId& attempt,
              const std::string& reason) override;
  void OnDrains(const std::vector<v1::DrainOrder>& drains) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
