// Jobs that wait for other jobs or for a variant's pairs: they are BLOCKED with OPEN rows in
// `waits`. While a command runs, it notes which jobs and variants end. Before the command ends,
// each waiter whose last wait is met is settled, and each that waits in vain is cancelled.
//
// Used by the writing thread only. Errors of all functions: those of the database; kInternal and
// kInvalidArgument for a wait that can never end.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/tables/queue_tables.h"

namespace parallax {

class JobMoves;

class Waiters {
 public:
  // `tables` must outlive the object.
  explicit Waiters(Tables& tables) : tables_(tables) {}

  enum class Prospect { kMet, kOpen, kVain };
  struct Outlook {
    Prospect prospect = Prospect::kOpen;
    std::string why;  // Set with kVain: "job 12, which it waits for, is FAILED".
  };
  // Returns whether a wait is met, open or in vain, as seen within this command.
  absl::StatusOr<Outlook> OutlookOf(const JobWait& wait);
  // Sets the state of a new job with waits: BLOCKED, or CANCELLED if it would wait in vain. Returns
  // the states of its rows, in the order of `waits`.
  absl::StatusOr<std::vector<const char*>> Plan(const std::vector<JobWait>& waits, JobRow& job);
  // Returns the waits of a job's next generation: for the newest generations of the jobs that it
  // waited for. Neither the archive nor a job that took an older result keeps rows of them: then
  // the kind knows.
  absl::StatusOr<std::vector<JobWait>> WaitsAgain(const JobRow& job);
  // Returns whether a job that waited for pairs or networks, some of which may have been taken
  // back, has all of them.
  absl::StatusOr<bool> HasWhatItWaitedFor(const JobRow& job);
  // Settles waiters for all that has ended in this command.
  absl::Status Settle(JobMoves& jobs);

 private:
  // Settles each of these that has no other OPEN waits.
  absl::Status Release(const std::vector<int64_t>& waiters, JobMoves& jobs);
  absl::Status Cancel(const std::vector<int64_t>& waiters, const std::string& why, JobMoves& jobs);

  Tables& tables_;
};

}  // namespace parallax
