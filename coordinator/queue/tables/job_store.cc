#include "coordinator/queue/tables/job_store.h"

namespace parallax {
namespace {

constexpr char kFind[] = "SELECT " PARALLAX_JOB_COLUMNS " FROM jobs WHERE id = ?1";

constexpr char kInsert[] = R"sql(
INSERT INTO jobs(study_id, variant_id, kind, ordinal, rigs, rig_count, generation, state, work_key,
                 group_key, reused, awaits_job, ready_unix_s, finished_unix_s, error, input,
                 waits_open)
VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17))sql";

// READY -> LEASED
constexpr char kMoveToLeased[] = R"sql(
UPDATE jobs SET state = 'LEASED', fence = ?2, worker = ?3, attempts = attempts + 1,
                part_given = ?4
WHERE id = ?1 AND state = 'READY')sql";

// BLOCKED, RETRY_WAIT -> READY
constexpr char kMoveToReady[] = R"sql(
UPDATE jobs SET state = 'READY', awaits_job = NULL, waits_open = 0, not_before_unix_s = NULL,
                ready_unix_s = ?2
WHERE id = ?1 AND state IN ('BLOCKED', 'RETRY_WAIT'))sql";

// READY, BLOCKED, RETRY_WAIT -> BLOCKED
constexpr char kMoveToBlocked[] = R"sql(
UPDATE jobs SET state = 'BLOCKED', awaits_job = ?2, waits_open = 0, not_before_unix_s = NULL
WHERE id = ?1 AND state IN ('READY', 'BLOCKED', 'RETRY_WAIT'))sql";

// LEASED -> SUCCEEDED, REJECTED: only the newest attempt can.
constexpr char kMoveToResult[] = R"sql(
UPDATE jobs SET state = ?3, error = ?4, finished_unix_s = ?5
WHERE id = ?1 AND state = 'LEASED' AND fence = ?2)sql";

// READY, BLOCKED, RETRY_WAIT -> SUCCEEDED, REJECTED: no attempt of its own won.
constexpr char kMoveToReused[] = R"sql(
UPDATE jobs SET state = ?2, reused = 1, fence = NULL, awaits_job = NULL, waits_open = 0,
                not_before_unix_s = NULL, error = ?3, finished_unix_s = ?4
WHERE id = ?1 AND state IN ('READY', 'BLOCKED', 'RETRY_WAIT'))sql";

// LEASED -> READY, RETRY_WAIT, FAILED, QUARANTINED
constexpr char kMoveAfterLoss[] = R"sql(
UPDATE jobs SET state = ?3, app_failures = ?4, infra_losses = ?5, not_before_unix_s = ?6,
                finished_unix_s = ?7, ready_unix_s = ?8, error = ?9
WHERE id = ?1 AND state = 'LEASED' AND fence = ?2)sql";

// any but the terminal ones -> CANCELLED
constexpr char kMoveToCancelled[] = R"sql(
UPDATE jobs SET state = 'CANCELLED', awaits_job = NULL, waits_open = 0, not_before_unix_s = NULL,
                error = ?2, finished_unix_s = ?3
WHERE id = ?1 AND state IN ('READY', 'BLOCKED', 'RETRY_WAIT', 'LEASED'))sql";

}  // namespace

absl::StatusOr<JobRow> JobRowOf(const SqliteQuery& query, const KindRegistry& kinds) {
  JobRow row;
  row.id = query.Int(0);
  row.study = query.Int(1);
  row.variant = query.Int(2);
  const std::optional<KindId> kind = kinds.Find(query.Text(3));
  const std::optional<JobState> state = JobStateOf(query.Text(8));
  if (!kind || !state) {
    return DataLoss(
        "database: job {} has kind '{}' and state '{}', which this program does not know", row.id,
        query.Text(3), query.Text(8));
  }
  row.kind = *kind;
  row.ordinal = static_cast<uint32_t>(query.Int(4));
  row.rigs = query.Text(5);
  row.rig_count = static_cast<uint32_t>(query.Int(6));
  row.generation = static_cast<int>(query.Int(7));
  row.state = *state;
  row.work_key = query.Digest(9);
  row.group_key = query.Digest(10);
  row.fence = static_cast<uint64_t>(query.Int(11));
  row.worker = query.Text(12);
  row.attempts = static_cast<int>(query.Int(13));
  row.app_failures = static_cast<int>(query.Int(14));
  row.infra_losses = static_cast<int>(query.Int(15));
  row.part_given = query.Int(16) != 0;
  row.reused = query.Int(17) != 0;
  row.awaits_job = query.Int(18);
  row.ready_unix_s = query.Real(19);
  row.error = query.Text(20);
  row.input = query.Blob(21);
  row.waits_open = query.Int(22);
  return row;
}

absl::StatusOr<std::optional<JobRow>> JobStore::OneRow(SqliteQuery& query) {
  if (!query.Next()) {
    RETURN_IF_ERROR(query.status());
    return std::optional<JobRow>();
  }
  ASSIGN_OR_RETURN(JobRow row, JobRowOf(query, kinds_));
  return std::optional<JobRow>(std::move(row));
}

absl::StatusOr<std::optional<JobRow>> JobStore::Find(int64_t id) {
  SqliteQuery query(db_, kFind, id);
  return OneRow(query);
}

absl::StatusOr<std::optional<JobRow>> JobStore::FindArchived(int64_t id) {
  SqliteQuery query(db_, "SELECT " PARALLAX_JOB_COLUMNS " FROM archived_jobs WHERE id = ?1", id);
  return OneRow(query);
}

absl::StatusOr<JobRow> JobStore::Get(int64_t id) {
  ASSIGN_OR_RETURN(std::optional<JobRow> job, Find(id));
  if (job) return *std::move(job);
  return Internal("job {}: its row is gone", id);
}

absl::Status JobStore::Insert(JobRow& row, double now) {
  const std::optional<double> finished =
      IsTerminal(row.state) ? std::optional<double>(now) : std::nullopt;
  RETURN_IF_ERROR(db_.Run(kInsert, row.study, row.variant, kinds_[row.kind].name(), row.ordinal,
                          row.rigs, row.rig_count, row.generation, NameOf(row.state), row.work_key,
                          row.group_key, row.reused, NullIfZero(row.awaits_job), now, finished,
                          row.error, SqlBlob{row.input}, row.waits_open));
  row.id = db_.last_insert_id();
  row.ready_unix_s = now;
  return absl::OkStatus();
}

absl::StatusOr<std::vector<int64_t>> JobStore::Followers(int64_t leader) {
  return db_.Integers("SELECT id FROM jobs WHERE awaits_job = ?1 AND state = 'BLOCKED' ORDER BY id",
                      leader);
}

absl::StatusOr<std::vector<int64_t>> JobStore::ReadyInGroup(const Sha256Digest& group_key) {
  return db_.Integers("SELECT id FROM jobs WHERE group_key = ?1 AND state = 'READY' ORDER BY id",
                      group_key);
}

absl::StatusOr<std::vector<JobRow>> JobStore::LeasedInGroup(const Sha256Digest& group_key) {
  SqliteQuery query(db_,
                    "SELECT " PARALLAX_JOB_COLUMNS
                    " FROM jobs WHERE group_key = ?1 AND state = 'LEASED' ORDER BY id",
                    group_key);
  std::vector<JobRow> rows;
  while (query.Next()) {
    ASSIGN_OR_RETURN(JobRow row, JobRowOf(query, kinds_));
    rows.push_back(std::move(row));
  }
  RETURN_IF_ERROR(query.status());
  return rows;
}

absl::StatusOr<std::vector<int64_t>> JobStore::LeasedBy(const std::string& worker) {
  return db_.Integers("SELECT id FROM jobs WHERE worker = ?1 AND state = 'LEASED' ORDER BY id",
                      worker);
}

absl::StatusOr<std::vector<int64_t>> JobStore::Unfinished(int64_t study, int64_t variant) {
  std::vector<int64_t> ids;
  for (const char* sql : {"SELECT id FROM jobs WHERE state = 'BLOCKED'"
                          " AND study_id = ?1 AND (?2 = 0 OR variant_id = ?2)",
                          "SELECT id FROM jobs WHERE state = 'RETRY_WAIT'"
                          " AND study_id = ?1 AND (?2 = 0 OR variant_id = ?2)",
                          "SELECT id FROM jobs WHERE state = 'READY'"
                          " AND study_id = ?1 AND (?2 = 0 OR variant_id = ?2)",
                          "SELECT id FROM jobs WHERE state = 'LEASED'"
                          " AND study_id = ?1 AND (?2 = 0 OR variant_id = ?2)"}) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> some, db_.Integers(sql, study, variant));
    ids.insert(ids.end(), some.begin(), some.end());
  }
  return ids;
}

absl::StatusOr<std::vector<int64_t>> JobStore::BackoffsDue(double now, double longest_s,
                                                           int limit) {
  // Further away than any back-off is long: the wall clock was set back.
  return db_.Integers(
      "SELECT id FROM jobs WHERE state = 'RETRY_WAIT'"
      " AND (not_before_unix_s <= ?1 OR not_before_unix_s > ?1 + ?2) LIMIT ?3",
      now, longest_s, limit);
}

absl::StatusOr<std::optional<double>> JobStore::NextBackoff() {
  SqliteQuery query(db_,
                    "SELECT not_before_unix_s FROM jobs WHERE state = 'RETRY_WAIT'"
                    " ORDER BY not_before_unix_s LIMIT 1");
  std::optional<double> next;
  if (query.Next()) next = query.Real(0);
  RETURN_IF_ERROR(query.status());
  return next;
}

absl::StatusOr<std::vector<int64_t>> JobStore::Lost(int64_t variant) {
  return db_.Integers(R"sql(
SELECT id FROM jobs AS j
WHERE variant_id = ?1 AND state IN ('FAILED', 'QUARANTINED', 'CANCELLED')
  AND NOT EXISTS (SELECT 1 FROM jobs AS newer
                  WHERE newer.variant_id = j.variant_id AND newer.ordinal = j.ordinal
                    AND newer.kind = j.kind AND newer.rigs = j.rigs
                    AND newer.generation > j.generation)
ORDER BY ordinal, id)sql",
                      variant);
}

absl::StatusOr<std::optional<JobRow>> JobStore::FindNewest(int64_t id) {
  ASSIGN_OR_RETURN(const auto newest, db_.Integer(R"sql(
SELECT n.id, n.generation FROM all_jobs AS j JOIN all_jobs AS n
  ON n.variant_id = j.variant_id AND n.ordinal = j.ordinal AND n.kind = j.kind AND n.rigs = j.rigs
WHERE j.id = ?1 ORDER BY n.generation DESC LIMIT 1)sql",
                                                  id));
  ASSIGN_OR_RETURN(std::optional<JobRow> job, Find(newest.value_or(id)));
  if (job) return job;
  return FindArchived(newest.value_or(id));
}

absl::Status JobStore::Moved(const absl::Status& status, int64_t id, JobState to) {
  RETURN_IF_ERROR(status);
  if (db_.changes() == 1) return absl::OkStatus();
  return Internal("job {}: was not where a move to {} begins", id, NameOf(to));
}

absl::Status JobStore::MoveToLeased(const JobRow& row, uint64_t fence, const std::string& worker,
                                    bool part_given) {
  return Moved(db_.Run(kMoveToLeased, row.id, fence, worker, part_given), row.id,
               JobState::kLeased);
}

absl::Status JobStore::MoveToReady(int64_t id, double now) {
  return Moved(db_.Run(kMoveToReady, id, now), id, JobState::kReady);
}

absl::Status JobStore::MoveToBlocked(int64_t id, int64_t leader) {
  return Moved(db_.Run(kMoveToBlocked, id, leader), id, JobState::kBlocked);
}

absl::Status JobStore::SetWaitsOpen(int64_t id, int64_t waits_open) {
  return Moved(db_.Run("UPDATE jobs SET waits_open = ?2 WHERE id = ?1 AND state = 'BLOCKED'", id,
                       waits_open),
               id, JobState::kBlocked);
}

absl::Status JobStore::MoveToResult(int64_t id, uint64_t fence, JobState state,
                                    const std::string& error, double now) {
  return Moved(db_.Run(kMoveToResult, id, fence, NameOf(state), error, now), id, state);
}

absl::Status JobStore::MoveToReused(int64_t id, JobState state, const std::string& error,
                                    double now) {
  return Moved(db_.Run(kMoveToReused, id, NameOf(state), error, now), id, state);
}

absl::Status JobStore::MoveAfterLoss(const JobRow& row, const LossUpdate& update, double now) {
  const std::optional<double> finished =
      IsTerminal(update.state) ? std::optional<double>(now) : std::nullopt;
  return Moved(db_.Run(kMoveAfterLoss, row.id, row.fence, NameOf(update.state), update.app_failures,
                       update.infra_losses, update.not_before_unix_s, finished, now, update.error),
               row.id, update.state);
}

absl::Status JobStore::MoveToCancelled(int64_t id, const std::string& reason, double now) {
  return Moved(db_.Run(kMoveToCancelled, id, reason, now), id, JobState::kCancelled);
}

absl::Status JobStore::SetInput(int64_t id, const std::string& input) {
  return Moved(
      db_.Run("UPDATE jobs SET input = ?2 WHERE id = ?1 AND state = 'LEASED'", id, SqlBlob{input}),
      id, JobState::kLeased);
}

absl::Status JobStore::SetKeys(int64_t id, const JobKeys& keys) {
  return Moved(db_.Run("UPDATE jobs SET work_key = ?2, group_key = ?3"
                       " WHERE id = ?1 AND state IN ('READY', 'BLOCKED')",
                       id, keys.work, keys.group),
               id, JobState::kReady);
}

absl::Status JobStore::ShrinkReady(int64_t id, const std::string& rigs, uint32_t rig_count,
                                   const Sha256Digest& work_key) {
  return Moved(db_.Run("UPDATE jobs SET rigs = ?2, rig_count = ?3, work_key = ?4"
                       " WHERE id = ?1 AND state = 'READY'",
                       id, rigs, rig_count, work_key),
               id, JobState::kReady);
}

}  // namespace parallax
