// Passes on what committed commands have brought about: to the records of leases in memory, to the
// counters, and to the queue's observer. Thread-safe.
#pragma once

#include <mutex>

#include "coordinator/queue/commands/lease_book.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/tables/ready_board.h"

namespace parallax {

class QueueNews {
 public:
  // Both arguments must outlive the object.
  QueueNews(LeaseBook& book, ReadyBoard& ready) : book_(book), ready_(ready) {}

  // Sets the observer; null removes it. Waits until a call of the observer in progress returns.
  void SetObserver(JobQueueObserver* observer);
  // Passes on the effects of a committed group. Calls the observer on the caller's thread.
  void Publish(const Effects& effects);
  // Returns the counters of effects; all other figures are those of a new object.
  JobQueueStats counted() const;

 private:
  void Tell(const Effects& effects);  // Requires mutex_.

  LeaseBook& book_;
  ReadyBoard& ready_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  JobQueueObserver* observer_ = nullptr;
  JobQueueStats counted_;
};

}  // namespace parallax
