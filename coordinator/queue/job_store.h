// The machine's tables as values and small functions: all SQL that changes jobs, scenes, results
// and frames stands in job_store.cc, one guarded statement a move. No decisions here. Used inside a
// transaction by the writing thread only.
//
// Errors: those of the database; kInternal for a row that a guard kept from changing.
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

struct JobRow : JobFacts {
  JobState state = JobState::kReady;
  uint64_t fence = 0;  // 0: none.
  std::string worker;
  int attempts = 0;
  int app_failures = 0;
  int infra_losses = 0;
  bool reused = false;
  int64_t awaits_job = 0;  // Whose lease it is blocked on; 0: none.
  int64_t waits_open = 0;  // Rows of `waits` that are still to be met.
  double ready_unix_s = 0;
  std::string error;
};

struct SceneRow {
  uint32_t rigs = 0;
  uint32_t rigs_lost = 0;
  uint32_t rigs_done = 0;
  uint32_t jobs_open = 0;
  std::optional<Sha256Digest> scene_hash;
};

// What a lease's end without result does to a job.
struct LossUpdate {
  JobState state = JobState::kReady;
  int app_failures = 0;
  int infra_losses = 0;
  std::optional<double> not_before_unix_s;
  std::string error;
};

// The scene whose jobs may go on from a folder.
struct KeptFor {
  int64_t variant = 0;
  uint32_t ordinal = 0;
};

class JobStore {
 public:
  // Both outlive the store. `most_logs`: of failed attempts, here and once more in the archive; the
  // oldest are dropped.
  JobStore(SqliteConnection& db, const KindRegistry& kinds, int most_logs)
      : db_(db), kinds_(kinds), most_logs_(most_logs) {}

  // ---- Jobs -------------------------------------------------------------------------------------
  absl::StatusOr<std::optional<JobRow>> Find(int64_t id);
  // Sets row.id. `now` becomes ready_unix_s, and finished_unix_s of a job that is born terminal.
  absl::Status Insert(JobRow& row, double now);
  absl::StatusOr<std::vector<int64_t>> Followers(int64_t leader);
  absl::StatusOr<std::vector<int64_t>> ReadyInGroup(const Sha256Digest& group_key);
  absl::StatusOr<std::vector<JobRow>> LeasedInGroup(const Sha256Digest& group_key);
  absl::StatusOr<std::vector<int64_t>> LeasedBy(const std::string& worker);
  // Jobs of a study (of one variant of it, if not 0) that have not ended; the leased ones last.
  absl::StatusOr<std::vector<int64_t>> Unfinished(int64_t study, int64_t variant);
  absl::StatusOr<std::vector<int64_t>> BackoffsDue(double now, double longest_s, int limit);
  absl::StatusOr<std::optional<double>> NextBackoff();
  // The newest generation of the job with this id, itself if there is no newer; archived ones too.
  absl::StatusOr<std::optional<JobRow>> FindNewest(int64_t id);
  // Newest generations that ended as FAILED, QUARANTINED or CANCELLED, by ordinal.
  absl::StatusOr<std::vector<int64_t>> Lost(int64_t variant);

  // Moves. Each is guarded by the state it starts from; kInternal if the row was not in it.
  absl::Status MoveToLeased(const JobRow& row, uint64_t fence, const std::string& worker,
                            bool part_given);
  // These three end a job's waits too.
  absl::Status MoveToReady(int64_t id, double now);
  absl::Status MoveToBlocked(int64_t id, int64_t leader);
  // A BLOCKED job still waits for so much.
  absl::Status SetWaitsOpen(int64_t id, int64_t waits_open);
  // By a report of the attempt `fence`.
  absl::Status MoveToResult(int64_t id, uint64_t fence, JobState state, const std::string& error,
                            double now);
  // By somebody else's result.
  absl::Status MoveToReused(int64_t id, JobState state, const std::string& error, double now);
  absl::Status MoveAfterLoss(const JobRow& row, const LossUpdate& update, double now);
  absl::Status MoveToCancelled(int64_t id, const std::string& reason, double now);

  // A READY job gives up some of its rigs.
  absl::Status ShrinkReady(int64_t id, const std::string& rigs, uint32_t rig_count,
                           const Sha256Digest& work_key);

  absl::Status InsertLoss(int64_t job, uint64_t fence, const char* ledger,
                          const std::string& worker, const std::string& fingerprint,
                          const std::string& error, double now, const std::string& log_tail = "");
  absl::StatusOr<bool> WasLost(int64_t job,
                               uint64_t fence);  // In either ledger.
  absl::StatusOr<bool> HasLoss(int64_t job, uint64_t fence, const char* ledger);
  // Different workers in a job's ledgers.
  absl::StatusOr<int> WorkersWithFingerprint(int64_t job, const std::string& fingerprint);
  absl::StatusOr<int> WorkersLost(int64_t job);
  // Since the job first lost its worker, one was lost that did not hold it. Looks at all losses.
  absl::StatusOr<bool> WorkersLostWithout(int64_t job);
  // Each worker that was lost with the job, the one lost now among them, held one other job too,
  // the same each time.
  absl::StatusOr<bool> AlwaysLostWithAnother(int64_t job, const std::string& worker, double now);
  // The attempt's worker lives: it was away, and says nothing against the job.
  absl::Status MoveLostToReturned(int64_t job, uint64_t fence);

  // ---- Scenes ---------------------------------------------------------------------------------
  absl::Status InsertScene(int64_t variant, uint32_t ordinal, const SceneRow& row);
  absl::StatusOr<SceneRow> FindScene(int64_t variant, uint32_t ordinal);
  absl::Status WriteScene(int64_t variant, uint32_t ordinal, const SceneRow& row);
  // Ordinal of the highest scene that has not lost all its rigs.
  absl::StatusOr<std::optional<uint32_t>> HighestLiving(int64_t variant);

  // ---- Results ----------------------------------------------------------------------------------
  absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key);
  absl::StatusOr<bool> HasResult(const Sha256Digest& key);
  // First committed wins: leaves an existing result alone. True if it is new.
  absl::StatusOr<bool> InsertResult(const Sha256Digest& key, std::string_view stage,
                                    const StoredResult& result, int64_t job, uint64_t fence);
  absl::Status InsertFrame(const JobFacts& scene_of, uint32_t rig, const Sha256Digest& frame_key,
                           bool reused);

  // A job outside of scenes has succeeded and has files.
  absl::Status InsertStudyResult(const JobRow& job);

  // ---- Litter and archive ---------------------------------------------------------------------
  absl::Status InsertLitter(const std::string& path, double now);
  absl::Status DeleteLitter(const std::string& path);
  // Folders that later attempts may go on from; `scene` of jobs of scenes.
  absl::Status InsertKept(const std::string& path, const Sha256Digest& keep_key,
                          const std::optional<KeptFor>& scene, double now);
  // The newest first.
  absl::StatusOr<std::vector<std::string>> KeptFolders(const Sha256Digest& keep_key, int limit);
  absl::StatusOr<bool> IsKept(const std::string& path);
  // The work is done: what was kept for it is litter now.
  absl::Status SweepDone(const Sha256Digest& work_key, double now);
  // No job of the scene is open: what was kept for it is litter now.
  absl::Status SweepScene(const KeptFor& scene, double now);
  // The same of work without scenes that no study wants any more: all are cancelled or archived.
  absl::Status SweepUnwanted(double now);
  // One that is finished since before `finished_before` and has jobs outside
  // the archive.
  absl::StatusOr<std::optional<int64_t>> StudyToArchive(double finished_before);
  // Moves up to `limit` ended jobs of the study, with their losses; how many.
  absl::StatusOr<int> ArchiveJobs(int64_t study, int limit);
  // Removes up to `limit` archived jobs of a forgotten study, with their losses; how many.
  absl::StatusOr<int> RemoveArchivedJobs(int64_t study, int limit);
  absl::StatusOr<std::optional<JobRow>> FindArchived(int64_t id);

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

// The columns that JobRowOf reads, in order.
#define PARALLAX_JOB_COLUMNS                                                                \
  "id, study_id, variant_id, kind, ordinal, rigs, rig_count, generation, state, work_key, " \
  "group_key, fence, worker, attempts, app_failures, infra_losses, part_given, reused, "    \
  "awaits_job, ready_unix_s, error, input, waits_open"
// Errors: kDataLoss for a kind or state that this program does not know.
absl::StatusOr<JobRow> JobRowOf(const SqliteQuery& query, const KindRegistry& kinds);

}  // namespace parallax
