// Removes litter from the store: folders that no result names or ever will. They are of attempts
// that failed, were lost, handed back or cancelled, and of frames that another attempt published
// first.
//
// Live attempts are safe: a path becomes litter in the same commit that ends its attempt without a
// result, and a fence that has lost never wins again. The janitor still waits for some leases, so
// that a worker that is writing learns of it first. Files that such a worker leaves later become
// litter with its late report.
//
// The users' content is removed when no study names it any more: see content_keeper.h. Ended
// studies that the rules of retention don't keep are forgotten (storage/store_use.h), which makes
// litter of what no other study uses.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/content_keeper.h"
#include "coordinator/rpc/storage/farm_space.h"
#include "coordinator/rpc/storage/store_use.h"

namespace parallax {

struct JanitorOptions {
  double lease_s = 60;
  double leases = 5;       // Leases to wait before litter is removed.
  double every_s = 60;     // Time between sweeps; 0: only calls of Sweep().
  int content_every = 60;  // Sweeps from one removal of unused content to the next.
  // Age at which folders of attempts that the database does not know are removed; 0: never.
  double unknown_s = 7 * 86400.0;
  int unknown_every = 1440;  // Sweeps from one search for them to the next.
  RetentionRules keep;
  std::string database;             // The queue's file, whose disk is measured; empty: it is not.
  Clock* clock = &Clock::System();  // Must outlive the janitor.
};

// Thread-safe. Has one thread.
class Janitor {
 public:
  // All must outlive the janitor. Without `content`, users' content stays.
  Janitor(JobQueue& queue, Store& store, ContentKeeper* content, const JanitorOptions& options);
  ~Janitor();  // Stops after the current path.
  Janitor(const Janitor&) = delete;
  Janitor& operator=(const Janitor&) = delete;

  // Removes all litter that is old enough. Returns the number of removed paths. Paths that can't be
  // removed stay for the next time. Errors: the queue's.
  absl::StatusOr<int> Sweep() const;
  // Removes the users' content that no study names any more (content_keeper.h). Returns the number
  // of removed files. Errors: those of the queue and of the keeper.
  absl::StatusOr<int> SweepContent() const;
  // Removes folders of attempts that the database does not know (unknown_folders.h). Returns their
  // number. Errors: those of the queue and of the store.
  absl::StatusOr<int> SweepUnknown() const;
  // Counts the bytes of results, and forgets ended studies that the rules don't keep. Returns the
  // number of forgotten studies. Call it from one thread. Errors: the queue's; those of a store
  // that is away: then nothing is forgotten.
  absl::StatusOr<int> Retain();
  // Returns the room on the farm's disks, as the last sweep saw it.
  FarmSpace space() const;

 private:
  void Loop();
  bool IsStopping() const;
  void MeasureDisks();
  absl::Status RemoveEmptyAttempt(const std::string& path) const;

  JobQueue& queue_;
  Store& store_;
  ContentKeeper* const content_;
  const JanitorOptions options_;

  StoreUse use_;  // Used by Retain only.
  mutable std::mutex mu_;
  std::condition_variable stop_;
  // Guarded by mu_.
  bool stopping_ = false;
  FarmSpace space_;
  std::thread thread_;
};

}  // namespace parallax
