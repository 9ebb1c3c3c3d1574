// Counts the READY jobs of unfinished studies by what they need of a worker, so that one reason
// answers for all alike jobs, however many there are. Counts change with the commits that move
// jobs. Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/lease.h"
#include "coordinator/queue/ready_key.h"

namespace parallax {

class ReadyBoard {
 public:
  // Counts the jobs of a database. Reads the inputs of READY jobs without a scene only; all others
  // are in counters. Errors: kDataLoss for a kind that is not in `kinds`; the database's.
  absl::Status Load(SqliteConnection& db, const KindRegistry& kinds);
  void Apply(const ReadyChanges& changes);

  // Returns the groups that have jobs, with their numbers of jobs; `study` 0: of all studies.
  std::map<ReadyKey, int64_t> Groups(int64_t study = 0) const;

 private:
  mutable std::mutex mutex_;
  std::map<ReadyKey, int64_t> jobs_;  // Guarded by mutex_.
};

}  // namespace parallax
