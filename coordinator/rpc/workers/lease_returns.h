// Gives leases back to the queue. Each return waits for a commit, so it runs on the pool's threads;
// one that fails is logged, and its lease expires instead.
#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/task_pool.h"

namespace parallax {

// The names of the workers whose leases are being given up. A worker of that name is taken in only
// after that: otherwise it would lose the leases that it has just been told it keeps. Thread-safe.
class ForfeitingWorkers {
 public:
  bool Has(const std::string& worker) const;
  void Begin(const std::string& worker);
  void End(const std::string& worker);

 private:
  mutable std::mutex mu_;
  std::set<std::string> names_;  // Guarded by mu_.
};

// Gives up all leases of a worker that is lost or, without blame, has `drained` and left. Its name
// is in `forfeiting` meanwhile. `queue` must outlive the pool's tasks.
void ForfeitLeases(JobQueue& queue, TaskPool& pool,
                   const std::shared_ptr<ForfeitingWorkers>& forfeiting, const std::string& worker,
                   bool drained);

// Hands back leases to a worker that has gone meanwhile: their jobs are READY again, without blame.
// `queue` must outlive the pool's tasks.
void HandBackLeases(JobQueue& queue, TaskPool& pool, const std::string& worker,
                    const std::vector<v1::Lease>& leases);

}  // namespace parallax
