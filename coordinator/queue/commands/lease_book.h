// The current leases, and when each was last heard of. Kept in memory, because a heartbeat must not
// cost a disk write. After a restart, a lease counts as heard of when the first start found it that
// its worker has said nothing to. Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/system/clock.h"
#include "coordinator/queue/lease.h"

namespace parallax {

struct LeaseProgress {
  double fraction = 0;
  std::string stage;
  std::map<std::string, double> figures;  // Figures that the job reports; see v1::Progress.
  std::string log_tail;
};

class LeaseBook {
 public:
  LeaseBook(Clock& clock, double lease_s) : clock_(clock), lease_s_(lease_s) {}

  // Adds a lease that was granted, or found at the start and last heard of `unheard_s` seconds ago;
  // or removes one that has ended.
  void Add(const LeaseRef& lease, double unheard_s = 0);
  void Remove(const LeaseRef& lease);
  // Notes that a lease was heard of. Returns false if the worker has no such lease.
  bool Touch(const std::string& worker, const v1::AttemptId& attempt);
  // Notes that the leases in `running` were heard of, with their progress. Returns those that the
  // worker does not hold.
  std::vector<v1::AttemptId> Heartbeat(const std::string& worker,
                                       const std::vector<v1::Progress>& running);
  // Returns the leases that were not heard of for lease_s seconds.
  std::vector<LeaseRef> Expired() const;
  // Returns the seconds until the next lease can expire; lease_s if none exists.
  double SecondsToExpiry() const;
  // Returns whether the worker holds this lease.
  bool Holds(const std::string& worker, const v1::AttemptId& attempt) const;
  // Returns the newest progress of a leased job; zeros if it is not leased.
  LeaseProgress ProgressOf(int64_t job) const;
  // Returns the figures of at most `most` jobs that report any, by job.
  std::map<int64_t, std::map<std::string, double>> Figures(size_t most) const;
  int64_t size() const;
  // Returns the number of a worker's leases.
  int HeldBy(const std::string& worker) const;

 private:
  struct Entry {
    LeaseRef lease;
    SteadyTime heard;
    LeaseProgress progress;
  };
  void EraseLocked(std::map<int64_t, Entry>::iterator entry);
  Entry* FindLocked(const std::string& worker, const v1::AttemptId& attempt);
  double Age(const Entry& entry) const;

  Clock& clock_;
  const double lease_s_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::map<int64_t, Entry> entries_;    // By job.
  std::map<std::string, int> held_by_;  // Numbers of entries_ by worker, without zeros.
};

}  // namespace parallax
