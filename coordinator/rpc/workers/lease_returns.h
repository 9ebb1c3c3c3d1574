// Gives leases back to the queue. Each return waits for a commit, so it runs on the pool's threads;
// one that fails is logged, and its lease expires instead.
#pragma once

#include <string>
#include <vector>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/task_pool.h"

namespace parallax {

// Gives up all leases of a worker that is lost or, without blame, has `drained` and left. `queue`
// must outlive the pool's tasks.
void ForfeitLeases(JobQueue& queue, TaskPool& pool, const std::string& worker, bool drained);

// Hands back leases to a worker that has gone meanwhile: their jobs are READY again, without blame.
// `queue` must outlive the pool's tasks.
void HandBackLeases(JobQueue& queue, TaskPool& pool, const std::string& worker,
                    const std::vector<v1::Lease>& leases);

}  // namespace parallax
