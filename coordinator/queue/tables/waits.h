// The table `waits`: a row for each condition that a job waits for. It makes no decisions:
// moves/waiters.cc decides what the end of a job means for its waiters. Used only by the writing
// thread, inside a transaction. Errors: those of the database.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

class WaitTable {
 public:
  explicit WaitTable(SqliteConnection& db) : db_(db) {}

  // Reads which jobs and variants have waiters, so that the ends of all others cost no query.
  absl::Status Load();

  // `state` is "OPEN", "MET" or "DROPPED".
  // Adds a wait of a job.
  absl::Status Insert(int64_t job, const JobWait& wait, const char* state);
  // Returns all waits of a job in any state, in the order in which they were inserted.
  absl::StatusOr<std::vector<JobWait>> Of(int64_t job);
  // Returns the number of the job's OPEN waits.
  absl::StatusOr<int64_t> OpenOf(int64_t job);

  // Returns the jobs with an OPEN wait for this job, by id.
  absl::StatusOr<std::vector<int64_t>> OnJob(int64_t job);
  // Returns the jobs with an OPEN wait for at most `pairs` pairs of the variant, by id.
  absl::StatusOr<std::vector<int64_t>> OnPairs(int64_t variant, int64_t pairs);
  // Set the OPEN waits for the job, or for at most `pairs` pairs of the variant, to MET.
  absl::Status MeetJob(int64_t job);
  absl::Status MeetPairs(int64_t variant, int64_t pairs);
  // Drops the job's waits, because it has ended or does not need them any more.
  absl::Status Drop(int64_t job);

 private:
  SqliteConnection& db_;
  // Supersets of the jobs and variants with waiters: an undone command or an end leaves some
  // behind.
  std::unordered_set<int64_t> jobs_;
  std::unordered_set<int64_t> variants_;
};

}  // namespace parallax
