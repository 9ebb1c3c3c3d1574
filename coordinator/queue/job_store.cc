#include "coordinator/queue/job_store.h"

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

int64_t Signed(uint64_t fence) { return static_cast<int64_t>(fence); }

std::optional<int64_t> NullIfZero(int64_t value) {
  return value == 0 ? std::nullopt : std::optional<int64_t>(value);
}

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
        "database: job {} is of kind '{}' in state '{}', which this program does not know", row.id,
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

// ---- Jobs ---------------------------------------------------------------------------------------
absl::StatusOr<std::optional<JobRow>> JobStore::Find(int64_t id) {
  SqliteQuery query(db_, kFind, id);
  return OneRow(query);
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

absl::StatusOr<std::vector<int64_t>> JobStore::Ids(SqliteQuery& query) {
  std::vector<int64_t> ids;
  while (query.Next()) ids.push_back(query.Int(0));
  RETURN_IF_ERROR(query.status());
  return ids;
}

absl::StatusOr<std::vector<int64_t>> JobStore::Followers(int64_t leader) {
  SqliteQuery query(
      db_, "SELECT id FROM jobs WHERE awaits_job = ?1 AND state = 'BLOCKED' ORDER BY id", leader);
  return Ids(query);
}

absl::StatusOr<std::vector<int64_t>> JobStore::ReadyInGroup(const Sha256Digest& group_key) {
  SqliteQuery query(db_, "SELECT id FROM jobs WHERE group_key = ?1 AND state = 'READY' ORDER BY id",
                    group_key);
  return Ids(query);
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
  SqliteQuery query(db_, "SELECT id FROM jobs WHERE worker = ?1 AND state = 'LEASED' ORDER BY id",
                    worker);
  return Ids(query);
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
    SqliteQuery query(db_, sql, study, variant);
    ASSIGN_OR_RETURN(const std::vector<int64_t> some, Ids(query));
    ids.insert(ids.end(), some.begin(), some.end());
  }
  return ids;
}

absl::StatusOr<std::vector<int64_t>> JobStore::BackoffsDue(double now, double longest_s,
                                                           int limit) {
  // Further away than any back-off is long: the wall clock was set back.
  SqliteQuery query(db_,
                    "SELECT id FROM jobs WHERE state = 'RETRY_WAIT'"
                    " AND (not_before_unix_s <= ?1 OR not_before_unix_s > ?1 + ?2) LIMIT ?3",
                    now, longest_s, limit);
  return Ids(query);
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
  SqliteQuery query(db_, R"sql(
SELECT id FROM jobs AS j
WHERE variant_id = ?1 AND state IN ('FAILED', 'QUARANTINED', 'CANCELLED')
  AND NOT EXISTS (SELECT 1 FROM jobs AS newer
                  WHERE newer.variant_id = j.variant_id AND newer.ordinal = j.ordinal
                    AND newer.kind = j.kind AND newer.rigs = j.rigs
                    AND newer.generation > j.generation)
ORDER BY ordinal, id)sql",
                    variant);
  return Ids(query);
}

absl::StatusOr<std::optional<JobRow>> JobStore::FindNewest(int64_t id) {
  ASSIGN_OR_RETURN(const auto newest, db_.Integer(R"sql(
SELECT n.id FROM all_jobs AS j JOIN all_jobs AS n
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
  return Moved(db_.Run(kMoveToLeased, row.id, Signed(fence), worker, part_given), row.id,
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
  return Moved(db_.Run(kMoveToResult, id, Signed(fence), NameOf(state), error, now), id, state);
}

absl::Status JobStore::MoveToReused(int64_t id, JobState state, const std::string& error,
                                    double now) {
  return Moved(db_.Run(kMoveToReused, id, NameOf(state), error, now), id, state);
}

absl::Status JobStore::MoveAfterLoss(const JobRow& row, const LossUpdate& update, double now) {
  const std::optional<double> finished =
      IsTerminal(update.state) ? std::optional<double>(now) : std::nullopt;
  return Moved(
      db_.Run(kMoveAfterLoss, row.id, Signed(row.fence), NameOf(update.state), update.app_failures,
              update.infra_losses, update.not_before_unix_s, finished, now, update.error),
      row.id, update.state);
}

absl::Status JobStore::MoveToCancelled(int64_t id, const std::string& reason, double now) {
  return Moved(db_.Run(kMoveToCancelled, id, reason, now), id, JobState::kCancelled);
}

absl::Status JobStore::ShrinkReady(int64_t id, const std::string& rigs, uint32_t rig_count,
                                   const Sha256Digest& work_key) {
  return Moved(db_.Run("UPDATE jobs SET rigs = ?2, rig_count = ?3, work_key = ?4"
                       " WHERE id = ?1 AND state = 'READY'",
                       id, rigs, rig_count, work_key),
               id, JobState::kReady);
}

absl::Status JobStore::InsertLoss(int64_t job, uint64_t fence, const char* ledger,
                                  const std::string& worker, const std::string& fingerprint,
                                  const std::string& error, double now,
                                  const std::string& log_tail) {
  RETURN_IF_ERROR(db_.Run(
      "INSERT INTO attempt_losses(job_id, fence, ledger, worker, fingerprint, error, unix_s,"
      " log_tail) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
      job, Signed(fence), ledger, worker, fingerprint, error, now, log_tail));
  if (log_tail.empty()) return absl::OkStatus();
#define PARALLAX_DROP_LOGS(table)                                                                  \
  "UPDATE " table " SET log_tail = '' WHERE log_tail <> '' AND fence <= (SELECT fence FROM " table \
  " WHERE log_tail <> '' ORDER BY fence DESC LIMIT 1 OFFSET ?1)"
  return db_.Run(PARALLAX_DROP_LOGS("attempt_losses"), most_logs_);
}

absl::StatusOr<bool> JobStore::WasLost(int64_t job, uint64_t fence) {
  ASSIGN_OR_RETURN(const auto found,
                   db_.Integer("SELECT 1 FROM attempt_losses WHERE job_id = ?1 AND fence = ?2", job,
                               Signed(fence)));
  return found.has_value();
}

absl::StatusOr<bool> JobStore::HasLoss(int64_t job, uint64_t fence, const char* ledger) {
  ASSIGN_OR_RETURN(const auto found,
                   db_.Integer("SELECT 1 FROM attempt_losses"
                               " WHERE job_id = ?1 AND fence = ?2 AND ledger = ?3",
                               job, Signed(fence), ledger));
  return found.has_value();
}

absl::StatusOr<int> JobStore::WorkersWithFingerprint(int64_t job, const std::string& fingerprint) {
  ASSIGN_OR_RETURN(const auto n,
                   db_.Integer("SELECT count(DISTINCT worker) FROM attempt_losses"
                               " WHERE job_id = ?1 AND ledger = 'app' AND fingerprint = ?2",
                               job, fingerprint));
  return static_cast<int>(n.value_or(0));
}

absl::StatusOr<int> JobStore::WorkersLost(int64_t job) {
  ASSIGN_OR_RETURN(const auto n, db_.Integer("SELECT count(DISTINCT worker) FROM attempt_losses"
                                             " WHERE job_id = ?1 AND ledger = 'lost'",
                                             job));
  return static_cast<int>(n.value_or(0));
}

absl::StatusOr<bool> JobStore::WorkersLostWithout(int64_t job) {
  // All jobs that a worker lost at one time count as one loss of the worker.
  ASSIGN_OR_RETURN(
      const auto found,
      db_.Integer("SELECT 1 FROM attempt_losses WHERE ledger = 'lost' AND unix_s >="
                  " (SELECT min(unix_s) FROM attempt_losses WHERE job_id = ?1 AND ledger = 'lost')"
                  " AND (worker, unix_s) NOT IN (SELECT worker, unix_s FROM attempt_losses"
                  " WHERE job_id = ?1 AND ledger = 'lost') LIMIT 1",
                  job));
  return found.has_value();
}

absl::StatusOr<bool> JobStore::AlwaysLostWithAnother(int64_t job, const std::string& worker,
                                                     double now) {
  // Some jobs of the worker that is lost now are in the ledger; others are still leased to it.
  ASSIGN_OR_RETURN(
      const auto found,
      db_.Integer(
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
          job, worker, now));
  return found.has_value();
}

absl::Status JobStore::MoveLostToReturned(int64_t job, uint64_t fence) {
  return db_.Run(
      "UPDATE attempt_losses SET ledger = 'returned'"
      " WHERE job_id = ?1 AND fence = ?2 AND ledger = 'lost'",
      job, Signed(fence));
}

// ---- Scenes -----------------------------------------------------------------------------------
absl::Status JobStore::InsertScene(int64_t variant, uint32_t ordinal, const SceneRow& row) {
  return db_.Run(
      "INSERT INTO scenes(variant_id, ordinal, rigs, rigs_lost, "
      "rigs_done, jobs_open, scene_hash)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
      variant, ordinal, row.rigs, row.rigs_lost, row.rigs_done, row.jobs_open, row.scene_hash);
}

absl::StatusOr<SceneRow> JobStore::FindScene(int64_t variant, uint32_t ordinal) {
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

absl::Status JobStore::WriteScene(int64_t variant, uint32_t ordinal, const SceneRow& row) {
  return db_.Run(
      "UPDATE scenes SET rigs = ?3, rigs_lost = ?4, rigs_done = ?5, jobs_open = ?6, scene_hash = ?7"
      " WHERE variant_id = ?1 AND ordinal = ?2",
      variant, ordinal, row.rigs, row.rigs_lost, row.rigs_done, row.jobs_open, row.scene_hash);
}

absl::StatusOr<std::optional<uint32_t>> JobStore::HighestLiving(int64_t variant) {
  ASSIGN_OR_RETURN(const auto ordinal,
                   db_.Integer("SELECT ordinal FROM scenes WHERE variant_id = ?1"
                               " AND rigs_lost < rigs ORDER BY ordinal DESC LIMIT 1",
                               variant));
  if (!ordinal) return std::optional<uint32_t>();
  return std::optional<uint32_t>(static_cast<uint32_t>(*ordinal));
}

// ---- Results ------------------------------------------------------------------------------------
absl::StatusOr<std::optional<StoredResult>> JobStore::FindResult(const Sha256Digest& key) {
  SqliteQuery query(db_, "SELECT bytes, rejected FROM results WHERE work_key = ?1", key);
  std::optional<StoredResult> result;
  if (query.Next()) {
    result = StoredResult{std::string(query.Blob(0)), !query.IsNull(1), std::string(query.Text(1))};
  }
  RETURN_IF_ERROR(query.status());
  return result;
}

absl::StatusOr<bool> JobStore::HasResult(const Sha256Digest& key) {
  ASSIGN_OR_RETURN(const auto found, db_.Integer("SELECT 1 FROM results WHERE work_key = ?1", key));
  return found.has_value();
}

absl::StatusOr<bool> JobStore::InsertResult(const Sha256Digest& key, std::string_view stage,
                                            const StoredResult& result, int64_t job,
                                            uint64_t fence) {
  RETURN_IF_ERROR(db_.Run(
      "INSERT INTO results(work_key, stage, bytes, rejected, job_id, fence)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO NOTHING",
      key, stage, result.rejected ? std::nullopt : std::optional<SqlBlob>(SqlBlob{result.bytes}),
      result.rejected ? std::optional<std::string>(result.reason) : std::nullopt, job,
      Signed(fence)));
  return db_.changes() == 1;
}

absl::Status JobStore::InsertFrame(const JobFacts& scene_of, uint32_t rig,
                                   const Sha256Digest& frame_key, bool reused) {
  return db_.Run(
      "INSERT INTO frames(study_id, variant_id, ordinal, rig, frame_key, reused)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
      scene_of.study, scene_of.variant, scene_of.ordinal, rig, frame_key, reused);
}

absl::Status JobStore::InsertStudyResult(const JobRow& job) {
  return db_.Run("INSERT INTO study_results(study_id, job_id, work_key) VALUES (?1, ?2, ?3)",
                 job.study, job.id, job.work_key);
}

// ---- Litter and archive -----------------------------------------------------------------------
absl::Status JobStore::InsertLitter(const std::string& path, double now) {
  return db_.Run(
      "INSERT INTO litter(path, since_unix_s) VALUES (?1, ?2) ON "
      "CONFLICT DO NOTHING",
      path, now);
}

absl::Status JobStore::DeleteLitter(const std::string& path) {
  return db_.Run("DELETE FROM litter WHERE path = ?1", path);
}

absl::Status JobStore::InsertKept(const std::string& path, const Sha256Digest& keep_key,
                                  const std::optional<KeptFor>& scene, double now) {
  return db_.Run(
      "INSERT INTO kept_folders(path, work_key, since_unix_s, variant_id, ordinal)"
      " VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT DO NOTHING",
      path, keep_key, now, scene ? std::optional<int64_t>(scene->variant) : std::nullopt,
      scene ? std::optional<int64_t>(scene->ordinal) : std::nullopt);
}

absl::StatusOr<std::vector<std::string>> JobStore::KeptFolders(const Sha256Digest& keep_key,
                                                               int limit) {
  SqliteQuery query(db_,
                    "SELECT path FROM kept_folders WHERE work_key = ?1"
                    " ORDER BY since_unix_s DESC, path DESC LIMIT ?2",
                    keep_key, limit);
  std::vector<std::string> paths;
  while (query.Next()) paths.emplace_back(query.Text(0));
  RETURN_IF_ERROR(query.status());
  return paths;
}

absl::StatusOr<bool> JobStore::IsKept(const std::string& path) {
  ASSIGN_OR_RETURN(const auto found,
                   db_.Integer("SELECT 1 FROM kept_folders WHERE path = ?1", path));
  return found.has_value();
}

absl::Status JobStore::SweepDone(const Sha256Digest& work_key, double now) {
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?2 FROM kept_folders"
              " WHERE work_key = ?1 ON CONFLICT DO NOTHING",
              work_key, now));
  return db_.Run("DELETE FROM kept_folders WHERE work_key = ?1", work_key);
}

absl::Status JobStore::SweepScene(const KeptFor& scene, double now) {
  ASSIGN_OR_RETURN(
      const auto any,
      db_.Integer("SELECT 1 FROM kept_folders WHERE variant_id = ?1 AND ordinal = ?2 LIMIT 1",
                  scene.variant, scene.ordinal));
  if (!any) return absl::OkStatus();
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?3 FROM kept_folders"
              " WHERE variant_id = ?1 AND ordinal = ?2 ON CONFLICT DO NOTHING",
              scene.variant, scene.ordinal, now));
  return db_.Run("DELETE FROM kept_folders WHERE variant_id = ?1 AND ordinal = ?2", scene.variant,
                 scene.ordinal);
}

absl::Status JobStore::SweepUnwanted(double now) {
#define PARALLAX_UNWANTED                                                            \
  "variant_id IS NULL AND"                                                           \
  " NOT EXISTS (SELECT 1 FROM jobs AS j JOIN studies AS s ON s.id = j.study_id"      \
  " WHERE j.work_key = kept_folders.work_key AND j.input <> x'' AND s.cancelled = 0" \
  " AND s.archived = 0)"
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?1 FROM kept_folders"
              " WHERE " PARALLAX_UNWANTED " ON CONFLICT DO NOTHING",
              now));
  return db_.Run("DELETE FROM kept_folders WHERE " PARALLAX_UNWANTED);
#undef PARALLAX_UNWANTED
}

absl::StatusOr<std::optional<int64_t>> JobStore::StudyToArchive(double finished_before) {
  // The newest job stays: SQLite gives the number of a deleted newest row to
  // the next one.
  return db_.Integer(R"sql(
SELECT s.id FROM studies AS s
WHERE s.finished_unix_s < ?1 AND EXISTS (
  SELECT 1 FROM variants AS v JOIN jobs AS j ON j.variant_id = v.id
  WHERE v.study_id = s.id AND j.id < (SELECT max(id) FROM jobs))
ORDER BY s.id LIMIT 1)sql",
                     finished_before);
}

absl::StatusOr<int> JobStore::ArchiveJobs(int64_t study, int limit) {
  std::vector<int64_t> ids;
  {
    SqliteQuery query(db_,
                      "SELECT j.id FROM variants AS v JOIN jobs AS j ON j.variant_id = v.id"
                      " WHERE v.study_id = ?1 AND j.id < (SELECT max(id) FROM jobs) LIMIT ?2",
                      study, limit);
    ASSIGN_OR_RETURN(ids, Ids(query));
  }
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET archived = 1 WHERE id = ?1 AND archived = 0", study));
  for (const int64_t id : ids) {
    for (const char* sql :
         {"INSERT INTO archived_jobs SELECT * FROM jobs WHERE id = ?1",
          "INSERT INTO archived_losses SELECT * FROM attempt_losses WHERE "
          "job_id = ?1",
          "DELETE FROM attempt_losses WHERE job_id = ?1", "DELETE FROM waits WHERE job_id = ?1",
          "DELETE FROM jobs WHERE id = ?1"}) {
      RETURN_IF_ERROR(db_.Run(sql, id));
    }
  }
  RETURN_IF_ERROR(db_.Run(PARALLAX_DROP_LOGS("archived_losses"), most_logs_));
#undef PARALLAX_DROP_LOGS
  return static_cast<int>(ids.size());
}

absl::StatusOr<int> JobStore::RemoveArchivedJobs(int64_t study, int limit) {
  std::vector<int64_t> ids;
  {
    SqliteQuery query(
        db_,
        "SELECT a.id FROM variants AS v JOIN archived_jobs AS a ON a.variant_id = v.id"
        " WHERE v.study_id = ?1 LIMIT ?2",
        study, limit);
    ASSIGN_OR_RETURN(ids, Ids(query));
  }
  for (const int64_t id : ids) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM archived_losses WHERE job_id = ?1", id));
    RETURN_IF_ERROR(db_.Run("DELETE FROM archived_jobs WHERE id = ?1", id));
  }
  return static_cast<int>(ids.size());
}

absl::StatusOr<std::optional<JobRow>> JobStore::FindArchived(int64_t id) {
  SqliteQuery query(db_, "SELECT " PARALLAX_JOB_COLUMNS " FROM archived_jobs WHERE id = ?1", id);
  return OneRow(query);
}

absl::Status JobStore::Audit(double now, std::string_view actor, std::string_view action,
                             int64_t study, std::string_view detail) {
  return db_.Run(
      "INSERT INTO audit(unix_s, actor, action, study_id, detail) VALUES (?1, ?2, ?3, ?4, ?5)", now,
      actor, action, NullIfZero(study), detail);
}

}  // namespace parallax
