// The table `waits` as values and small functions: what jobs wait for. No decisions here; what an
// end means for its waiters is in machine_waits.cc. Used inside a transaction by the writing thread
// only. Errors: those of the database.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

class WaitTable {
 public:
  explicit WaitTable(SqliteConnection& db) : db_(db) {}

  // Which jobs and variants somebody waits for, so that the others' ends cost no query.
  absl::Status Load();

  // `state` is "OPEN", "MET" or "DROPPED".
  absl::Status Insert(int64_t job, const JobWait& wait, const char* state);
  // Waits of a job, whatever became of them, in the order in which they were inserted.
  absl::StatusOr<std::vector<JobWait>> Of(int64_t job);
  absl::StatusOr<int64_t> OpenOf(int64_t job);

  // Jobs with an OPEN wait on this one, by id.
  absl::StatusOr<std::vector<int64_t>> OnJob(int64_t job);
  // Jobs with an OPEN wait on at most so many pairs of the variant, by id.
  absl::StatusOr<std::vector<int64_t>> OnPairs(int64_t variant, int64_t pairs);
  absl::Status MeetJob(int64_t job);
  absl::Status MeetPairs(int64_t variant, int64_t pairs);
  // The job has ended or needs none of its waits any more.
  absl::Status Drop(int64_t job);

 private:
  SqliteConnection& db_;
  // Supersets: never less than there are, more after an undone command or an end.
  std::unordered_set<int64_t> jobs_;
  std::unordered_set<int64_t> variants_;
};

}  // namespace parallax
