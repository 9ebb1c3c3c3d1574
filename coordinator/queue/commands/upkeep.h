// The work that the queue does by itself: it ends leases that were not heard of in time or could
// not be told to their workers, wakes jobs whose back-off is over, removes rows of forgotten
// studies and moves old jobs to the archive.
#pragma once

#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/commands/lease_book.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/lease.h"

namespace parallax {

// Used by the writing thread only, but for EndUntold and SecondsToNext, which are thread-safe.
class Upkeep {
 public:
  // All arguments must outlive the object.
  Upkeep(Machine& machine, const LeaseBook& book, const JobQueueOptions& options)
      : machine_(machine), book_(book), options_(options) {}

  // Does what is due, as a command of the writer. Old rows go in small steps, so that no caller
  // waits for them. Errors: the database's.
  absl::Status Tick();
  // Returns whether Tick has something to do now.
  bool IsDue() const;
  // Makes the end of a lease due now whose message could not be made, for this reason.
  void EndUntold(const GrantedLease& lease, const absl::Status& why);
  // Makes the removal of old rows due now.
  void RemoveOldNow() { remove_at_ = options_.clock->Steady(); }
  // Returns the seconds until a lease can expire or the next back-off, at `next_backoff` in seconds
  // since 1970, is over.
  double SecondsToNext(const std::optional<double>& next_backoff) const;

 private:
  bool RemovalIsDue() const { return options_.clock->Steady() >= remove_at_; }
  absl::Status RemoveSome();
  absl::Status EndAllUntold();
  struct Untold {
    v1::FailRequest failure;
    bool is_of_disk = false;  // The job is not at fault.
  };

  Machine& machine_;
  const LeaseBook& book_;
  const JobQueueOptions& options_;
  SteadyTime remove_at_{};

  mutable std::mutex mutex_;
  std::vector<Untold> untold_;  // Guarded by mutex_.
};

}  // namespace parallax
