#include "coordinator/queue/commands/forgetting.h"

#include <map>
#include <set>

#include "coordinator/queue/database/compress.h"
#include "parallax/v1/study.pb.h"

namespace parallax {
namespace {

// Rows of a table that refer to results by `key`, and those results that they were the last to use.
absl::StatusOr<int> RemoveReferences(Tables& tables, int64_t study, const char* table,
                                     const char* key, int limit) {
  const std::string sql = std::string("SELECT cursor, ") + key + " FROM " + table +
                          " WHERE study_id = ?1 ORDER BY cursor LIMIT ?2";
  SqliteQuery query(tables.db, sql.c_str(), study, limit);
  ASSIGN_OR_RETURN(const auto rows,
                   query.Rows([&] { return std::pair(query.Int(0), query.Digest(1)); }));
  const std::string remove = std::string("DELETE FROM ") + table + " WHERE cursor = ?1";
  for (const auto& [cursor, result] : rows) {
    RETURN_IF_ERROR(tables.db.Run(remove.c_str(), cursor));
    RETURN_IF_ERROR(tables.RemoveResult(result));
  }
  return static_cast<int>(rows.size());
}

struct Twins {
  std::vector<int64_t> of_layout, of_scene;
};
// Variants of living studies whose scene of some number has the same layout, or is the same.
absl::StatusOr<Twins> TwinsOf(Tables& tables, int64_t variant) {
  Twins twins;
  const auto digests_of = [](const SqliteQuery& row) -> absl::StatusOr<ConfigDigests> {
    v1::SceneConfig config;
    RETURN_IF_ERROR(UnpackMessage(row.Blob(1), config));
    return DigestsOf(config);
  };
  SqliteQuery own(tables.db, "SELECT seed, config_z FROM variants WHERE id = ?1", variant);
  if (!own.Next()) return own.status();
  const int64_t seed = own.Int(0);
  ASSIGN_OR_RETURN(const ConfigDigests digests, digests_of(own));
  SqliteQuery others(tables.db,
                     "SELECT v.id, v.config_z FROM variants AS v JOIN studies AS s"
                     " ON s.id = v.study_id WHERE v.seed = ?1 AND s.forgotten = 0",
                     seed);
  while (others.Next()) {
    ASSIGN_OR_RETURN(const ConfigDigests other, digests_of(others));
    if (other.layout != digests.layout) continue;
    twins.of_layout.push_back(others.Int(0));
    if (other.scene == digests.scene) twins.of_scene.push_back(others.Int(0));
  }
  RETURN_IF_ERROR(others.status());
  return twins;
}

absl::StatusOr<bool> AnyHasScene(Tables& tables, const std::vector<int64_t>& variants,
                                 uint32_t ordinal) {
  for (const int64_t variant : variants) {
    ASSIGN_OR_RETURN(const bool found,
                     tables.db.Has("SELECT 1 FROM scenes WHERE variant_id = ?1 AND ordinal = ?2",
                                   variant, ordinal));
    if (found) return true;
  }
  return false;
}

// Its jobs' keys name its own result (work) and its layout's (group).
absl::Status RemoveScene(Tables& tables, int64_t variant, uint32_t ordinal,
                         const std::optional<Sha256Digest>& recipe, const Twins& twins) {
  std::set<Sha256Digest> work, group;
  {
    SqliteQuery query(tables.db,
                      "SELECT work_key, group_key FROM all_jobs WHERE variant_id = ?1"
                      " AND ordinal = ?2 AND kind IN (SELECT name FROM job_kinds WHERE of_scene)",
                      variant, ordinal);
    while (query.Next()) {
      work.insert(query.Digest(0));
      group.insert(query.Digest(1));
    }
    RETURN_IF_ERROR(query.status());
  }
  RETURN_IF_ERROR(
      tables.db.Run("DELETE FROM scenes WHERE variant_id = ?1 AND ordinal = ?2", variant, ordinal));
  ASSIGN_OR_RETURN(const bool layout_used, AnyHasScene(tables, twins.of_layout, ordinal));
  ASSIGN_OR_RETURN(const bool scene_used, AnyHasScene(tables, twins.of_scene, ordinal));
  if (recipe) {
    group.erase(*recipe);
    ASSIGN_OR_RETURN(const bool used,
                     tables.db.Has("SELECT 1 FROM scenes WHERE scene_hash = ?1 LIMIT 1", *recipe));
    if (!used && !scene_used) RETURN_IF_ERROR(tables.RemoveResult(*recipe));
  }
  if (!scene_used) {
    for (const Sha256Digest& key : work) RETURN_IF_ERROR(tables.RemoveResult(key));
  }
  if (!layout_used) {
    for (const Sha256Digest& key : group) RETURN_IF_ERROR(tables.RemoveResult(key));
  }
  return absl::OkStatus();
}

absl::StatusOr<int> RemoveScenes(Tables& tables, int64_t study, int limit) {
  struct Row {
    int64_t variant = 0;
    uint32_t ordinal = 0;
    std::optional<Sha256Digest> recipe;
  };
  SqliteQuery query(tables.db,
                    "SELECT variant_id, ordinal, scene_hash FROM scenes WHERE variant_id IN"
                    " (SELECT id FROM variants WHERE study_id = ?1) LIMIT ?2",
                    study, limit);
  ASSIGN_OR_RETURN(const std::vector<Row> rows, query.Rows([&] {
    Row row{query.Int(0), static_cast<uint32_t>(query.Int(1)), {}};
    if (!query.IsNull(2)) row.recipe = query.Digest(2);
    return row;
  }));
  std::map<int64_t, Twins> twins;
  for (const Row& row : rows) {
    if (twins.count(row.variant) == 0) {
      ASSIGN_OR_RETURN(twins[row.variant], TwinsOf(tables, row.variant));
    }
    RETURN_IF_ERROR(RemoveScene(tables, row.variant, row.ordinal, row.recipe, twins[row.variant]));
  }
  return static_cast<int>(rows.size());
}

absl::StatusOr<bool> RemoveRowsOf(Tables& tables, int64_t study, int limit) {
  tables.ledger.Forget(study);
  ASSIGN_OR_RETURN(int removed, RemoveReferences(tables, study, "frames", "frame_key", limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, RemoveReferences(tables, study, "study_results", "work_key", limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, RemoveScenes(tables, study, limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, tables.archive.Add(study, limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, tables.archive.Remove(study, limit));
  if (removed > 0) return true;
  // The newest job of all stays until there is a newer one: see JobArchive::StudyToArchive.
  ASSIGN_OR_RETURN(const bool any_job,
                   tables.db.Has("SELECT 1 FROM jobs WHERE variant_id IN"
                                 " (SELECT id FROM variants WHERE study_id = ?1) LIMIT 1",
                                 study));
  if (any_job) return false;
  for (const char* sql :
       {"DELETE FROM job_counts WHERE variant_id IN"
        " (SELECT id FROM variants WHERE study_id = ?1)",
        "DELETE FROM repairs WHERE variant_id IN"
        " (SELECT id FROM variants WHERE study_id = ?1)",
        "DELETE FROM taken_back WHERE study_id = ?1", "DELETE FROM variants WHERE study_id = ?1",
        "UPDATE studies SET forgotten = 2 WHERE id = ?1"}) {
    RETURN_IF_ERROR(tables.db.Run(sql, study));
  }
  return true;
}

}  // namespace

absl::StatusOr<v1::ForgetReply> Forgetting::Forget(int64_t id, std::string_view reason,
                                                   std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  if (!study->tally.finished && !tables_.options.unsafe_for_test.forget_unfinished) {
    return FailedPrecondition("study {} ({}) is not at its end: wait for it, or cancel it first",
                              id, study->name);
  }
  v1::ForgetReply had;
  for (const int64_t variant_id : study->variants) {
    ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(variant_id));
    had.set_pairs(had.pairs() + variant->tally.pairs_done);
    for (const auto& states : variant->tally.jobs) {
      for (const int64_t jobs : states) had.set_jobs(had.jobs() + jobs);
    }
  }
  ASSIGN_OR_RETURN(
      const auto results,
      tables_.db.Integer("SELECT count(*) FROM study_results WHERE study_id = ?1", id));
  had.set_results(results.value_or(0));
  // A study submitted again under this key is a new one. Waits name jobs that will be gone.
  RETURN_IF_ERROR(
      tables_.db.Run("UPDATE studies SET forgotten = 1, archived = 1, idempotency_key = NULL,"
                     " spec_z = x'' WHERE id = ?1",
                     id));
  RETURN_IF_ERROR(
      tables_.db.Run("DELETE FROM waits WHERE job_id IN (SELECT id FROM jobs"
                     " WHERE variant_id IN (SELECT id FROM variants WHERE study_id = ?1))",
                     id));
  RETURN_IF_ERROR(tables_.notices.SetReceiver(id, {}));
  RETURN_IF_ERROR(tables_.folders.SweepUnwanted(tables_.Now()));
  for (const int64_t variant : study->variants) tables_.hungry.erase(variant);
  RETURN_IF_ERROR(tables_.Audit(actor, "forget", id,
                                study->name + (reason.empty() ? "" : ": " + std::string(reason))));
  tables_.ledger.Change(*study).forgotten = true;
  return had;
}

absl::StatusOr<bool> Forgetting::RemoveSome(int limit) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> studies,
                   tables_.db.Integers("SELECT id FROM studies WHERE forgotten = 1 ORDER BY id"));
  for (const int64_t study : studies) {
    ASSIGN_OR_RETURN(const bool some, RemoveRowsOf(tables_, study, limit));
    if (some) return true;
  }
  return false;
}

absl::StatusOr<bool> Forgetting::Archive(int limit) {
  if (tables_.options.archive_after_s <= 0) return false;
  ASSIGN_OR_RETURN(const auto study,
                   tables_.archive.StudyToArchive(tables_.Now() - tables_.options.archive_after_s));
  if (!study) return false;
  ASSIGN_OR_RETURN(const int moved, tables_.archive.Add(*study, limit));
  tables_.effects.archived += static_cast<uint64_t>(moved);
  RETURN_IF_ERROR(tables_.folders.SweepUnwanted(tables_.Now()));
  tables_.ledger.Forget(*study);
  return true;
}

}  // namespace parallax
