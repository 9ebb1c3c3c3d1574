// The tables of the queue as values, and what commands note while they run, for their end and for
// the world outside of the database. Here are also the changes that concern several tables at once.
// Used by the writing thread only, inside a transaction. Errors of all functions: the database's.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/lease.h"
#include "coordinator/queue/tables/job_archive.h"
#include "coordinator/queue/tables/job_store.h"
#include "coordinator/queue/tables/ledger.h"
#include "coordinator/queue/tables/left_folders.h"
#include "coordinator/queue/tables/loss_table.h"
#include "coordinator/queue/tables/notice_table.h"
#include "coordinator/queue/tables/result_table.h"
#include "coordinator/queue/tables/scene_table.h"
#include "coordinator/queue/tables/waits.h"

namespace parallax {

// How a scene changes.
struct SceneChange {
  int jobs_open = 0;
  int rigs_lost = 0;
  bool all_lost = false;
  int rigs_done = 0;
  std::optional<Sha256Digest> scene_hash;
};

struct Tables {
  // `db` and `options` must outlive the tables.
  Tables(SqliteConnection& db, const JobQueueOptions& options, uint64_t epoch);

  double Now() const { return options.clock->UnixSeconds(); }
  double SteadySeconds() const;

  // Counts a job that has moved. Its study is loaded.
  void NoteMove(Variant& variant, const JobRow& before, JobState to);
  // Counts a job that has become READY (`change` 1) or no longer is (-1).
  void CountReady(const JobRow& job, int64_t change);
  // Returns the scene as it is after the change. Errors: kNotFound.
  absl::StatusOr<SceneRow> ChangeScene(Variant& variant, uint32_t ordinal,
                                       const SceneChange& change);
  // Returns the folder of a result's files, empty if it has none; nothing if there is no result.
  absl::StatusOr<std::optional<std::string>> FolderOfResult(const Sha256Digest& key);
  // Removes a result unless pairs or networks of a study refer to it. Its folder becomes litter.
  absl::Status RemoveResult(const Sha256Digest& key);
  // Adds an entry to the audit table. `study` is 0 if the action concerns none.
  absl::Status Audit(std::string_view actor, std::string_view action, int64_t study,
                     std::string_view detail);

  SqliteConnection& db;
  const JobQueueOptions& options;
  const KindRegistry& kinds;
  const uint64_t epoch;
  JobStore jobs;
  LossTable losses;
  SceneTable scenes;
  ResultTable results;
  LeftFolders folders;
  JobArchive archive;
  WaitTable waits;
  NoticeTable notices;
  Ledger ledger;

  // ---- Memory between commands
  std::set<int64_t> hungry;  // Variants that may need scenes; a superset.
  int64_t leased_now = 0;
  // READY jobs whose group had no part when they became READY. While they are READY, no job makes
  // the part (they would be BLOCKED on it), so it need not be looked for.
  std::unordered_set<int64_t> without_part;
  Effects effects;        // Effects of the commands since Machine::TakeEffects.
  size_t ready_mark = 0;  // Where those of the current command begin in effects.ready.

  // ---- The current command's notes
  uint64_t ending_fence = 0;           // Fence of the attempt whose result is being stored.
  std::vector<DamagedResult> missing;  // Results that it found without files.
  // Jobs and variants that have ended and whose waiters are not settled yet.
  std::vector<std::pair<int64_t, JobState>> ended_jobs;
  std::set<int64_t> changed_variants;  // They published pairs, gave up or were cancelled.
};

}  // namespace parallax
