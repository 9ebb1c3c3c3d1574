#include "coordinator/queue/tables/result_table.h"

namespace parallax {

absl::StatusOr<std::optional<StoredResult>> ResultTable::Find(const Sha256Digest& key,
                                                              std::string* stage) {
  SqliteQuery query(db_, "SELECT bytes, rejected, stage FROM results WHERE work_key = ?1", key);
  std::optional<StoredResult> result;
  if (query.Next()) {
    result = StoredResult{std::string(query.Blob(0)), !query.IsNull(1), std::string(query.Text(1))};
    if (stage != nullptr) *stage = query.Text(2);
  }
  RETURN_IF_ERROR(query.status());
  return result;
}

absl::StatusOr<bool> ResultTable::Has(const Sha256Digest& key) {
  return db_.Has("SELECT 1 FROM results WHERE work_key = ?1", key);
}

absl::StatusOr<bool> ResultTable::Insert(const Sha256Digest& key, std::string_view stage,
                                         const StoredResult& result, int64_t job, uint64_t fence) {
  RETURN_IF_ERROR(db_.Run(
      "INSERT INTO results(work_key, stage, bytes, rejected, job_id, fence, core_s)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) ON CONFLICT DO NOTHING",
      key, stage, result.rejected ? std::nullopt : std::optional<SqlBlob>(SqlBlob{result.bytes}),
      result.rejected ? std::optional<std::string>(result.reason) : std::nullopt, job, fence,
      result.core_s));
  return db_.changes() == 1;
}

absl::Status ResultTable::InsertFrame(const JobFacts& scene_of, const FrameLink& frame) {
  // The cursor of a pair that was taken back is not given again: who follows has passed it.
  return db_.Run(
      "INSERT INTO frames(cursor, study_id, variant_id, ordinal, rig, frame_key, reused) VALUES ("
      "CASE WHEN EXISTS (SELECT 1 FROM repairs) THEN 1 + max((SELECT max(cursor) FROM repairs),"
      " (SELECT coalesce(max(cursor), 0) FROM frames)) END, ?1, ?2, ?3, ?4, ?5, ?6)",
      scene_of.study, scene_of.variant, scene_of.ordinal, frame.rig, frame.key, frame.reused);
}

absl::Status ResultTable::InsertStudyResult(const JobFacts& job) {
  return db_.Run("INSERT INTO study_results(study_id, job_id, work_key) VALUES (?1, ?2, ?3)",
                 job.study, job.id, job.work_key);
}

}  // namespace parallax
