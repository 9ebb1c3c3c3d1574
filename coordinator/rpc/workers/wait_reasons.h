// Adds to replies why READY jobs do not run. The reasons are those of WhyWaiting, from the queue's
// groups of jobs and the dispatcher's groups of workers. The cost of a call grows with the groups
// of alike jobs, never with the number of jobs. Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/system/clock.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/workers/why_waiting.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class WaitReasons {
 public:
  // `workers` returns the connected workers (Dispatcher::WorkerGroups); it is asked at most twice a
  // second. `queue`, `clock` and what `workers` uses must outlive the object.
  WaitReasons(JobQueue& queue, Clock& clock, std::function<std::vector<WorkerGroup>()> workers);

  // Sets `waiting` of a study. Jobs that no connected worker could run come first, then by number.
  void AddTo(v1::StudyStatus& study) const;
  // Sets `waits_reason` and `waits_text` of the study's READY jobs among `jobs`. Errors: those of
  // JobQueue::GetStudy, which is asked if there are any.
  absl::Status AddTo(std::span<v1::JobStatus> jobs, int64_t study) const;
  // Returns the kinds of the study's jobs that no connected worker could run, and why; `jobs` is 0.
  std::vector<v1::WaitingJobs> UnservableOf(const v1::StudySpec& study) const;

 private:
  std::shared_ptr<const std::vector<WorkerGroup>> Workers() const;

  JobQueue& queue_;
  Clock& clock_;
  const std::function<std::vector<WorkerGroup>()> workers_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  mutable std::shared_ptr<const std::vector<WorkerGroup>> groups_;
  mutable SteadyTime groups_at_{};
};

}  // namespace parallax
