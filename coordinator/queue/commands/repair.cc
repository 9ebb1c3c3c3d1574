#include "coordinator/queue/commands/repair.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "common/base/status.h"
#include "coordinator/study/rigs.h"

namespace parallax {

absl::StatusOr<TakenBack> Repair::TakeBack(const std::vector<DamagedResult>& damaged,
                                           std::string_view actor) {
  TakenBack taken;
  std::map<SceneId, std::vector<uint32_t>> pairs;
  std::vector<int64_t> jobs;
  for (const DamagedResult& result : damaged) {
    ASSIGN_OR_RETURN(const auto folder, tables_.FolderOfResult(result.key));
    if (folder.value_or("").empty() || *folder != result.folder) continue;  // Gone or made anew.
    ++taken.results;
    RETURN_IF_ERROR(TakePairsBack(result, taken, pairs));
    RETURN_IF_ERROR(TakeStudyResultsBack(result, jobs));
    RETURN_IF_ERROR(tables_.RemoveResult(result.key));
  }
  for (const auto& [scene, rigs] : pairs) {
    RETURN_IF_ERROR(AskForPairs(scene.first, scene.second, rigs));
    ++taken.jobs;
  }
  // A job only waits for older ones, which must have their next generations first.
  std::sort(jobs.begin(), jobs.end());
  for (const int64_t job : jobs) {
    RETURN_IF_ERROR(AskForResult(job));
    ++taken.jobs;
  }
  if (taken.results > 0) {
    RETURN_IF_ERROR(tables_.Audit(
        actor, "repair", 0,
        fmt::format("{} damaged results taken back, {} pairs among them; {} jobs "
                    "make them again; the first: {}",
                    taken.results, taken.pairs, taken.jobs, OneLine(damaged.front().why))));
  }
  return taken;
}

absl::Status Repair::TakePairsBack(const DamagedResult& result, TakenBack& taken,
                                   std::map<SceneId, std::vector<uint32_t>>& lost) {
  struct Pair {
    int64_t cursor = 0, study = 0, variant = 0;
    uint32_t ordinal = 0, rig = 0;
    bool reused = false, forgotten = false;
  };
  SqliteQuery query(tables_.db,
                    "SELECT f.cursor, f.study_id, f.variant_id, f.ordinal, f.rig, f.reused,"
                    " s.forgotten FROM frames AS f JOIN studies AS s ON s.id = f.study_id"
                    " WHERE f.frame_key = ?1",
                    result.key);
  ASSIGN_OR_RETURN(const std::vector<Pair> pairs, query.Rows([&] {
    return Pair{query.Int(0),
                query.Int(1),
                query.Int(2),
                static_cast<uint32_t>(query.Int(3)),
                static_cast<uint32_t>(query.Int(4)),
                query.Int(5) != 0,
                query.Int(6) != 0};
  }));
  for (const Pair& pair : pairs) {
    RETURN_IF_ERROR(tables_.db.Run("DELETE FROM frames WHERE cursor = ?1", pair.cursor));
    if (pair.forgotten) continue;  // Its other rows go too.
    ++taken.pairs;
    RETURN_IF_ERROR(tables_.db.Run(
        "INSERT INTO repairs(variant_id, ordinal, rig, cursor, since_unix_s, reason)"
        " VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET"
        " cursor = ?4, since_unix_s = ?5, reason = ?6",
        pair.variant, pair.ordinal, pair.rig, pair.cursor, tables_.Now(), OneLine(result.why)));
    ASSIGN_OR_RETURN(const bool goes_on, GoesOn(pair.study));
    ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(pair.variant));
    if (pair.reused) --tables_.ledger.Change(*variant).frames_reused;
    const bool again = goes_on && variant->tally.problem.empty();
    RETURN_IF_ERROR(
        tables_.ChangeScene(*variant, pair.ordinal, {.rigs_lost = again ? 0 : 1, .rigs_done = -1})
            .status());
    if (again) lost[{pair.variant, pair.ordinal}].push_back(pair.rig);
  }
  return absl::OkStatus();
}

absl::Status Repair::TakeStudyResultsBack(const DamagedResult& result, std::vector<int64_t>& jobs) {
  struct Row {
    int64_t cursor = 0, study = 0, job = 0;
    bool forgotten = false;
  };
  SqliteQuery query(tables_.db,
                    "SELECT r.cursor, r.study_id, r.job_id, s.forgotten FROM study_results AS r"
                    " JOIN studies AS s ON s.id = r.study_id WHERE r.work_key = ?1",
                    result.key);
  ASSIGN_OR_RETURN(const std::vector<Row> rows, query.Rows([&] {
    return Row{query.Int(0), query.Int(1), query.Int(2), query.Int(3) != 0};
  }));
  for (const Row& row : rows) {
    RETURN_IF_ERROR(tables_.db.Run("DELETE FROM study_results WHERE cursor = ?1", row.cursor));
    if (row.forgotten) continue;
    RETURN_IF_ERROR(
        tables_.db.Run("INSERT INTO taken_back(job_id, study_id, since_unix_s, reason)"
                       " VALUES (?1, ?2, ?3, ?4)",
                       row.job, row.study, tables_.Now(), OneLine(result.why)));
    ASSIGN_OR_RETURN(const bool goes_on, GoesOn(row.study));
    if (goes_on) jobs.push_back(row.job);
  }
  return absl::OkStatus();
}

// Returns whether the study may have new jobs. One that is in the archive comes back from there.
absl::StatusOr<bool> Repair::GoesOn(int64_t id) {
  ASSIGN_OR_RETURN(const auto archived,
                   tables_.db.Integer("SELECT archived FROM studies WHERE id = ?1", id));
  if (archived.value_or(0) != 0) RETURN_IF_ERROR(tables_.archive.Restore(id));
  ASSIGN_OR_RETURN(const Study* study, tables_.ledger.FindStudy(id));
  return !study->tally.cancelled;
}

absl::Status Repair::AskForPairs(int64_t variant, uint32_t ordinal, std::vector<uint32_t> rigs) {
  std::sort(rigs.begin(), rigs.end());
  for (size_t kind = 0; kind < tables_.kinds.size(); ++kind) {
    const JobTraits& traits = tables_.kinds.at(kind).traits();
    if (!traits.of_scene || !traits.has_output) continue;
    ASSIGN_OR_RETURN(
        const auto last,
        tables_.db.Integer("SELECT max(generation) FROM jobs WHERE variant_id = ?1"
                           " AND ordinal = ?2 AND kind = ?3 AND rigs = ?4",
                           variant, ordinal, tables_.kinds.at(kind).name(), RigsText(rigs)));
    // As a retry, which keeps its rigs whole.
    return jobs_
        .AddJob({.kind = tables_.kinds.at(kind).name(),
                 .variant = variant,
                 .ordinal = ordinal,
                 .rigs = std::move(rigs),
                 .generation = static_cast<int>(std::max<int64_t>(last.value_or(1), 1)) + 1})
        .status();
  }
  return Internal("no kind of job makes pairs");
}

absl::Status Repair::AskForResult(int64_t id) {
  ASSIGN_OR_RETURN(const std::optional<JobRow> job, tables_.jobs.FindNewest(id));
  if (!job || !IsTerminal(job->state)) return absl::OkStatus();  // It is made again already.
  NewJob again = jobs_.NextOf(*job);
  ASSIGN_OR_RETURN(again.waits, waiters_.WaitsAgain(*job));
  return jobs_.AddJob(again).status();
}

absl::Status Repair::KeepScrub(const ScrubState& scrub) {
  return tables_.db.Run(
      "INSERT INTO scrub(one, position, began_unix_s, ended_unix_s, files, bytes, damaged)"
      " VALUES (1, ?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET position = ?1,"
      " began_unix_s = ?2, ended_unix_s = ?3, files = ?4, bytes = ?5, damaged = ?6",
      SqlBlob{scrub.position}, scrub.began_unix_s, scrub.ended_unix_s, scrub.files, scrub.bytes,
      scrub.damaged);
}

}  // namespace parallax
