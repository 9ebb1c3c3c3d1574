// The table `jobs`. job_store.cc has all SQL that changes jobs, with one guarded statement for each
// move. It makes no decisions. Used only by the writing thread, inside a transaction.
//
// Errors of all functions: those of the database; kInternal if a guard kept a row from changing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/job_state.h"

namespace parallax {

// A row of `jobs`.
struct JobRow : JobFacts {
  JobState state = JobState::kReady;
  uint64_t fence = 0;  // 0: none.
  std::string worker;
  int attempts = 0;
  int app_failures = 0;
  int infra_losses = 0;
  bool reused = false;
  int64_t awaits_job = 0;  // The job whose lease it is blocked on; 0: none.
  int64_t waits_open = 0;  // Its OPEN rows of `waits`.
  double ready_unix_s = 0;
  std::string error;
};

// The change of a job whose lease ended without a result.
struct LossUpdate {
  JobState state = JobState::kReady;
  int app_failures = 0;
  int infra_losses = 0;
  std::optional<double> not_before_unix_s;
  std::string error;
};

class JobStore {
 public:
  // `db` and `kinds` must outlive the store.
  JobStore(SqliteConnection& db, const KindRegistry& kinds) : db_(db), kinds_(kinds) {}

  // Return the job with this id; nothing if it is unknown. Find looks outside of the archive,
  // FindArchived inside.
  absl::StatusOr<std::optional<JobRow>> Find(int64_t id);
  absl::StatusOr<std::optional<JobRow>> FindArchived(int64_t id);
  // As Find. Errors: kInternal if there is no such job.
  absl::StatusOr<JobRow> Get(int64_t id);
  // Inserts a job and sets row.id. `now` becomes its ready_unix_s, and also its finished_unix_s if
  // its state is terminal.
  absl::Status Insert(JobRow& row, double now);
  // Return ids of jobs: those BLOCKED on a leader, those in a state within a group, and those
  // leased to a worker.
  absl::StatusOr<std::vector<int64_t>> Followers(int64_t leader);
  absl::StatusOr<std::vector<int64_t>> ReadyInGroup(const Sha256Digest& group_key);
  absl::StatusOr<std::vector<JobRow>> LeasedInGroup(const Sha256Digest& group_key);
  absl::StatusOr<std::vector<int64_t>> LeasedBy(const std::string& worker);
  // Returns the jobs of a study (of one variant if `variant` is not 0) that have not ended; leased
  // ones come last.
  absl::StatusOr<std::vector<int64_t>> Unfinished(int64_t study, int64_t variant);
  // Return the jobs whose back-off is over at `now`, at most `limit`, and the time of the next one.
  absl::StatusOr<std::vector<int64_t>> BackoffsDue(double now, double longest_s, int limit);
  absl::StatusOr<std::optional<double>> NextBackoff();
  // Returns the newest generation of the job with this id, which may be the job itself. Looks in
  // the archive too.
  absl::StatusOr<std::optional<JobRow>> FindNewest(int64_t id);
  // Returns the newest generations that ended as FAILED, QUARANTINED or CANCELLED, by ordinal.
  absl::StatusOr<std::vector<int64_t>> Lost(int64_t variant);

  // Moves between states. Each is guarded by the state that it starts from. Errors: kInternal if
  // the row was in another state.
  absl::Status MoveToLeased(const JobRow& row, uint64_t fence, const std::string& worker,
                            bool part_given);
  // These, MoveToReused and MoveToCancelled also end the job's waits.
  absl::Status MoveToReady(int64_t id, double now);
  absl::Status MoveToBlocked(int64_t id, int64_t leader);
  // Sets the number of OPEN waits of a BLOCKED job.
  absl::Status SetWaitsOpen(int64_t id, int64_t waits_open);
  // Ends a job by a report of the attempt `fence`.
  absl::Status MoveToResult(int64_t id, uint64_t fence, JobState state, const std::string& error,
                            double now);
  // Ends a job by another job's result.
  absl::Status MoveToReused(int64_t id, JobState state, const std::string& error, double now);
  absl::Status MoveAfterLoss(const JobRow& row, const LossUpdate& update, double now);
  absl::Status MoveToCancelled(int64_t id, const std::string& reason, double now);

  // Changes the input of a LEASED job, whose lease is about to end.
  absl::Status SetInput(int64_t id, const std::string& input);
  // Gives a READY or BLOCKED job other keys.
  absl::Status SetKeys(int64_t id, const JobKeys& keys);
  // Leaves a READY job only these rigs, because it gave others to new jobs.
  absl::Status ShrinkReady(int64_t id, const std::string& rigs, uint32_t rig_count,
                           const Sha256Digest& work_key);

 private:
  absl::StatusOr<std::optional<JobRow>> OneRow(SqliteQuery& query);
  absl::Status Moved(const absl::Status& status, int64_t id, JobState to);

  SqliteConnection& db_;
  const KindRegistry& kinds_;
};

// The columns that JobRowOf reads, in its order.
#define PARALLAX_JOB_COLUMNS                                                                \
  "id, study_id, variant_id, kind, ordinal, rigs, rig_count, generation, state, work_key, " \
  "group_key, fence, worker, attempts, app_failures, infra_losses, part_given, reused, "    \
  "awaits_job, ready_unix_s, error, input, waits_open"
// Returns the job in the query's current row. Errors: kDataLoss for a kind or state that this
// program does not know.
absl::StatusOr<JobRow> JobRowOf(const SqliteQuery& query, const KindRegistry& kinds);

}  // namespace parallax
