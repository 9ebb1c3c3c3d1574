// Which leases are out and when each was last heard of. In memory only: a heartbeat must not cost a
// disk write. After a restart every lease counts as just heard of. Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "coordinator/queue/machine.h"

namespace parallax {

struct LeaseProgress {
  double fraction = 0;
  std::string stage;
  std::map<std::string, double> figures;  // What the job tells of itself; see v1::Progress.
};

class LeaseBook {
 public:
  LeaseBook(Clock& clock, double lease_s) : clock_(clock), lease_s_(lease_s) {}

  void Add(const LeaseRef& lease);
  void Remove(const LeaseRef& lease);
  // Counts as heard of; false if the book has no such lease of this worker.
  bool Touch(const std::string& worker, const v1::AttemptId& attempt);
  // Touches each; returns those that the worker doesn't hold.
  std::vector<v1::AttemptId> Heartbeat(const std::string& worker,
                                       const std::vector<v1::Progress>& running);
  // Not heard of for a whole lease.
  std::vector<LeaseRef> Expired() const;
  // Seconds until the next could expire, lease_s if there is none.
  double SecondsToExpiry() const;
  bool Holds(const std::string& worker, const v1::AttemptId& attempt) const;
  LeaseProgress ProgressOf(int64_t job) const;
  // Figures of at most `most` jobs that have any, by job.
  std::map<int64_t, std::map<std::string, double>> Figures(size_t most) const;
  int64_t size() const;
  // Leases of a worker.
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
  std::map<std::string, int> held_by_;  // By worker; those of entries_, without zeros.
};

}  // namespace parallax
