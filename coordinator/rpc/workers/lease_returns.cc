#include "coordinator/rpc/workers/lease_returns.h"

#include "common/base/status.h"
#include "common/base/system/log.h"

namespace parallax {

void ForfeitLeases(JobQueue& queue, TaskPool& pool, const std::string& worker) {
  pool.Run([&queue, worker] {
    const auto lost = queue.WorkerLost(worker);
    if (!lost.ok()) {
      LogError("leases of a lost worker stay until they expire",
               {{"worker", worker}, {"error", lost.status()}});
    } else if (*lost > 0) {
      LogWarning("leases of a lost worker are given to others",
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
