// Leases as commands hand them on: to readers, which write their specs, and to the records in
// memory, which hear of them and of all else that happens outside of the database when it is on
// disk.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/ready_key.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// A committed lease. The reader that hands it out writes its spec.
struct GrantedLease {
  LeasedJob work;
  uint64_t fence = 0;
  std::string worker;
  int attempt_number = 0;
  std::string study;
  std::string variant;
};

// How a lease ended.
enum class LeaseEnd {
  kGivenBack,  // The job goes on and nobody was lost: handed back, never arrived, failed.
  kLost,       // With its worker.
  kOver,       // So did the job.
};

// The begin or the end of a lease, for the records of leases in memory.
struct LeaseRef {
  int64_t job = 0;
  uint64_t fence = 0;
  std::string worker;
  bool stop = false;  // The worker still works on it and must be told to stop, and why.
  std::string reason;
  // How the lease ended, if it did; see LossEvidence.
  LeaseEnd end = LeaseEnd::kOver;
  std::string machine = {};  // Its worker's, if that was lost.
  double progress = 0;
};

// Changes of the numbers of READY jobs, in the order in which jobs moved.
using ReadyChanges = std::vector<std::pair<ReadyKey, int64_t>>;

struct EffectCounts {
  bool work_ready = false;
  uint64_t completions = 0, failures = 0, losses = 0, stale = 0, splits = 0, archived = 0;
  uint64_t workers_lost = 0;
  std::vector<std::string> came_back;                         // Workers that had been given up.
  std::shared_ptr<const std::vector<v1::DrainOrder>> drains;  // All orders, if they have changed.
};
// The effects of commands outside of the database, for when they are on disk.
struct Effects : EffectCounts {
  std::vector<LeaseRef> granted;
  std::vector<LeaseRef> ended;
  ReadyChanges ready;
};

}  // namespace parallax
