// The machine's tables. job_store.cc has all SQL that changes jobs, scenes, results and frames,
// with one guarded statement for each move. It makes no decisions. Used only by the writing thread,
// inside a transaction.
//
// Errors of all functions: those of the database; kInternal if a guard kept a row from changing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/job_state.h"
#include "coordinator/queue/sqlite.h"

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

// A row of `scenes`: numbers of its rigs and of its unfinished jobs, and the hash of its recipe.
struct SceneRow {
  uint32_t rigs = 0;
  uint32_t rigs_lost = 0;
  uint32_t rigs_done = 0;
  uint32_t jobs_open = 0;
  std::optional<Sha256Digest> scene_hash;
};

// The change of a job whose lease ended without a result.
struct LossUpdate {
  JobState state = JobState::kReady;
  int app_failures = 0;
  int infra_losses = 0;
  std::optional<double> not_before_unix_s;
  std::string error;
};

// The scene whose jobs may continue from a kept folder.
struct KeptFor {
  int64_t variant = 0;
  uint32_t ordinal = 0;
};

class JobStore {
 public:
  // `db` and `kinds` must outlive the store. `most_logs` bounds the number of logs of failed
  // attempts, in the hot table and again in the archive; the oldest are dropped.
  JobStore(SqliteConnection& db, const KindRegistry& kinds, int most_logs)
      : db_(db), kinds_(kinds), most_logs_(most_logs) {}

  // ---- Jobs -------------------------------------------------------------------------------------
  // Returns the job with this id; nothing if it is unknown or in the archive.
  absl::StatusOr<std::optional<JobRow>> Find(int64_t id);
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

  // Leaves a READY job only these rigs, because it gave others to new jobs.
  absl::Status ShrinkReady(int64_t id, const std::string& rigs, uint32_t rig_count,
                           const Sha256Digest& work_key);

  // Enters an attempt that ended without a result in a ledger: "app", "lost" or "returned".
  absl::Status InsertLoss(int64_t job, uint64_t fence, const char* ledger,
                          const std::string& worker, const std::string& fingerprint,
                          const std::string& error, double now, const std::string& log_tail = "");
  // Returns whether the attempt is in a ledger of losses: in any of them, or in this one.
  absl::StatusOr<bool> WasLost(int64_t job, uint64_t fence);
  absl::StatusOr<bool> HasLoss(int64_t job, uint64_t fence, const char* ledger);
  // Return numbers of different workers in a job's ledgers: those that reported the fingerprint,
  // and those that were lost.
  absl::StatusOr<int> WorkersWithFingerprint(int64_t job, const std::string& fingerprint);
  absl::StatusOr<int> WorkersLost(int64_t job);
  // Returns whether, since the job first lost its worker, a worker was lost that did not hold it.
  // Reads all losses.
  absl::StatusOr<bool> WorkersLostWithout(int64_t job);
  // Returns whether there is another job that every worker lost with this job also held, including
  // the worker that is lost now.
  absl::StatusOr<bool> AlwaysLostWithAnother(int64_t job, const std::string& worker, double now);
  // Changes a loss into a return, because the attempt's worker lives and was only away: the loss no
  // longer counts against the job.
  absl::Status MoveLostToReturned(int64_t job, uint64_t fence);

  // ---- Scenes ---------------------------------------------------------------------------------
  // Insert, read and overwrite the row of a scene.
  absl::Status InsertScene(int64_t variant, uint32_t ordinal, const SceneRow& row);
  absl::StatusOr<SceneRow> FindScene(int64_t variant, uint32_t ordinal);
  absl::Status WriteScene(int64_t variant, uint32_t ordinal, const SceneRow& row);
  // Returns the ordinal of the highest scene that has not lost all its rigs.
  absl::StatusOr<std::optional<uint32_t>> HighestLiving(int64_t variant);

  // ---- Results ----------------------------------------------------------------------------------
  // Returns the result with this key, if there is one; HasResult reads less.
  absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key);
  absl::StatusOr<bool> HasResult(const Sha256Digest& key);
  // Inserts a result. The first one committed wins: leaves an existing result alone. Returns true
  // if it is new.
  absl::StatusOr<bool> InsertResult(const Sha256Digest& key, std::string_view stage,
                                    const StoredResult& result, int64_t job, uint64_t fence);
  // Publishes a pair of a scene.
  absl::Status InsertFrame(const JobFacts& scene_of, uint32_t rig, const Sha256Digest& frame_key,
                           bool reused);

  // Notes that a job without a scene has succeeded and has files.
  absl::Status InsertStudyResult(const JobRow& job);

  // ---- Litter and archive ---------------------------------------------------------------------
  // Add a path to the litter, or remove it.
  absl::Status InsertLitter(const std::string& path, double now);
  absl::Status DeleteLitter(const std::string& path);
  // Keeps a folder from which later attempts may continue. `scene` is set for jobs of scenes.
  absl::Status InsertKept(const std::string& path, const Sha256Digest& keep_key,
                          const std::optional<KeptFor>& scene, double now);
  // Returns kept folders, the newest first.
  absl::StatusOr<std::vector<std::string>> KeptFolders(const Sha256Digest& keep_key, int limit);
  absl::StatusOr<bool> IsKept(const std::string& path);
  // Makes litter of the folders kept for work that is done.
  absl::Status SweepDone(const Sha256Digest& work_key, double now);
  // Makes litter of the folders kept for a scene without open jobs.
  absl::Status SweepScene(const KeptFor& scene, double now);
  // Makes litter of the folders kept for work without a scene that no study wants any more: all its
  // jobs are cancelled or archived.
  absl::Status SweepUnwanted(double now);
  // Returns a study that finished before `finished_before` and still has jobs outside of the
  // archive.
  absl::StatusOr<std::optional<int64_t>> StudyToArchive(double finished_before);
  // Moves up to `limit` ended jobs of the study to the archive, with their losses. Returns their
  // number.
  absl::StatusOr<int> ArchiveJobs(int64_t study, int limit);
  // Removes up to `limit` archived jobs of a forgotten study, with their losses. Returns their
  // number.
  absl::StatusOr<int> RemoveArchivedJobs(int64_t study, int limit);
  absl::StatusOr<std::optional<JobRow>> FindArchived(int64_t id);

  // Adds an entry to the audit table. `study` is 0 if the action concerns none.
  absl::Status Audit(double now, std::string_view actor, std::string_view action, int64_t study,
                     std::string_view detail);

 private:
  absl::StatusOr<std::vector<int64_t>> Ids(SqliteQuery& query);
  absl::StatusOr<std::optional<JobRow>> OneRow(SqliteQuery& query);
  absl::Status Moved(const absl::Status& status, int64_t id, JobState to);

  SqliteConnection& db_;
  const KindRegistry& kinds_;
  const int most_logs_;
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
