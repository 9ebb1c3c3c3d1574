#include "coordinator/queue/tables/job_archive.h"

namespace parallax {

absl::StatusOr<std::optional<int64_t>> JobArchive::StudyToArchive(double finished_before) {
  // The newest job stays: SQLite gives the number of a deleted newest row to the
  // next one.
  return db_.Integer(R"sql(
SELECT s.id FROM studies AS s
WHERE s.finished_unix_s < ?1 AND EXISTS (
  SELECT 1 FROM variants AS v JOIN jobs AS j ON j.variant_id = v.id
  WHERE v.study_id = s.id AND j.id < (SELECT max(id) FROM jobs) + ?2)
ORDER BY s.id LIMIT 1)sql",
                     finished_before, past_newest_);
}

absl::StatusOr<int> JobArchive::Add(int64_t study, int limit) {
  ASSIGN_OR_RETURN(
      const std::vector<int64_t> ids,
      db_.Integers("SELECT j.id FROM variants AS v JOIN jobs AS j ON j.variant_id = v.id"
                   " WHERE v.study_id = ?1 AND j.id < (SELECT max(id) FROM jobs) + ?3 LIMIT ?2",
                   study, limit, past_newest_));
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET archived = 1 WHERE id = ?1 AND archived = 0", study));
  for (const int64_t id : ids) {
    for (const char* sql :
         {"INSERT INTO archived_jobs SELECT * FROM jobs WHERE id = ?1",
          "INSERT INTO archived_losses SELECT * FROM attempt_losses WHERE job_id = ?1",
          "DELETE FROM attempt_losses WHERE job_id = ?1", "DELETE FROM waits WHERE job_id = ?1",
          "DELETE FROM jobs WHERE id = ?1"}) {
      RETURN_IF_ERROR(db_.Run(sql, id));
    }
  }
  RETURN_IF_ERROR(losses_.DropArchivedLogs());
  return static_cast<int>(ids.size());
}

// The archive has an index of variants and none of studies.
#define PARALLAX_OF_STUDY " WHERE variant_id IN (SELECT id FROM variants WHERE study_id = ?1)"

absl::Status JobArchive::Restore(int64_t study) {
  for (const char* sql : {"INSERT INTO jobs SELECT * FROM archived_jobs" PARALLAX_OF_STUDY,
                          "INSERT INTO attempt_losses SELECT * FROM archived_losses WHERE job_id IN"
                          " (SELECT id FROM archived_jobs" PARALLAX_OF_STUDY ")",
                          "DELETE FROM archived_losses WHERE job_id IN"
                          " (SELECT id FROM archived_jobs" PARALLAX_OF_STUDY ")",
                          "DELETE FROM archived_jobs" PARALLAX_OF_STUDY,
                          "UPDATE studies SET archived = 0 WHERE id = ?1"}) {
    RETURN_IF_ERROR(db_.Run(sql, study));
  }
  return absl::OkStatus();
}

#undef PARALLAX_OF_STUDY

absl::StatusOr<int> JobArchive::Remove(int64_t study, int limit) {
  ASSIGN_OR_RETURN(
      const std::vector<int64_t> ids,
      db_.Integers("SELECT a.id FROM variants AS v JOIN archived_jobs AS a ON a.variant_id = v.id"
                   " WHERE v.study_id = ?1 LIMIT ?2",
                   study, limit));
  for (const int64_t id : ids) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM archived_losses WHERE job_id = ?1", id));
    RETURN_IF_ERROR(db_.Run("DELETE FROM archived_jobs WHERE id = ?1", id));
  }
  return static_cast<int>(ids.size());
}

}  // namespace parallax
