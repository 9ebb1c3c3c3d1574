#include "coordinator/queue/tables/waits.h"

namespace parallax {

absl::Status WaitTable::Load() {
  jobs_.clear();
  variants_.clear();
  SqliteQuery query(db_, "SELECT on_job, on_variant FROM waits WHERE state = 'OPEN'");
  while (query.Next()) {
    if (query.IsNull(0)) {
      variants_.insert(query.Int(1));
    } else {
      jobs_.insert(query.Int(0));
    }
  }
  return query.status();
}

absl::Status WaitTable::Insert(int64_t job, const JobWait& wait, const char* state) {
  if (wait.on_job != 0) {
    jobs_.insert(wait.on_job);
  } else {
    variants_.insert(wait.on_variant);
  }
  return db_.Run(
      "INSERT INTO waits(job_id, on_job, on_variant, pairs, state) VALUES (?1, ?2, ?3, ?4, ?5)",
      job, NullIfZero(wait.on_job), NullIfZero(wait.on_variant), NullIfZero(wait.pairs), state);
}

absl::StatusOr<std::vector<JobWait>> WaitTable::Of(int64_t job) {
  SqliteQuery query(
      db_, "SELECT on_job, on_variant, pairs FROM waits WHERE job_id = ?1 ORDER BY rowid", job);
  return query.Rows([&] { return JobWait{query.Int(0), query.Int(1), query.Int(2)}; });
}

absl::StatusOr<int64_t> WaitTable::OpenOf(int64_t job) {
  ASSIGN_OR_RETURN(
      const auto open,
      db_.Integer("SELECT count(*) FROM waits WHERE job_id = ?1 AND state = 'OPEN'", job));
  return open.value_or(0);
}

absl::StatusOr<std::vector<int64_t>> WaitTable::OnJob(int64_t job) {
  if (jobs_.count(job) == 0) return std::vector<int64_t>();
  return db_.Integers(
      "SELECT DISTINCT job_id FROM waits WHERE on_job = ?1 AND state = 'OPEN'"
      " ORDER BY job_id",
      job);
}

absl::StatusOr<std::vector<int64_t>> WaitTable::OnPairs(int64_t variant, int64_t pairs) {
  if (variants_.count(variant) == 0) return std::vector<int64_t>();
  return db_.Integers(
      "SELECT DISTINCT job_id FROM waits WHERE on_variant = ?1 AND state = 'OPEN'"
      " AND pairs <= ?2 ORDER BY job_id",
      variant, pairs);
}

absl::Status WaitTable::MeetJob(int64_t job) {
  return db_.Run("UPDATE waits SET state = 'MET' WHERE on_job = ?1 AND state = 'OPEN'", job);
}

absl::Status WaitTable::MeetPairs(int64_t variant, int64_t pairs) {
  return db_.Run(
      "UPDATE waits SET state = 'MET' WHERE on_variant = ?1 AND state = 'OPEN' AND pairs <= ?2",
      variant, pairs);
}

absl::Status WaitTable::Drop(int64_t job) {
  return db_.Run("UPDATE waits SET state = 'DROPPED' WHERE job_id = ?1 AND state = 'OPEN'", job);
}

}  // namespace parallax
