#include "coordinator/rpc/workers/lease_returns.h"

#include "common/base/status.h"
#include "common/base/system/log.h"

namespace parallax {

bool ForfeitingWorkers::Has(const std::string& worker) const {
  const std::lock_guard lock(mu_);
  return names_.count(worker) > 0;
}

void ForfeitingWorkers::Begin(const std::string& worker) {
  const std::lock_guard lock(mu_);
  names_.insert(worker);
}

void ForfeitingWorkers::End(const std::string& worker) {
  const std::lock_guard lock(mu_);
  names_.erase(worker);
}

void ForfeitLeases(JobQueue& queue, TaskPool& pool,
                   const std::shared_ptr<ForfeitingWorkers>& forfeiting, const std::string& worker,
                   bool drained) {
  forfeiting->Begin(worker);
  pool.Run([&queue, forfeiting, worker, drained] {
    const auto lost = drained ? queue.WorkerLeft(worker) : queue.WorkerLost(worker);
    forfeiting->End(worker);
    if (!lost.ok()) {
      LogError("leases of a worker that has gone stay until they expire",
               {{"worker", worker}, {"error", lost.status()}});
    } else if (*lost > 0) {
      LogWarning("leases of a worker that has gone are given to others",
                 {{"worker", worker}, {"leases", *lost}});
    }
  });
}

void HandBackLeases(JobQueue& queue, TaskPool& pool, const std::string& worker,
                    const std::vector<v1::Lease>& leases) {
  for (const v1::Lease& lease : leases) {
    pool.Run([&queue, worker, attempt = lease.attempt()] {
      const auto outcome = queue.HandBack(worker, attempt, "worker gone before the lease");
      if (!outcome.ok()) LogWarning("lease not handed back", {{"error", outcome.status()}});
    });
  }
}

}  // namespace parallax
