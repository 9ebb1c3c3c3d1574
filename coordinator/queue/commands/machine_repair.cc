// Takes results back whose files are damaged or gone, and asks for them again.
//
// A pair of a damaged result is not published any more, and a trained network is none of its study,
// from the commit that finds it out: no study says that it has what it has not. The same commit
// adds jobs that make them again. A study that had ended goes on until they are done.
#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/study/rigs.h"

namespace parallax {

absl::StatusOr<TakenBack> Machine::TakeBack(const std::vector<DamagedResult>& damaged,
                                            std::string_view actor) {
  TakenBack taken;
  std::map<SceneId, std::vector<uint32_t>> pairs;
  std::vector<int64_t> jobs;
  for (const DamagedResult& result : damaged) {
    ASSIGN_OR_RETURN(const std::string folder, FolderOfResult(result.key));
    if (folder.empty() || folder != result.folder) continue;  // Gone, or made anew meanwhile.
    ++taken.results;
    RETURN_IF_ERROR(TakePairsBack(result, taken, pairs));
    RETURN_IF_ERROR(TakeStudyResultsBack(result.key, jobs));
    RETURN_IF_ERROR(RemoveResult(result.key));
  }
  for (const auto& [scene, rigs] : pairs) {
    RETURN_IF_ERROR(AskForPairs(scene.first, scene.second, rigs));
    ++taken.jobs;
  }
  for (const int64_t job : jobs) {
    RETURN_IF_ERROR(AskForResult(job));
    ++taken.jobs;
  }
  if (taken.results > 0) {
    RETURN_IF_ERROR(
        Audit(actor, "repair", 0,
              fmt::format("{} damaged results taken back, {} pairs among them; {} jobs "
                          "make them again; the first: {}",
                          taken.results, taken.pairs, taken.jobs, OneLine(damaged.front().why))));
  }
  return taken;
}

absl::StatusOr<std::string> Machine::FolderOfResult(const Sha256Digest& key) {
  SqliteQuery query(db_, "SELECT stage, bytes FROM results WHERE work_key = ?1", key);
  if (!query.Next()) {
    RETURN_IF_ERROR(query.status());
    return std::string();
  }
  return CommonFolder(kinds_.StoredFiles(query.Text(0), query.Blob(1)));
}

absl::Status Machine::TakePairsBack(const DamagedResult& result, TakenBack& taken,
                                    std::map<SceneId, std::vector<uint32_t>>& lost) {
  struct Pair {
    int64_t cursor = 0, study = 0, variant = 0;
    uint32_t ordinal = 0, rig = 0;
    bool reused = false, forgotten = false;
  };
  std::vector<Pair> pairs;
  {
    SqliteQuery query(db_,
                      "SELECT f.cursor, f.study_id, f.variant_id, f.ordinal, f.rig, f.reused,"
                      " s.forgotten FROM frames AS f JOIN studies AS s ON s.id = f.study_id"
                      " WHERE f.frame_key = ?1",
                      result.key);
    while (query.Next()) {
      pairs.push_back({query.Int(0), query.Int(1), query.Int(2),
                       static_cast<uint32_t>(query.Int(3)), static_cast<uint32_t>(query.Int(4)),
                       query.Int(5) != 0, query.Int(6) != 0});
    }
    RETURN_IF_ERROR(query.status());
  }
  for (const Pair& pair : pairs) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM frames WHERE cursor = ?1", pair.cursor));
    if (pair.forgotten) continue;  // Its other rows go too.
    ++taken.pairs;
    RETURN_IF_ERROR(
        db_.Run("INSERT INTO repairs(variant_id, ordinal, rig, cursor, since_unix_s, reason)"
                " VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET"
                " cursor = ?4, since_unix_s = ?5, reason = ?6",
                pair.variant, pair.ordinal, pair.rig, pair.cursor, Now(), OneLine(result.why)));
    ASSIGN_OR_RETURN(const bool goes_on, GoesOn(pair.study));
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(pair.variant));
    if (pair.reused) --ledger_.Change(*variant).frames_reused;
    const bool again = goes_on && variant->tally.problem.empty();
    RETURN_IF_ERROR(
        ChangeScene(*variant, pair.ordinal, {.rigs_lost = again ? 0 : 1, .rigs_done = -1})
            .status());
    if (again) lost[{pair.variant, pair.ordinal}].push_back(pair.rig);
  }
  return absl::OkStatus();
}

absl::Status Machine::TakeStudyResultsBack(const Sha256Digest& key, std::vector<int64_t>& jobs) {
  struct Row {
    int64_t cursor = 0, study = 0, job = 0;
    bool forgotten = false;
  };
  std::vector<Row> rows;
  {
    SqliteQuery query(db_,
                      "SELECT r.cursor, r.study_id, r.job_id, s.forgotten FROM study_results AS r"
                      " JOIN studies AS s ON s.id = r.study_id WHERE r.work_key = ?1",
                      key);
    while (query.Next()) {
      rows.push_back({query.Int(0), query.Int(1), query.Int(2), query.Int(3) != 0});
    }
    RETURN_IF_ERROR(query.status());
  }
  for (const Row& row : rows) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM study_results WHERE cursor = ?1", row.cursor));
    if (row.forgotten) continue;
    ASSIGN_OR_RETURN(const bool goes_on, GoesOn(row.study));
    if (goes_on) jobs.push_back(row.job);
  }
  return absl::OkStatus();
}

// Returns whether the study may have new jobs. One that is in the archive comes back from there.
absl::StatusOr<bool> Machine::GoesOn(int64_t id) {
  ASSIGN_OR_RETURN(const auto archived,
                   db_.Integer("SELECT archived FROM studies WHERE id = ?1", id));
  if (archived.value_or(0) != 0) RETURN_IF_ERROR(archive_.Restore(id));
  ASSIGN_OR_RETURN(const Study* study, ledger_.FindStudy(id));
  return !study->tally.cancelled;
}

absl::Status Machine::AskForPairs(int64_t variant, uint32_t ordinal, std::vector<uint32_t> rigs) {
  std::sort(rigs.begin(), rigs.end());
  for (size_t kind = 0; kind < kinds_.size(); ++kind) {
    const JobTraits& traits = kinds_.at(kind).traits();
    if (!traits.of_scene || !traits.has_output) continue;
    ASSIGN_OR_RETURN(const auto last,
                     db_.Integer("SELECT max(generation) FROM jobs WHERE variant_id = ?1"
                                 " AND ordinal = ?2 AND kind = ?3 AND rigs = ?4",
                                 variant, ordinal, kinds_.at(kind).name(), RigsText(rigs)));
    // As a retry, which keeps its rigs whole.
    return AddJob({.kind = kinds_.at(kind).name(),
                   .variant = variant,
                   .ordinal = ordinal,
                   .rigs = std::move(rigs),
                   .generation = static_cast<int>(std::max<int64_t>(last.value_or(1), 1)) + 1})
        .status();
  }
  return Internal("no kind of job makes pairs");
}

absl::Status Machine::AskForResult(int64_t id) {
  ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.FindNewest(id));
  if (!job || !IsTerminal(job->state)) return absl::OkStatus();  // It is made again already.
  NewJob again{.kind = KindOf(*job).name(),
               .variant = job->variant,
               .ordinal = job->ordinal,
               .input = job->input,
               .generation = job->generation + 1};
  ASSIGN_OR_RETURN(again.waits, waits_.Of(id));
  for (JobWait& wait : again.waits) {
    if (wait.on_job == 0) continue;
    ASSIGN_OR_RETURN(const std::optional<JobRow> newest, store_.FindNewest(wait.on_job));
    if (newest) wait.on_job = newest->id;
  }
  return AddJob(again).status();
}

// A job that waited for pairs or networks, some of which have been taken back, goes on when they
// are there again.
absl::StatusOr<bool> Machine::HasWhatItWaitedFor(const JobRow& job) {
  if (KindOf(job).traits().of_scene) return true;
  ASSIGN_OR_RETURN(const std::vector<JobWait> waits, waits_.Of(job.id));
  for (const JobWait& wait : waits) {
    if (wait.on_job == 0) {
      ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(wait.on_variant));
      if (variant->tally.pairs_done < wait.pairs) return false;
      continue;
    }
    ASSIGN_OR_RETURN(const std::optional<JobRow> awaited, store_.FindNewest(wait.on_job));
    if (!awaited || !KindOf(*awaited).traits().has_output) continue;
    ASSIGN_OR_RETURN(const bool has, results_.Has(awaited->work_key));
    if (!has) return false;
  }
  return true;
}

}  // namespace parallax
