#include "coordinator/queue/tables/scene_table.h"

namespace parallax {

absl::StatusOr<SceneRow*> SceneTable::Open(int64_t variant, uint32_t ordinal, bool change) {
  if (open_.variant != variant || open_.ordinal != ordinal) {
    RETURN_IF_ERROR(Flush());
    open_.variant = 0;
    ASSIGN_OR_RETURN(open_.row, Find(variant, ordinal));
    open_.variant = variant;
    open_.ordinal = ordinal;
    open_.is_new = open_.changed = false;
  }
  open_.changed |= change;
  return &open_.row;
}

absl::Status SceneTable::Add(int64_t variant, uint32_t ordinal, uint32_t rigs) {
  RETURN_IF_ERROR(Flush());
  open_ = {.variant = variant, .ordinal = ordinal, .row = {.rigs = rigs}, .is_new = true};
  open_.changed = true;
  return absl::OkStatus();
}

absl::Status SceneTable::Flush() {
  if (open_.variant == 0 || !open_.changed) return absl::OkStatus();
  const SceneRow& row = open_.row;
  RETURN_IF_ERROR(db_.Run(
      open_.is_new ? "INSERT INTO scenes(variant_id, ordinal, rigs, rigs_lost, rigs_done,"
                     " jobs_open, scene_hash) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)"
                   : "UPDATE scenes SET rigs = ?3, rigs_lost = ?4, rigs_done = ?5, jobs_open = ?6,"
                     " scene_hash = ?7 WHERE variant_id = ?1 AND ordinal = ?2",
      open_.variant, open_.ordinal, row.rigs, row.rigs_lost, row.rigs_done, row.jobs_open,
      row.scene_hash));
  open_.is_new = open_.changed = false;
  return absl::OkStatus();
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

absl::StatusOr<std::optional<uint32_t>> SceneTable::HighestLiving(int64_t variant) {
  RETURN_IF_ERROR(Flush());
  ASSIGN_OR_RETURN(const auto ordinal,
                   db_.Integer("SELECT ordinal FROM scenes WHERE variant_id = ?1"
                               " AND rigs_lost < rigs ORDER BY ordinal DESC LIMIT 1",
                               variant));
  if (!ordinal) return std::optional<uint32_t>();
  return std::optional<uint32_t>(static_cast<uint32_t>(*ordinal));
}

}  // namespace parallax
