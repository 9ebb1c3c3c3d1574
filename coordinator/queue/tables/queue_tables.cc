#include "coordinator/queue/tables/queue_tables.h"

#include <chrono>

namespace parallax {

Tables::Tables(SqliteConnection& connection, const JobQueueOptions& queue_options,
               uint64_t of_start)
    : db(connection),
      options(queue_options),
      kinds(*options.kinds),
      epoch(of_start),
      jobs(db, kinds),
      losses(db, options.most_logs),
      scenes(db),
      results(db),
      folders(db),
      archive(db, losses, options.unsafe_for_test.archive_newest),
      waits(db),
      notices(db, options.notice_targets),
      ledger(db, kinds, options.limits) {}

double Tables::SteadySeconds() const {
  return std::chrono::duration<double>(options.clock->Steady().time_since_epoch()).count();
}

void Tables::NoteMove(Variant& variant, const JobRow& before, JobState to) {
  // Where a limit held others back, one of them may go now.
  if (before.state == JobState::kLeased && ledger.IsFull(variant)) effects.work_ready = true;
  if (before.state != to) ledger.CountMove(variant, before.kind, before.state, to);
  if (IsTerminal(to)) ended_jobs.emplace_back(before.id, to);
  if (before.state == to) return;
  if (before.state == JobState::kReady) CountReady(before, -1);
  if (to == JobState::kReady) CountReady(before, 1);
}

void Tables::CountReady(const JobRow& job, int64_t change) {
  const Study& study = ledger.loaded_studies().at(job.study);
  ReadyKey key = ReadyKeyOf(job.study, {study.needs_memory_mb, study.needs_tags}, kinds[job.kind],
                            kinds[job.kind].NeedsOf(job.input));
  ReadyChanges& changes = effects.ready;
  if (changes.size() > ready_mark && changes.back().first == key) {
    changes.back().second += change;
  } else {
    changes.emplace_back(std::move(key), change);
  }
}

absl::StatusOr<SceneRow> Tables::ChangeScene(Variant& variant, uint32_t ordinal,
                                             const SceneChange& change) {
  ASSIGN_OR_RETURN(SceneRow * open, scenes.Open(variant.id, ordinal, /*change=*/true));
  SceneRow& scene = *open;
  const SceneRow before = scene;
  scene.jobs_open += static_cast<uint32_t>(change.jobs_open);
  scene.rigs_lost =
      change.all_lost ? scene.rigs : scene.rigs_lost + static_cast<uint32_t>(change.rigs_lost);
  scene.rigs_done += static_cast<uint32_t>(change.rigs_done);
  if (change.scene_hash) scene.scene_hash = change.scene_hash;

  VariantTally& tally = ledger.Change(variant);
  tally.pairs_planned -= static_cast<int64_t>(scene.rigs_lost) - before.rigs_lost;
  tally.pairs_done += static_cast<int64_t>(scene.rigs_done) - before.rigs_done;
  tally.scenes_open += (scene.jobs_open > 0) - (before.jobs_open > 0);
  if (scene.jobs_open == 0 || scene.rigs_lost != before.rigs_lost) hungry.insert(variant.id);
  if (change.rigs_done > 0) changed_variants.insert(variant.id);
  if (before.jobs_open > 0 && scene.jobs_open == 0) {
    RETURN_IF_ERROR(folders.SweepScene({variant.id, ordinal}, Now()));
  }
  return scene;
}

absl::StatusOr<std::optional<std::string>> Tables::FolderOfResult(const Sha256Digest& key) {
  std::optional<std::string> folder;
  SqliteQuery query(db, "SELECT stage, bytes FROM results WHERE work_key = ?1", key);
  if (query.Next()) folder = CommonFolder(kinds.StoredFiles(query.Text(0), query.Blob(1)));
  RETURN_IF_ERROR(query.status());
  return folder;
}

absl::Status Tables::RemoveResult(const Sha256Digest& key) {
  ASSIGN_OR_RETURN(const bool used,
                   db.Has("SELECT 1 FROM frames WHERE frame_key = ?1 UNION ALL"
                          " SELECT 1 FROM study_results WHERE work_key = ?1 LIMIT 1",
                          key));
  if (used) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::optional<std::string> folder, FolderOfResult(key));
  if (!folder) return absl::OkStatus();
  RETURN_IF_ERROR(db.Run("DELETE FROM results WHERE work_key = ?1", key));
  return folder->empty() ? absl::OkStatus() : folders.InsertLitter(*folder, Now());
}

absl::Status Tables::Audit(std::string_view actor, std::string_view action, int64_t study,
                           std::string_view detail) {
  return db.Run(
      "INSERT INTO audit(unix_s, actor, action, study_id, detail) VALUES (?1, ?2, ?3, ?4, ?5)",
      Now(), actor, action, NullIfZero(study), detail);
}

}  // namespace parallax
