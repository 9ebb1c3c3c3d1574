#include "coordinator/queue/reads/readers.h"

#include <fmt/core.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>

#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/reads/reader_rows.h"

namespace parallax {

int RowLimit(int asked, int otherwise) {
  return asked <= 0 ? otherwise : std::min(asked, kMostRows);
}

absl::Status NoSuch(const std::string& what) { return NotFound("{}: no such", what); }

absl::Status FirstRow(SqliteQuery& query, const std::string& what) {
  if (query.Next()) return absl::OkStatus();
  return query.status().ok() ? NoSuch(what) : query.status();
}

namespace {

constexpr int kProblemsShown = 10;
constexpr int kCommentsShown = 20;

// Interrupts a connection's query when its time is over.
class Deadline {
 public:
  Deadline(sqlite3* db, double seconds)
      : db_(db),
        end_(std::chrono::steady_clock::now() +
             std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                 std::chrono::duration<double>(seconds))) {
    if (seconds > 0) sqlite3_progress_handler(db_, 10'000, &Deadline::Over, this);
  }
  ~Deadline() { sqlite3_progress_handler(db_, 0, nullptr, nullptr); }

 private:
  static int Over(void* self) {
    return std::chrono::steady_clock::now() > static_cast<Deadline*>(self)->end_ ? 1 : 0;
  }
  sqlite3* db_;
  std::chrono::steady_clock::time_point end_;
};

// ---- Studies
constexpr char kStudyColumns[] =
    "SELECT id, name, paused, cancelled, submitted_unix_s, finished_unix_s, "
    "archived, user, max_running, priority FROM "
    "studies ";

absl::Status AddCounts(SqliteConnection& db, std::map<int64_t, v1::VariantStatus*>& variants,
                       int64_t study) {
  SqliteQuery query(db,
                    "SELECT variant_id, kind, state, jobs FROM job_counts WHERE jobs > 0 AND"
                    " variant_id IN (SELECT id FROM variants WHERE study_id = ?1)"
                    " ORDER BY variant_id, kind, state",
                    study);
  while (query.Next()) {
    const auto variant = variants.find(query.Int(0));
    if (variant == variants.end()) {
      return DataLoss("database: variant {} is not among those of its study {}", query.Int(0),
                      study);
    }
    v1::JobCount* count = variant->second->add_jobs();
    count->set_kind(std::string(query.Text(1)));
    count->set_state(std::string(query.Text(2)));
    count->set_jobs(query.Int(3));
  }
  return query.status();
}

// The jobs of an archived study are in another table.
absl::Status AddProblems(SqliteConnection& db, const KindRegistry& kinds, bool archived,
                         int64_t variant, v1::VariantStatus& status) {
  SqliteQuery query(
      db,
      archived
          ? "SELECT id, state, error, ordinal, kind, input FROM archived_jobs WHERE variant_id = ?1"
            " AND state IN ('FAILED', 'QUARANTINED')"
            " ORDER BY finished_unix_s DESC, id DESC LIMIT ?2"
          : "SELECT id, state, error, ordinal, kind, input FROM jobs WHERE variant_id = ?1"
            " AND state IN ('FAILED', 'QUARANTINED')"
            " ORDER BY finished_unix_s DESC, id DESC LIMIT ?2",
      variant, kProblemsShown - status.problems_size());
  while (query.Next()) {
    v1::JobProblem* problem = status.add_problems();
    problem->set_job_id(query.Int(0));
    problem->set_state(std::string(query.Text(1)));
    problem->set_error(std::string(query.Text(2)));
    problem->set_scene(static_cast<uint32_t>(query.Int(3)));
    const auto kind = kinds.Find(query.Text(4));
    if (!kind || kinds[*kind].traits().of_scene) continue;
    problem->set_scene(kNoScene);
    const std::string label = kinds[*kind].LabelOf(query.Blob(5));
    problem->set_error(kinds[*kind].name() + (label.empty() ? "" : " " + label) + ": " +
                       problem->error());
  }
  return query.status();
}

// Returns how many jobs outside of scenes are lost.
absl::StatusOr<int64_t> AddVariants(SqliteConnection& db, const KindRegistry& kinds,
                                    v1::StudyStatus& study, bool archived) {
  int64_t others_lost = 0;
  std::map<int64_t, v1::VariantStatus*> by_id;
  {
    SqliteQuery query(db,
                      "SELECT id, name, pairs_wanted, pairs_done, solves_reused, layouts_reused,"
                      " frames_reused, scenes_rejected, problem, others_lost FROM variants"
                      " WHERE study_id = ?1 ORDER BY id",
                      study.study_id());
    while (query.Next()) {
      v1::VariantStatus* status = study.add_variants();
      status->set_name(std::string(query.Text(1)));
      status->set_pairs_wanted(query.Int(2));
      status->set_pairs_done(query.Int(3));
      status->set_solves_reused(query.Int(4));
      status->set_layouts_reused(query.Int(5));
      status->set_frames_reused(query.Int(6));
      status->set_scenes_rejected(query.Int(7));
      if (!query.Text(8).empty()) {
        v1::JobProblem* problem = status->add_problems();
        problem->set_state("GAVE_UP");
        problem->set_error(std::string(query.Text(8)));
      }
      others_lost += query.Int(9);
      by_id[query.Int(0)] = status;
    }
    RETURN_IF_ERROR(query.status());
  }
  RETURN_IF_ERROR(AddCounts(db, by_id, study.study_id()));
  for (const auto& [id, status] : by_id) {
    RETURN_IF_ERROR(AddProblems(db, kinds, /*archived=*/false, id, *status));
    if (archived) RETURN_IF_ERROR(AddProblems(db, kinds, archived, id, *status));
  }
  return others_lost;
}

absl::Status AddComments(SqliteConnection& db, v1::StudyStatus& study) {
  SqliteQuery query(db,
                    "SELECT unix_s, actor, detail FROM audit WHERE study_id = ?1"
                    " AND action = 'comment' ORDER BY id DESC LIMIT ?2",
                    study.study_id(), kCommentsShown);
  while (query.Next()) {
    v1::StudyComment* comment = study.add_comments();
    comment->set_unix_s(query.Real(0));
    comment->set_actor(std::string(query.Text(1)));
    comment->set_text(std::string(query.Text(2)));
  }
  return query.status();
}

v1::StudyState StateOf(const v1::StudyStatus& study, bool paused, bool cancelled,
                       int64_t others_lost) {
  if (cancelled) return v1::STUDY_STATE_CANCELLED;
  if (study.finished_unix_s() > 0) {
    const bool all =
        others_lost == 0 &&
        std::all_of(study.variants().begin(), study.variants().end(),
                    [](const v1::VariantStatus& v) { return v.pairs_done() >= v.pairs_wanted(); });
    return all ? v1::STUDY_STATE_SUCCEEDED : v1::STUDY_STATE_FAILED;
  }
  return paused ? v1::STUDY_STATE_PAUSED : v1::STUDY_STATE_RUNNING;
}

absl::Status FillStudy(SqliteConnection& db, const KindRegistry& kinds, const SqliteQuery& row,
                       v1::StudyStatus& study) {
  study.set_study_id(row.Int(0));
  study.set_name(std::string(row.Text(1)));
  study.set_submitted_unix_s(row.Real(4));
  study.set_finished_unix_s(row.Real(5));
  study.set_user(std::string(row.Text(7)));
  study.set_max_running(static_cast<int32_t>(row.Int(8)));
  study.set_priority(static_cast<int32_t>(row.Int(9)));
  ASSIGN_OR_RETURN(const int64_t others_lost, AddVariants(db, kinds, study, row.Int(6) != 0));
  study.set_state(StateOf(study, row.Int(2) != 0, row.Int(3) != 0, others_lost));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Readers>> Readers::Open(const std::string& path,
                                                       const std::string& vfs, int connections,
                                                       double deadline_s,
                                                       const KindRegistry& kinds) {
  std::unique_ptr<Readers> readers(new Readers(deadline_s, kinds));
  for (int i = 0; i < std::max(1, connections); ++i) {
    ASSIGN_OR_RETURN(auto connection, OpenReader(path, vfs));
    readers->free_.push_back(std::move(connection));
  }
  return readers;
}

absl::Status Readers::Read(double deadline_s,
                           const std::function<absl::Status(SqliteConnection&)>& read) {
  std::unique_ptr<SqliteConnection> connection;
  {
    std::unique_lock lock(mutex_);
    free_one_.wait(lock, [&] { return !free_.empty(); });
    connection = std::move(free_.back());
    free_.pop_back();
  }
  absl::Status status;
  {
    const Deadline deadline(connection->raw(), deadline_s);
    status = connection->Run("BEGIN");
    if (status.ok()) status = read(*connection);
  }
  if (connection->in_transaction()) connection->Run("ROLLBACK").IgnoreError();
  {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(connection));
  }
  free_one_.notify_one();
  return status;
}

absl::StatusOr<v1::StudyStatus> Readers::GetStudy(int64_t id) {
  v1::StudyStatus study;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    // Outlives the query, whose errors quote it.
    const std::string sql = std::string(kStudyColumns) + "WHERE id = ?1 AND forgotten = 0";
    SqliteQuery query(db, sql.c_str(), id);
    RETURN_IF_ERROR(FirstRow(query, fmt::format("study {}", id)));
    RETURN_IF_ERROR(FillStudy(db, kinds_, query, study));
    RETURN_IF_ERROR(AddComments(db, study));
    SqliteQuery spec(db, "SELECT spec_z FROM studies WHERE id = ?1", id);
    if (!spec.Next()) return spec.status();
    return UnpackMessage(spec.Blob(0), *study.mutable_spec());
  }));
  return study;
}

absl::StatusOr<std::vector<v1::StudyStatus>> Readers::ListStudies(int limit, int64_t before,
                                                                  bool only_unfinished) {
  std::vector<v1::StudyStatus> studies;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    const std::string sql =
        std::string(kStudyColumns) + "WHERE forgotten = 0 AND (?2 = 0 OR id < ?2)" +
        (only_unfinished ? " AND finished_unix_s IS NULL" : "") + " ORDER BY id DESC LIMIT ?1";
    SqliteQuery query(db, sql.c_str(), RowLimit(limit, 100), before);
    while (query.Next()) RETURN_IF_ERROR(FillStudy(db, kinds_, query, studies.emplace_back()));
    return query.status();
  }));
  return studies;
}
}  // namespace parallax
