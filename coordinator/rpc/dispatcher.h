// Brings READY jobs and workers with credit together, and keeps who is alive.
//
// A worker with credit asks the queue once; if it gets less than it asked for it is hungry until
// the queue says that work may be ready again. Then hungry workers ask in a growing window by class
// (equal abilities), which closes when some of the class come back empty: a thousand idle workers
// do not storm the queue for one job.
//
// Thread-safe. Has one thread, which does all sending of leases; the queue's thread only leaves
// notes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/worker_link.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class Dispatcher final : public JobQueueObserver {
 public:
  // All outlive the dispatcher. Becomes the queue's observer.
  Dispatcher(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s);
  ~Dispatcher() override;  // Stop().

  // Takes the worker in: adopts what it rightly holds, replaces an older stream of its name. Blocks
  // for a commit. Returns the adopted attempts. The welcome is sent by `welcome` before any lease
  // can be. Errors: kAborted while the same name is being taken in; the queue's.
  absl::Status Join(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
                    const std::function<void(const std::vector<v1::AttemptId>&)>& welcome);
  // The rest is ignored unless `link` is the worker's present one.
  void AddCredit(const std::string& worker, const WorkerLink* link, const v1::Credit& credit);
  void Heard(const std::string& worker, const WorkerLink* link, const v1::Heartbeat& heartbeat);
  void Left(const std::string& worker, const WorkerLink* link);
  // An attempt of this worker's has ended, and how. A worker that fails everything while others
  // succeed is suspended for a growing time, then tried with one job: a broken machine is the
  // quickest of all and would else eat through the queue.
  void Reported(const std::string& worker, bool succeeded);

  std::vector<v1::WorkerStatus> Workers() const;
  ServerMetrics Metrics() const;  // Without `reports`.
  // Connected workers whose names match the pattern; see CheckDrain.
  std::vector<std::string> ConnectedLike(const std::string& pattern) const;

  // No more leases; waits for those asked for and gives them back to the queue. Closes all links.
  // Idempotent.
  void Stop();

  // JobQueueObserver: from the queue's thread.
  void OnWorkReady() override;
  void OnStop(const std::string& worker, const v1::AttemptId& attempt,
              const std::string& reason) override;
  void OnDrains(const std::vector<v1::DrainOrder>& drains) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
