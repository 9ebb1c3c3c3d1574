#include "coordinator/queue/tables/loss_table.h"

namespace parallax {

#define PARALLAX_DROP_LOGS(table)                                                                  \
  "UPDATE " table " SET log_tail = '' WHERE log_tail <> '' AND fence <= (SELECT fence FROM " table \
  " WHERE log_tail <> '' ORDER BY fence DESC LIMIT 1 OFFSET ?1)"

absl::Status LossTable::Insert(const AttemptLoss& loss) {
  RETURN_IF_ERROR(db_.Run(
      "INSERT INTO attempt_losses(job_id, fence, ledger, worker, fingerprint, error, unix_s,"
      " log_tail) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
      loss.job, loss.fence, loss.ledger, loss.worker, loss.fingerprint, loss.error, loss.unix_s,
      loss.log_tail));
  if (loss.log_tail.empty()) return absl::OkStatus();
  return db_.Run(PARALLAX_DROP_LOGS("attempt_losses"), most_logs_);
}

absl::Status LossTable::DropArchivedLogs() {
  return db_.Run(PARALLAX_DROP_LOGS("archived_losses"), most_logs_);
}

#undef PARALLAX_DROP_LOGS

absl::StatusOr<bool> LossTable::WasLost(int64_t job, uint64_t fence) {
  return db_.Has("SELECT 1 FROM attempt_losses WHERE job_id = ?1 AND fence = ?2", job, fence);
}

absl::StatusOr<bool> LossTable::Has(int64_t job, uint64_t fence, const char* ledger) {
  return db_.Has(
      "SELECT 1 FROM attempt_losses"
      " WHERE job_id = ?1 AND fence = ?2 AND ledger = ?3",
      job, fence, ledger);
}

absl::StatusOr<int> LossTable::WorkersWithFingerprint(int64_t job, const std::string& fingerprint) {
  ASSIGN_OR_RETURN(const auto n,
                   db_.Integer("SELECT count(DISTINCT worker) FROM attempt_losses"
                               " WHERE job_id = ?1 AND ledger = 'app' AND fingerprint = ?2",
                               job, fingerprint));
  return static_cast<int>(n.value_or(0));
}

absl::StatusOr<bool> LossTable::AlwaysLostWithAnother(int64_t job, const std::string& worker,
                                                      double now) {
  // Some jobs of the worker that is lost now are in the ledger; others are still leased to it.
  return db_.Has(
      "WITH before AS (SELECT DISTINCT worker, unix_s FROM attempt_losses"
      "  WHERE job_id = ?1 AND ledger = 'lost' AND unix_s < ?3)"
      " SELECT 1 FROM attempt_losses other JOIN before USING (worker, unix_s)"
      " WHERE other.job_id != ?1 AND other.ledger = 'lost'"
      "  AND (EXISTS (SELECT 1 FROM attempt_losses this WHERE this.job_id = other.job_id"
      "    AND this.ledger = 'lost' AND this.worker = ?2 AND this.unix_s = ?3)"
      "   OR EXISTS (SELECT 1 FROM jobs WHERE id = other.job_id"
      "    AND state = 'LEASED' AND jobs.worker = ?2))"
      " GROUP BY other.job_id"
      " HAVING count(DISTINCT unix_s) = (SELECT count(*) FROM before) LIMIT 1",
      job, worker, now);
}

absl::Status LossTable::MoveLostToReturned(int64_t job, uint64_t fence) {
  RETURN_IF_ERROR(
      db_.Run("UPDATE attempt_losses SET ledger = 'returned'"
              " WHERE job_id = ?1 AND fence = ?2 AND ledger = 'lost'"
              " AND EXISTS (SELECT 1 FROM jobs WHERE id = ?1 AND finished_unix_s IS NULL)",
              job, fence));
  if (db_.changes() == 0) return absl::OkStatus();
  return db_.Run("UPDATE jobs SET infra_losses = infra_losses - 1 WHERE id = ?1", job);
}

}  // namespace parallax
