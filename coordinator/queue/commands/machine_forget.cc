// Orders of operators: to drain workers and to forget studies.
//
// A forgotten study is gone for everybody in the transaction that says so. Its rows go later, some
// at a time: first what refers to results, and with the last reference the result itself, whose
// files become litter in the same transaction; then its jobs. A result that another study's pairs,
// networks or scenes refer to stays, whoever made it.
#include <algorithm>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/queue/database/compress.h"
#include "parallax/v1/study.pb.h"

namespace parallax {
namespace {

constexpr char kVariantsOf[] = "(SELECT id FROM variants WHERE study_id = ?1)";

}  // namespace

// ---- Workers
absl::Status Machine::Drain(const v1::DrainOrder& order, bool undo) {
  RETURN_IF_ERROR(undo ? db_.Run("DELETE FROM drains WHERE pattern = ?1", order.pattern())
                       : db_.Run("INSERT INTO drains(pattern, reason, actor, since_unix_s)"
                                 " VALUES (?1, ?2, ?3, ?4) ON CONFLICT DO UPDATE SET reason = ?2",
                                 order.pattern(), order.reason(), order.actor(), Now()));
  if (db_.changes() == 0) return NoSuchDrain(order.pattern());
  ASSIGN_OR_RETURN(std::vector<v1::DrainOrder> drains, ListDrains(db_));
  effects_.drains = std::make_shared<const std::vector<v1::DrainOrder>>(std::move(drains));
  effects_.work_ready |= undo;
  return Audit(order.actor(), undo ? "undrain" : "drain", 0,
               order.pattern() + (order.reason().empty() ? "" : ": " + order.reason()));
}

absl::Status Machine::NoSuchDrain(const std::string& pattern) {
  ASSIGN_OR_RETURN(const std::vector<v1::DrainOrder> drains, ListDrains(db_));
  std::string known;
  for (const v1::DrainOrder& drain : drains) {
    known += (known.empty() ? "" : ", ") + ("'" + drain.pattern() + "'");
  }
  return NotFound("no order to drain '{}'; {}", pattern,
                  known.empty() ? "there is none at all" : "there are " + known);
}

absl::StatusOr<std::vector<v1::DrainOrder>> ListDrains(SqliteConnection& db) {
  std::vector<v1::DrainOrder> drains;
  SqliteQuery query(db, "SELECT pattern, reason, actor, since_unix_s FROM drains ORDER BY pattern");
  while (query.Next()) {
    v1::DrainOrder& drain = drains.emplace_back();
    drain.set_pattern(std::string(query.Text(0)));
    drain.set_reason(std::string(query.Text(1)));
    drain.set_actor(std::string(query.Text(2)));
    drain.set_unix_s(query.Real(3));
  }
  RETURN_IF_ERROR(query.status());
  return drains;
}

// ---- Studies
absl::StatusOr<v1::ForgetReply> Machine::Forget(int64_t id, std::string_view reason,
                                                std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (!study->tally.finished) {
    return FailedPrecondition("study {} ({}) is not at its end: wait for it, or cancel it first",
                              id, study->name);
  }
  v1::ForgetReply had;
  for (const int64_t variant_id : study->variants) {
    ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(variant_id));
    had.set_pairs(had.pairs() + variant->tally.pairs_done);
    for (const auto& states : variant->tally.jobs) {
      for (const int64_t jobs : states) had.set_jobs(had.jobs() + jobs);
    }
  }
  ASSIGN_OR_RETURN(const auto results,
                   db_.Integer("SELECT count(*) FROM study_results WHERE study_id = ?1", id));
  had.set_results(results.value_or(0));
  // A study submitted again under this key is a new one. Waits name jobs that will be gone.
  RETURN_IF_ERROR(
      db_.Run("UPDATE studies SET forgotten = 1, archived = 1, idempotency_key = NULL,"
              " spec_z = x'' WHERE id = ?1",
              id));
  RETURN_IF_ERROR(
      db_.Run("DELETE FROM waits WHERE job_id IN (SELECT id FROM jobs"
              " WHERE variant_id IN (SELECT id FROM variants WHERE study_id = ?1))",
              id));
  RETURN_IF_ERROR(folders_.SweepUnwanted(Now()));
  for (const int64_t variant : study->variants) hungry_.erase(variant);
  RETURN_IF_ERROR(
      Audit(actor, "forget", id, study->name + (reason.empty() ? "" : ": " + std::string(reason))));
  ledger_.Change(*study).forgotten = true;
  return had;
}

absl::StatusOr<bool> Machine::RemoveForgotten(int limit) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> studies,
                   db_.Integers("SELECT id FROM studies WHERE forgotten = 1 ORDER BY id"));
  for (const int64_t study : studies) {
    ASSIGN_OR_RETURN(const bool some, RemoveSomeOf(study, limit));
    if (some) return true;
  }
  return false;
}

absl::StatusOr<bool> Machine::RemoveSomeOf(int64_t study, int limit) {
  ledger_.Forget(study);
  ASSIGN_OR_RETURN(int removed, RemoveReferences(study, "frames", "frame_key", limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, RemoveReferences(study, "study_results", "work_key", limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, RemoveScenes(study, limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, archive_.Add(study, limit));
  if (removed > 0) return true;
  ASSIGN_OR_RETURN(removed, archive_.Remove(study, limit));
  if (removed > 0) return true;
  // The newest job of all stays until there is a newer one: see JobArchive::StudyToArchive.
  const std::string any_job =
      std::string("SELECT 1 FROM jobs WHERE variant_id IN ") + kVariantsOf + " LIMIT 1";
  ASSIGN_OR_RETURN(const auto job, db_.Integer(any_job.c_str(), study));
  if (job) return false;
  RETURN_IF_ERROR(
      db_.Run("DELETE FROM job_counts WHERE variant_id IN"
              " (SELECT id FROM variants WHERE study_id = ?1)",
              study));
  RETURN_IF_ERROR(
      db_.Run("DELETE FROM repairs WHERE variant_id IN"
              " (SELECT id FROM variants WHERE study_id = ?1)",
              study));
  RETURN_IF_ERROR(db_.Run("DELETE FROM variants WHERE study_id = ?1", study));
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET forgotten = 2 WHERE id = ?1", study));
  return true;
}

// Rows of a table that refer to results by `key`, and those results that they were the last to use.
absl::StatusOr<int> Machine::RemoveReferences(int64_t study, const char* table, const char* key,
                                              int limit) {
  std::vector<std::pair<int64_t, Sha256Digest>> rows;
  {
    const std::string sql = std::string("SELECT cursor, ") + key + " FROM " + table +
                            " WHERE study_id = ?1 ORDER BY cursor LIMIT ?2";
    SqliteQuery query(db_, sql.c_str(), study, limit);
    while (query.Next()) rows.emplace_back(query.Int(0), query.Digest(1));
    RETURN_IF_ERROR(query.status());
  }
  const std::string remove = std::string("DELETE FROM ") + table + " WHERE cursor = ?1";
  for (const auto& [cursor, result] : rows) {
    RETURN_IF_ERROR(db_.Run(remove.c_str(), cursor));
    RETURN_IF_ERROR(RemoveResult(result));
  }
  return static_cast<int>(rows.size());
}

// Unless pairs or networks of a study refer to it.
absl::Status Machine::RemoveResult(const Sha256Digest& key) {
  ASSIGN_OR_RETURN(const auto used,
                   db_.Integer("SELECT 1 FROM frames WHERE frame_key = ?1 UNION ALL"
                               " SELECT 1 FROM study_results WHERE work_key = ?1 LIMIT 1",
                               key));
  if (used) return absl::OkStatus();
  std::string folder;
  {
    SqliteQuery query(db_, "SELECT stage, bytes FROM results WHERE work_key = ?1", key);
    if (!query.Next()) return query.status();
    folder = CommonFolder(kinds_.StoredFiles(query.Text(0), query.Blob(1)));
  }
  RETURN_IF_ERROR(db_.Run("DELETE FROM results WHERE work_key = ?1", key));
  return folder.empty() ? absl::OkStatus() : folders_.InsertLitter(folder, Now());
}

// Variants of living studies whose scene of some number has the same layout, or is the same.
absl::StatusOr<Machine::Twins> Machine::TwinsOf(int64_t variant) {
  Twins twins;
  const auto digests_of = [](const SqliteQuery& row) -> absl::StatusOr<ConfigDigests> {
    v1::SceneConfig config;
    RETURN_IF_ERROR(UnpackMessage(row.Blob(1), config));
    return DigestsOf(config);
  };
  SqliteQuery own(db_, "SELECT seed, config_z FROM variants WHERE id = ?1", variant);
  if (!own.Next()) return own.status();
  const int64_t seed = own.Int(0);
  ASSIGN_OR_RETURN(const ConfigDigests digests, digests_of(own));
  SqliteQuery others(db_,
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

absl::StatusOr<bool> Machine::AnyHasScene(const std::vector<int64_t>& variants, uint32_t ordinal) {
  for (const int64_t variant : variants) {
    ASSIGN_OR_RETURN(const auto found,
                     db_.Integer("SELECT 1 FROM scenes WHERE variant_id = ?1 AND ordinal = ?2",
                                 variant, ordinal));
    if (found) return true;
  }
  return false;
}

absl::StatusOr<int> Machine::RemoveScenes(int64_t study, int limit) {
  struct Row {
    int64_t variant = 0;
    uint32_t ordinal = 0;
    std::optional<Sha256Digest> recipe;
  };
  std::vector<Row> rows;
  {
    SqliteQuery query(db_,
                      "SELECT variant_id, ordinal, scene_hash FROM scenes WHERE variant_id IN"
                      " (SELECT id FROM variants WHERE study_id = ?1) LIMIT ?2",
                      study, limit);
    while (query.Next()) {
      Row& row = rows.emplace_back();
      row.variant = query.Int(0);
      row.ordinal = static_cast<uint32_t>(query.Int(1));
      if (!query.IsNull(2)) row.recipe = query.Digest(2);
    }
    RETURN_IF_ERROR(query.status());
  }
  std::map<int64_t, Twins> twins;
  for (const Row& row : rows) {
    if (twins.count(row.variant) == 0) {
      ASSIGN_OR_RETURN(twins[row.variant], TwinsOf(row.variant));
    }
    RETURN_IF_ERROR(RemoveScene(row.variant, row.ordinal, row.recipe, twins[row.variant]));
  }
  return static_cast<int>(rows.size());
}

// Its jobs' keys name its own result (work) and its layout's (group).
absl::Status Machine::RemoveScene(int64_t variant, uint32_t ordinal,
                                  const std::optional<Sha256Digest>& recipe, const Twins& twins) {
  std::set<Sha256Digest> work, group;
  {
    SqliteQuery query(db_,
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
      db_.Run("DELETE FROM scenes WHERE variant_id = ?1 AND ordinal = ?2", variant, ordinal));
  ASSIGN_OR_RETURN(const bool layout_used, AnyHasScene(twins.of_layout, ordinal));
  ASSIGN_OR_RETURN(const bool scene_used, AnyHasScene(twins.of_scene, ordinal));
  if (recipe) {
    group.erase(*recipe);
    ASSIGN_OR_RETURN(const auto used,
                     db_.Integer("SELECT 1 FROM scenes WHERE scene_hash = ?1 LIMIT 1", *recipe));
    if (!used && !scene_used) RETURN_IF_ERROR(RemoveResult(*recipe));
  }
  if (!scene_used) {
    for (const Sha256Digest& key : work) RETURN_IF_ERROR(RemoveResult(key));
  }
  if (!layout_used) {
    for (const Sha256Digest& key : group) RETURN_IF_ERROR(RemoveResult(key));
  }
  return absl::OkStatus();
}

}  // namespace parallax
