// Removes from the store what no result names or ever will: the folders of attempts that failed,
// were lost, handed back or cancelled, and frames that another attempt published first.
//
// It is safe against live attempts because of who decides: a path becomes litter in the very commit
// that ends its attempt without a win, and a fence that has lost never wins again. It waits some
// leases nevertheless, so that a worker that still writes has heard of it; what such a worker
// leaves behind later comes back as litter with its late report.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

struct JanitorOptions {
  double lease_s = 60;
  double leases = 5;    // Litter is left alone for so many.
  double every_s = 60;  // 0: only when told to.
};

// Thread-safe. Has one thread.
class Janitor {
 public:
  // Both outlive the janitor.
  Janitor(JobQueue& queue, Store& store, const JanitorOptions& options);
  ~Janitor();  // After the path at hand.
  Janitor(const Janitor&) = delete;
  Janitor& operator=(const Janitor&) = delete;

  // Removes what is old enough. How many paths. What can't be removed stays for the next time.
  absl::StatusOr<int> Sweep() const;

 private:
  void Loop();
  absl::Status RemoveEmptyAttempt(const std::string& path) const;

  JobQueue& queue_;
  Store& store_;
  const JanitorOptions options_;

  mutable std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.
  std::thread thread_;
};

}  // namespace parallax
