#include "coordinator/queue/tables/scene_table.h"

namespace parallax {

absl::Status SceneTable::Insert(int64_t variant, uint32_t ordinal, const SceneRow& row) {
  return db_.Run(
      "INSERT INTO scenes(variant_id, ordinal, rigs, rigs_lost, rigs_done, jobs_open, scene_hash)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
      variant, ordinal, row.rigs, row.rigs_lost, row.rigs_done, row.jobs_open, row.scene_hash);
}

absl::StatusOr<SceneRow> SceneTable::Find(int64_t variant, uint32_t ordinal) {
  SqliteQuery query(db_,
                    "SELECT rigs, rigs_lost, rigs_done, jobs_open, scene_hash FROM scenes"
                    " WHERE variant_id = ?1 AND ordinal = ?2",
                    variant, ordinal);
  if (!query.Next()) {
    RETURN_IF_ERROR(query.status());
    return NotFound("variant {}: no scene {}", variant, ordinal);
  }
  SceneRow row;
  row.rigs = static_cast<uint32_t>(query.Int(0));
  row.rigs_lost = static_cast<uint32_t>(query.Int(1));
  row.rigs_done = static_cast<uint32_t>(query.Int(2));
  row.jobs_open = static_cast<uint32_t>(query.Int(3));
  if (!query.IsNull(4)) row.scene_hash = query.Digest(4);
  return row;
}

absl::Status SceneTable::Write(int64_t variant, uint32_t ordinal, const SceneRow& row) {
  return db_.Run(
      "UPDATE scenes SET rigs = ?3, rigs_lost = ?4, rigs_done = ?5, jobs_open = ?6, scene_hash = ?7"
      " WHERE variant_id = ?1 AND ordinal = ?2",
      variant, ordinal, row.rigs, row.rigs_lost, row.rigs_done, row.jobs_open, row.scene_hash);
}

absl::StatusOr<std::optional<uint32_t>> SceneTable::HighestLiving(int64_t variant) {
  ASSIGN_OR_RETURN(const auto ordinal,
                   db_.Integer("SELECT ordinal FROM scenes WHERE variant_id = ?1"
                               " AND rigs_lost < rigs ORDER BY ordinal DESC LIMIT 1",
                               variant));
  if (!ordinal) return std::optional<uint32_t>();
  return std::optional<uint32_t>(static_cast<uint32_t>(*ordinal));
}

}  // namespace parallax
