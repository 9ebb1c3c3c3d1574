#include "coordinator/queue/readers.h"

#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <set>

#include "coordinator/queue/compress.h"
#include "coordinator/queue/database_file.h"
#include "coordinator/study/rigs.h"

namespace parallax {
namespace {

constexpr int kMostRows = 10'000;
constexpr int kProblemsShown = 10;

int Limit(int asked, int otherwise) { return asked <= 0 ? otherwise : std::min(asked, kMostRows); }

absl::Status NotFound(const std::string& what) {
  return MakeError(absl::StatusCode::kNotFound, what + ": no such");
}

// Interrupts what runs on a connection once its time is over.
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

// ---- Studies ------------------------------------------------------------------------------------
constexpr char kStudyColumns[] =
    "SELECT id, name, paused, cancelled, submitted_unix_s, finished_unix_s, "
    "archived FROM "
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
      return MakeError(absl::StatusCode::kDataLoss,
                       "database: variant " + std::to_string(query.Int(0)) +
                           " is not among those of its study " + std::to_string(study));
    }
    v1::JobCount* count = variant->second->add_jobs();
    count->set_kind(std::string(query.Text(1)));
    count->set_state(std::string(query.Text(2)));
    count->set_jobs(query.Int(3));
  }
  return query.status();
}

void AddProblemRows(SqliteQuery& query, const KindRegistry& kinds, v1::VariantStatus& status) {
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
}

absl::Status AddProblems(SqliteConnection& db, const KindRegistry& kinds, int64_t variant,
                         v1::VariantStatus& status) {
  SqliteQuery query(db,
                    "SELECT id, state, error, ordinal, kind, input FROM jobs WHERE variant_id = ?1"
                    " AND state IN ('FAILED', 'QUARANTINED')"
                    " ORDER BY finished_unix_s DESC, id DESC LIMIT ?2",
                    variant, kProblemsShown - status.problems_size());
  AddProblemRows(query, kinds, status);
  return query.status();
}

// Adds the problems of an archived study, whose jobs are in another table.
absl::Status AddArchivedProblems(SqliteConnection& db, const KindRegistry& kinds, int64_t variant,
                                 v1::VariantStatus& status) {
  SqliteQuery query(db,
                    "SELECT id, state, error, ordinal, kind, input FROM archived_jobs WHERE "
                    "variant_id = ?1"
                    " AND state IN ('FAILED', 'QUARANTINED')"
                    " ORDER BY finished_unix_s DESC, id DESC LIMIT ?2",
                    variant, kProblemsShown - status.problems_size());
  AddProblemRows(query, kinds, status);
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
    RETURN_IF_ERROR(AddProblems(db, kinds, id, *status));
    if (archived) RETURN_IF_ERROR(AddArchivedProblems(db, kinds, id, *status));
  }
  return others_lost;
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
  ASSIGN_OR_RETURN(const int64_t others_lost, AddVariants(db, kinds, study, row.Int(6) != 0));
  study.set_state(StateOf(study, row.Int(2) != 0, row.Int(3) != 0, others_lost));
  return absl::OkStatus();
}

// ---- Jobs -------------------------------------------------------------------------------------
// The log of the newest failed attempt comes along.
#define PARALLAX_LISTED_JOB_OF(table, losses)                             \
  "SELECT j.id, j.kind, j.state, v.name, j.ordinal, j.rigs, j.attempts, " \
  "j.worker, j.error, j.input, CASE WHEN j.app_failures > 0 THEN"         \
  " (SELECT l.log_tail FROM " losses                                      \
  " AS l WHERE l.job_id = j.id AND l.log_tail <> ''"                      \
  " ORDER BY l.unix_s DESC LIMIT 1) END "                                 \
  "FROM " table " AS j JOIN variants AS v ON v.id = j.variant_id "
#define PARALLAX_LISTED_JOB PARALLAX_LISTED_JOB_OF("jobs", "attempt_losses")

// Logs in one list, all together; further jobs come without theirs.
constexpr size_t kMostLogBytes = 4 << 20;

absl::Status AddJobs(SqliteQuery& query, const KindRegistry& kinds,
                     std::vector<v1::JobStatus>& jobs) {
  size_t log_bytes = 0;
  for (const v1::JobStatus& job : jobs) log_bytes += job.log_tail().size();
  while (query.Next()) {
    v1::JobStatus& job = jobs.emplace_back();
    job.set_job_id(query.Int(0));
    job.set_kind(std::string(query.Text(1)));
    job.set_state(std::string(query.Text(2)));
    job.set_variant(std::string(query.Text(3)));
    job.set_scene(static_cast<uint32_t>(query.Int(4)));
    if (const auto rigs = ParseRigs(query.Text(5)); rigs.ok()) {
      job.mutable_rigs()->Add(rigs->begin(), rigs->end());
    }
    job.set_attempts(static_cast<int>(query.Int(6)));
    job.set_worker(std::string(query.Text(7)));
    job.set_error(std::string(query.Text(8)));
    if (const auto kind = kinds.Find(query.Text(1))) {
      job.set_label(kinds[*kind].LabelOf(query.Blob(9)));
    }
    log_bytes += query.Text(10).size();
    if (log_bytes <= kMostLogBytes) job.set_log_tail(std::string(query.Text(10)));
  }
  return query.status();
}

// Adds jobs in one state, by id. Hot states have an index each; others use the variants' index.
absl::Status AddJobsOfState(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                            JobState state, int limit, std::vector<v1::JobStatus>& jobs) {
  const bool hot = !IsTerminal(state);
  // The state is spelled out, because only so is a partial index found.
  const std::string where_state = "j.state = '" + std::string(NameOf(state)) + "' ";
  const std::string sql =
      hot ? PARALLAX_LISTED_JOB "WHERE " + where_state +
                "AND j.study_id = ?1 ORDER BY j.id LIMIT ?2"
          : PARALLAX_LISTED_JOB "WHERE " + where_state +
                (state == JobState::kFailed || state == JobState::kQuarantined
                     ? "AND j.state IN ('FAILED', 'QUARANTINED') "
                     : "") +
                "AND j.variant_id IN (SELECT id FROM variants WHERE study_id = ?1) LIMIT ?2";
  SqliteQuery query(db, sql.c_str(), study, limit);
  return AddJobs(query, kinds, jobs);
}

// States in which the study has jobs: the others need no search, which for some is a long one.
absl::StatusOr<std::set<std::string, std::less<>>> StatesThere(SqliteConnection& db,
                                                               int64_t study) {
  SqliteQuery query(db,
                    "SELECT DISTINCT state FROM job_counts WHERE jobs > 0 AND variant_id IN"
                    " (SELECT id FROM variants WHERE study_id = ?1)",
                    study);
  std::set<std::string, std::less<>> states;
  while (query.Next()) states.emplace(query.Text(0));
  RETURN_IF_ERROR(query.status());
  return states;
}

// Adds jobs of an archived study in one state.
absl::Status AddArchivedJobs(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                             JobState state, int limit, std::vector<v1::JobStatus>& jobs) {
  SqliteQuery query(
      db,
      PARALLAX_LISTED_JOB_OF("archived_jobs", "archived_losses") "WHERE j.state = ?2 AND j.variant_id IN"
                           " (SELECT id FROM variants WHERE study_id = ?1) "
                           "LIMIT ?3",
      study, NameOf(state), limit);
  return AddJobs(query, kinds, jobs);
}

// ---- Frames and scenes ------------------------------------------------------------------------
absl::Status AddFrames(SqliteConnection& db, const v1::ListFramesRequest& request,
                       std::vector<v1::PublishedFrame>& frames) {
  SqliteQuery query(db,
                    "SELECT f.cursor, v.name, f.ordinal, f.reused, r.bytes FROM frames AS f"
                    " JOIN variants AS v ON v.id = f.variant_id"
                    " JOIN results AS r ON r.work_key = f.frame_key"
                    " WHERE f.study_id = ?1 AND f.cursor > ?2 ORDER BY f.cursor LIMIT ?3",
                    request.study_id(), request.cursor(), Limit(request.limit(), 1000));
  while (query.Next()) {
    v1::PublishedFrame& frame = frames.emplace_back();
    frame.set_cursor(query.Int(0));
    frame.set_variant(std::string(query.Text(1)));
    frame.set_scene(static_cast<uint32_t>(query.Int(2)));
    frame.set_reused(query.Int(3) != 0);
    RETURN_IF_ERROR(UnpackMessage(query.Blob(4), *frame.mutable_frame()));
  }
  return query.status();
}

// "ab/ab12.../.attempt-7" of "ab/ab12.../.attempt-7/003", which must be rig 3's; empty if it is
// not.
std::string FolderOfRig(const std::string& path, uint32_t rig) {
  char name[16];
  std::snprintf(name, sizeof name, "/%03u", rig);
  const size_t length = std::string_view(name).size();
  if (path.size() <= length || path.compare(path.size() - length, length, name) != 0) return "";
  return path.substr(0, path.size() - length);
}

// Frames of one attempt share its folder, so that only the first of them is unpacked.
absl::Status AddFolders(SqliteConnection& db, int64_t variant, int64_t limit,
                        std::vector<v1::FrameFolder>& folders) {
  SqliteQuery query(db,
                    "SELECT f.ordinal, f.rig, r.fence, r.bytes FROM frames AS f"
                    " JOIN results AS r ON r.work_key = f.frame_key WHERE f.variant_id = ?1"
                    " ORDER BY f.ordinal, f.rig LIMIT ?2",
                    variant, limit);
  std::pair<int64_t, int64_t> last = {-1, -1};
  while (query.Next()) {
    const uint32_t rig = static_cast<uint32_t>(query.Int(1));
    const std::pair<int64_t, int64_t> attempt = {query.Int(0), query.Int(2)};
    if (query.IsNull(2) || attempt != last) {
      v1::FrameResult frame;
      RETURN_IF_ERROR(UnpackMessage(query.Blob(3), frame));
      const std::string folder = FolderOfRig(frame.path(), rig);
      if (folder.empty()) {
        return MakeError(absl::StatusCode::kDataLoss,
                         "database: rig " + std::to_string(rig) + " of scene " +
                             std::to_string(attempt.first) + " is in '" + frame.path() + "'");
      }
      folders.emplace_back().set_folder(folder);
      folders.back().set_scene(static_cast<uint32_t>(attempt.first));
      last = attempt;
    }
    folders.back().add_rigs(rig);
  }
  return query.status();
}

class CommittedResults final : public ResultReader {
 public:
  explicit CommittedResults(Readers& readers) : readers_(readers) {}

  absl::StatusOr<std::string> ResultBytes(const Sha256Digest& key) override {
    std::string bytes;
    RETURN_IF_ERROR(readers_.Read(0, [&](SqliteConnection& db) -> absl::Status {
      SqliteQuery query(db, "SELECT bytes FROM results WHERE work_key = ?1", key);
      if (!query.Next()) {
        return query.status().ok() ? NotFound("result " + HexOf(key)) : query.status();
      }
      bytes = query.Blob(0);
      return absl::OkStatus();
    }));
    return bytes;
  }

  absl::StatusOr<std::vector<Sha256Digest>> FramesOf(int64_t variant, int64_t limit) override {
    std::vector<Sha256Digest> keys;
    RETURN_IF_ERROR(readers_.Read(0, [&](SqliteConnection& db) {
      SqliteQuery query(db,
                        "SELECT frame_key FROM frames WHERE variant_id = ?1"
                        " ORDER BY ordinal, rig LIMIT ?2",
                        variant, limit);
      while (query.Next()) keys.push_back(query.Digest(0));
      return query.status();
    }));
    return keys;
  }

  absl::StatusOr<std::vector<v1::FrameFolder>> FoldersOf(int64_t variant, int64_t limit) override {
    std::vector<v1::FrameFolder> folders;
    RETURN_IF_ERROR(readers_.Read(
        0, [&](SqliteConnection& db) { return AddFolders(db, variant, limit, folders); }));
    return folders;
  }

  absl::StatusOr<std::string> ResultWaitedFor(int64_t job) override {
    std::string bytes;
    RETURN_IF_ERROR(readers_.Read(0, [&](SqliteConnection& db) -> absl::Status {
      SqliteQuery query(db,
                        "SELECT r.bytes FROM waits AS w LEFT JOIN jobs AS j ON j.id = w.on_job"
                        " LEFT JOIN archived_jobs AS a ON a.id = w.on_job"
                        " JOIN results AS r ON r.work_key = coalesce(j.work_key, a.work_key)"
                        " WHERE w.job_id = ?1 AND w.state = 'MET' AND r.bytes IS NOT NULL",
                        job);
      if (!query.Next()) {
        return query.status().ok()
                   ? NotFound("result that job " + std::to_string(job) + " waited for")
                   : query.status();
      }
      bytes = query.Blob(0);
      return absl::OkStatus();
    }));
    return bytes;
  }

 private:
  Readers& readers_;
};

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
    if (!query.Next()) {
      return query.status().ok() ? NotFound("study " + std::to_string(id)) : query.status();
    }
    RETURN_IF_ERROR(FillStudy(db, kinds_, query, study));
    SqliteQuery spec(db, "SELECT spec_z FROM studies WHERE id = ?1", id);
    if (!spec.Next()) return spec.status();
    return UnpackMessage(spec.Blob(0), *study.mutable_spec());
  }));
  return study;
}

absl::StatusOr<std::vector<v1::StudyStatus>> Readers::ListStudies(int limit, int64_t before) {
  std::vector<v1::StudyStatus> studies;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    const std::string sql = std::string(kStudyColumns) +
                            "WHERE forgotten = 0 AND (?2 = 0 OR id < ?2) ORDER BY id DESC LIMIT ?1";
    SqliteQuery query(db, sql.c_str(), Limit(limit, 100), before);
    while (query.Next()) RETURN_IF_ERROR(FillStudy(db, kinds_, query, studies.emplace_back()));
    return query.status();
  }));
  return studies;
}

absl::StatusOr<std::vector<v1::JobStatus>> Readers::ListJobs(const v1::ListJobsRequest& request) {
  std::vector<JobState> states;
  if (request.state().empty()) {
    // States that need attention come first.
    states = {JobState::kFailed,    JobState::kQuarantined, JobState::kLeased,
              JobState::kRetryWait, JobState::kReady,       JobState::kBlocked,
              JobState::kRejected,  JobState::kCancelled,   JobState::kSucceeded};
  } else {
    const std::optional<JobState> known = JobStateOf(request.state());
    if (!known) {
      std::string all;
      for (const char* name : kJobStateNames) all += std::string(all.empty() ? "" : ", ") + name;
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "state '" + request.state() + "': wanted one of " + all);
    }
    states = {*known};
  }
  const int limit = Limit(request.limit(), 1000);
  std::vector<v1::JobStatus> jobs;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    const auto left = [&] { return limit - static_cast<int>(jobs.size()); };
    ASSIGN_OR_RETURN(const auto archived,
                     db.Integer("SELECT archived FROM studies WHERE id = ?1", request.study_id()));
    ASSIGN_OR_RETURN(const auto there, StatesThere(db, request.study_id()));
    for (const JobState state : states) {
      if (left() <= 0) break;
      if (there.find(NameOf(state)) == there.end()) continue;
      RETURN_IF_ERROR(AddJobsOfState(db, kinds_, request.study_id(), state, left(), jobs));
      if (archived.value_or(0) == 0 || left() <= 0 || !IsTerminal(state)) continue;
      RETURN_IF_ERROR(AddArchivedJobs(db, kinds_, request.study_id(), state, left(), jobs));
    }
    return absl::OkStatus();
  }));
  return jobs;
}

namespace {

const char* EndingOf(std::string_view ledger) {
  return ledger == "app" ? "failed" : ledger == "lost" ? "lost" : "returned";
}

// The attempt that holds the job or has ended it, unless it is among the lost ones.
absl::Status AddLastAttempt(SqliteConnection& db, int64_t job, v1::ListAttemptsReply& reply) {
  SqliteQuery query(db,
                    "SELECT j.fence, j.state, j.worker, j.finished_unix_s FROM all_jobs AS j"
                    " WHERE j.id = ?1 AND j.fence IS NOT NULL AND NOT EXISTS (SELECT 1"
                    " FROM all_losses AS l WHERE l.job_id = j.id AND l.fence = j.fence)",
                    job);
  if (!query.Next()) return query.status();
  v1::AttemptStatus& attempt = *reply.add_attempts();
  attempt.mutable_attempt()->set_job_id(job);
  attempt.mutable_attempt()->set_fence(static_cast<uint64_t>(query.Int(0)));
  std::string ending(query.Text(1));
  for (char& c : ending) c = static_cast<char>(std::tolower(c));
  attempt.set_ending(ending == "leased" ? "running" : ending);
  attempt.set_worker(std::string(query.Text(2)));
  attempt.set_unix_s(query.Real(3));
  return absl::OkStatus();
}

absl::Status AddLostAttempts(SqliteConnection& db, int64_t job, v1::ListAttemptsReply& reply) {
  SqliteQuery query(db,
                    "SELECT fence, ledger, worker, unix_s, error, log_tail FROM all_losses"
                    " WHERE job_id = ?1 ORDER BY fence DESC",
                    job);
  while (query.Next()) {
    v1::AttemptStatus& attempt = *reply.add_attempts();
    attempt.mutable_attempt()->set_job_id(job);
    attempt.mutable_attempt()->set_fence(static_cast<uint64_t>(query.Int(0)));
    attempt.set_ending(EndingOf(query.Text(1)));
    attempt.set_worker(std::string(query.Text(2)));
    attempt.set_unix_s(query.Real(3));
    attempt.set_error(std::string(query.Text(4)));
    attempt.set_log_tail(std::string(query.Text(5)));
  }
  return query.status();
}

}  // namespace

absl::StatusOr<v1::ListAttemptsReply> Readers::ListAttempts(int64_t job) {
  v1::ListAttemptsReply reply;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    std::vector<v1::JobStatus> jobs;
    for (const char* sql :
         {PARALLAX_LISTED_JOB "WHERE j.id = ?1",
          PARALLAX_LISTED_JOB_OF("archived_jobs", "archived_losses") "WHERE j.id = ?1"}) {
      SqliteQuery query(db, sql, job);
      RETURN_IF_ERROR(AddJobs(query, kinds_, jobs));
    }
    if (jobs.empty()) return NotFound("job " + std::to_string(job));
    *reply.mutable_job() = std::move(jobs.front());
    reply.mutable_job()->clear_log_tail();  // The attempts have theirs.
    RETURN_IF_ERROR(AddLastAttempt(db, job, reply));
    return AddLostAttempts(db, job, reply);
  }));
  return reply;
}

absl::StatusOr<std::vector<v1::PublishedFrame>> Readers::ListFrames(
    const v1::ListFramesRequest& request) {
  std::vector<v1::PublishedFrame> frames;
  RETURN_IF_ERROR(
      Read(deadline_s_, [&](SqliteConnection& db) { return AddFrames(db, request, frames); }));
  return frames;
}

absl::StatusOr<std::vector<v1::JobResult>> Readers::ListResults(
    const v1::ListResultsRequest& request) {
  std::vector<v1::JobResult> results;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    SqliteQuery query(db,
                      "SELECT s.cursor, s.job_id, coalesce(j.kind, a.kind), v.name,"
                      " coalesce(j.input, a.input), r.bytes FROM study_results AS s"
                      " LEFT JOIN jobs AS j ON j.id = s.job_id"
                      " LEFT JOIN archived_jobs AS a ON a.id = s.job_id"
                      " JOIN variants AS v ON v.id = coalesce(j.variant_id, a.variant_id)"
                      " JOIN results AS r ON r.work_key = s.work_key"
                      " WHERE s.study_id = ?1 AND s.cursor > ?2 ORDER BY s.cursor LIMIT ?3",
                      request.study_id(), request.cursor(), Limit(request.limit(), 1000));
    while (query.Next()) {
      ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(query.Text(2)));
      v1::JobResult& result = results.emplace_back();
      result.set_cursor(query.Int(0));
      result.set_job_id(query.Int(1));
      result.set_kind(std::string(query.Text(2)));
      result.set_variant(std::string(query.Text(3)));
      result.set_label(kinds_[kind].LabelOf(query.Blob(4)));
      auto folder = kinds_[kind].FolderOf(query.Blob(5));
      if (!folder) {
        return MakeError(
            absl::StatusCode::kDataLoss,
            "database: the result of job " + std::to_string(query.Int(1)) + " has no files");
      }
      result.set_path(folder->path);
      *result.mutable_files() = std::move(folder->files);
    }
    return query.status();
  }));
  return results;
}

absl::StatusOr<std::vector<RunningJob>> Readers::ListRunning(
    const std::map<int64_t, std::map<std::string, double>>& figures) {
  std::vector<RunningJob> running;
  if (figures.empty()) return running;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    for (const auto& [id, of_job] : figures) {
      SqliteQuery query(db,
                        "SELECT s.name, j.kind, j.input FROM jobs AS j"
                        " JOIN studies AS s ON s.id = j.study_id WHERE j.id = ?1",
                        id);
      if (query.Next()) {
        ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(query.Text(1)));
        running.push_back({id, std::string(query.Text(0)), kinds_[kind].name(),
                           kinds_[kind].LabelOf(query.Blob(2)), of_job});
      }
      RETURN_IF_ERROR(query.status());
    }
    return absl::OkStatus();
  }));
  return running;
}

absl::StatusOr<std::vector<std::string>> Readers::ListLitter(double before_unix_s, int limit) {
  std::vector<std::string> paths;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT path FROM litter WHERE since_unix_s <= ?1"
                      " ORDER BY since_unix_s LIMIT ?2",
                      before_unix_s, Limit(limit, 1000));
    while (query.Next()) paths.emplace_back(query.Text(0));
    return query.status();
  }));
  return paths;
}

absl::StatusOr<v1::Scene> Readers::GetScene(const v1::GetSceneRequest& request) {
  v1::Scene scene;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT r.bytes FROM variants AS v"
                      " JOIN scenes AS s ON s.variant_id = v.id AND s.ordinal = ?3"
                      " JOIN results AS r ON r.work_key = s.scene_hash"
                      " WHERE v.study_id = ?1 AND v.name = ?2",
                      request.study_id(), request.variant(), request.scene());
    if (query.Next()) return UnpackMessage(query.Blob(0), scene);
    RETURN_IF_ERROR(query.status());
    return NotFound("solved scene " + std::to_string(request.scene()) + " of variant '" +
                    request.variant() + "' of study " + std::to_string(request.study_id()));
  }));
  return scene;
}

absl::StatusOr<v1::Lease> Readers::LeaseMessage(const GrantedLease& lease) {
  v1::Lease message;
  message.mutable_attempt()->set_job_id(lease.work.job.id);
  message.mutable_attempt()->set_fence(lease.fence);
  message.set_attempt_number(lease.attempt_number);
  message.set_study(lease.study);
  message.set_variant(lease.variant);
  message.set_scene(lease.work.job.ordinal);
  const JobKind& kind = kinds_[lease.work.job.kind];
  message.set_kind(kind.name());
  message.set_label(kind.LabelOf(lease.work.job.input));
  if (kind.traits().has_output) message.set_store_prefix(StorePrefixOf(lease.work.job.work_key));
  CommittedResults results(*this);
  ASSIGN_OR_RETURN(*message.mutable_spec(), kind.Spec(lease.work, results));
  return message;
}

}  // namespace parallax
