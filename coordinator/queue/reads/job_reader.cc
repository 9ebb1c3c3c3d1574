// Reads jobs for clients and the page: lists by state, attempts, running jobs.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/base/status.h"
#include "coordinator/queue/reads/reader_rows.h"
#include "coordinator/queue/reads/readers.h"
#include "coordinator/queue/ready_key.h"
#include "coordinator/study/rigs.h"

namespace parallax {
namespace {

// A row of jobs, with the log of the newest failed attempt.
#define PARALLAX_LISTED_JOB_OF(table, losses)                              \
  "SELECT j.id, j.kind, j.state, v.name, j.ordinal, j.rigs, j.attempts, "  \
  "j.worker, j.error, j.input, CASE WHEN j.app_failures > 0 THEN"          \
  " (SELECT l.log_tail FROM " losses                                       \
  " AS l WHERE l.job_id = j.id AND l.log_tail <> ''"                       \
  " ORDER BY l.unix_s DESC LIMIT 1) END, s.needs_memory_mb, s.needs_tags " \
  "FROM " table                                                            \
  " AS j JOIN variants AS v ON v.id = j.variant_id JOIN studies AS s ON s.id = v.study_id "
#define PARALLAX_LISTED_JOB PARALLAX_LISTED_JOB_OF("jobs", "attempt_losses")

// Bound on all logs in one list; jobs beyond it come without their logs.
constexpr size_t kMostLogBytes = 4 << 20;

void SetNeeds(const SqliteQuery& query, const JobKind& kind, v1::JobStatus& job) {
  const WorkNeeds of_study{query.Int(11), TagLines(query.Text(12))};
  const ReadyKey key = ReadyKeyOf(0, of_study, kind, kind.NeedsOf(query.Blob(9)));
  job.set_needs_memory_mb(key.memory_mb);
  job.mutable_needs_tags()->Add(key.tags.begin(), key.tags.end());
}

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
      if (query.Text(2) == NameOf(JobState::kReady)) SetNeeds(query, kinds[*kind], job);
    }
    log_bytes += query.Text(10).size();
    if (log_bytes <= kMostLogBytes) job.set_log_tail(std::string(query.Text(10)));
  }
  return query.status();
}

// Where a list goes on: behind this job, whose place among others of its state never changes.
struct JobPlace {
  int64_t id = 0;  // 0: at the beginning.
  bool archived = false;
  int64_t variant = 0, ordinal = -1, generation = 0;
  std::string kind, rigs;
  double finished_unix_s = 0;
};

absl::StatusOr<JobPlace> BeginningOf(SqliteConnection& db, int64_t study) {
  JobPlace place;
  ASSIGN_OR_RETURN(const auto first,
                   db.Integer("SELECT min(id) FROM variants WHERE study_id = ?1", study));
  place.variant = first.value_or(0);
  return place;
}

absl::StatusOr<JobPlace> PlaceBehind(SqliteConnection& db, int64_t job) {
  for (const char* table : {"jobs", "archived_jobs"}) {
    const std::string sql = std::string(
                                "SELECT variant_id, ordinal, generation, kind, rigs,"
                                " finished_unix_s FROM ") +
                            table + " WHERE id = ?1";
    SqliteQuery query(db, sql.c_str(), job);
    if (query.Next()) {
      return JobPlace{job,
                      std::string_view(table) != "jobs",
                      query.Int(0),
                      query.Int(1),
                      query.Int(2),
                      std::string(query.Text(3)),
                      std::string(query.Text(4)),
                      query.Real(5)};
    }
    RETURN_IF_ERROR(query.status());
  }
  return NoSuch(fmt::format("job {}, behind which the list is to go on", job));
}

// A study's variants have ids in a row: it was submitted in one transaction.
// Where they begin says the place.
#define PARALLAX_OF_STUDY \
  "j.study_id = ?1 AND j.variant_id <= (SELECT max(id) FROM variants WHERE study_id = ?1) "

// Adds the jobs of one state behind a place. Jobs that have not ended come by id, from indexes of
// their own; failed ones by variant and time; others by variant and scene.
absl::Status AddJobsOfState(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                            JobState state, const JobPlace& after, int limit,
                            std::vector<v1::JobStatus>& jobs) {
  // The state is written into the SQL, because SQLite then finds the partial index.
  const std::string select =
      PARALLAX_LISTED_JOB "WHERE j.state = '" + std::string(NameOf(state)) + "' AND ";
  if (!IsTerminal(state)) {
    const std::string sql = select + "j.study_id = ?1 AND j.id > ?3 ORDER BY j.id LIMIT ?2";
    SqliteQuery query(db, sql.c_str(), study, limit, after.id);
    return AddJobs(query, kinds, jobs);
  }
  if (state == JobState::kFailed || state == JobState::kQuarantined) {
    const std::string sql = select + "j.state IN ('FAILED', 'QUARANTINED') AND " PARALLAX_OF_STUDY
                                     "AND (j.variant_id, j.finished_unix_s, j.id) > (?3, ?4, ?5)"
                                     " ORDER BY j.variant_id, j.finished_unix_s, j.id LIMIT ?2";
    SqliteQuery query(db, sql.c_str(), study, limit, after.variant, after.finished_unix_s,
                      after.id);
    return AddJobs(query, kinds, jobs);
  }
  const std::string sql =
      select + PARALLAX_OF_STUDY
      "AND (j.variant_id, j.ordinal, j.kind, j.rigs, j.generation) > (?3, ?4, ?5, ?6, ?7)"
      " ORDER BY j.variant_id, j.ordinal, j.kind, j.rigs, j.generation LIMIT ?2";
  SqliteQuery query(db, sql.c_str(), study, limit, after.variant, after.ordinal, after.kind,
                    after.rigs, after.generation);
  return AddJobs(query, kinds, jobs);
}

// Returns the states in which the study has jobs: some of the others would take a long search.
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

// The same for an archived study, by variant and scene.
absl::Status AddArchivedJobs(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                             JobState state, const JobPlace& after, int limit,
                             std::vector<v1::JobStatus>& jobs) {
  SqliteQuery query(
      db,
      PARALLAX_LISTED_JOB_OF("archived_jobs",
                             "archived_losses") "WHERE j.state = ?3 AND " PARALLAX_OF_STUDY
                                                "AND (j.variant_id, j.ordinal, j.id) > (?4, ?5, ?6)"
                                                " ORDER BY j.variant_id, j.ordinal, j.id LIMIT ?2",
      study, limit, NameOf(state), after.variant, after.ordinal, after.id);
  return AddJobs(query, kinds, jobs);
}

// The states that a list goes through, in order. Errors: kInvalidArgument for one that there is
// not.
absl::StatusOr<JobState> ListedState(const std::string& name) {
  const std::optional<JobState> known = JobStateOf(name);
  if (known) return *known;
  std::string all;
  for (const char* one : kJobStateNames) all += std::string(all.empty() ? "" : ", ") + one;
  return InvalidArgument("state '{}': wanted one of {}", name, all);
}

absl::StatusOr<std::vector<JobState>> ListedStates(const v1::ListJobsRequest& request) {
  // Jobs that need a look come first.
  std::vector<JobState> states = {
      JobState::kFailed,    JobState::kQuarantined, JobState::kLeased,
      JobState::kRetryWait, JobState::kReady,       JobState::kBlocked,
      JobState::kRejected,  JobState::kCancelled,   JobState::kSucceeded};
  if (!request.state().empty()) {
    ASSIGN_OR_RETURN(const JobState only, ListedState(request.state()));
    states = {only};
  }
  if (request.after_job() == 0) return states;
  ASSIGN_OR_RETURN(const JobState after, ListedState(request.after_state()));
  const auto at = std::find(states.begin(), states.end(), after);
  if (at == states.end()) {
    return InvalidArgument(
        "the page before ended with a job in state {}, which is not in a list of {}",
        request.after_state(), request.state());
  }
  states.erase(states.begin(), at);
  return states;
}

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

absl::StatusOr<std::vector<v1::JobStatus>> Readers::ListJobs(const v1::ListJobsRequest& request) {
  ASSIGN_OR_RETURN(const std::vector<JobState> states, ListedStates(request));
  const int limit = RowLimit(request.limit(), 1000);
  std::vector<v1::JobStatus> jobs;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    const auto left = [&] { return limit - static_cast<int>(jobs.size()); };
    ASSIGN_OR_RETURN(const auto archived,
                     db.Integer("SELECT archived FROM studies WHERE id = ?1", request.study_id()));
    ASSIGN_OR_RETURN(const auto there, StatesThere(db, request.study_id()));
    ASSIGN_OR_RETURN(const JobPlace beginning, BeginningOf(db, request.study_id()));
    JobPlace after = beginning;
    if (request.after_job() != 0) {
      ASSIGN_OR_RETURN(after, PlaceBehind(db, request.after_job()));
    }
    for (const JobState state : states) {
      if (left() <= 0) break;
      const JobPlace begin = std::exchange(after, beginning);
      if (there.find(NameOf(state)) == there.end()) continue;
      if (!begin.archived) {
        RETURN_IF_ERROR(AddJobsOfState(db, kinds_, request.study_id(), state, begin, left(), jobs));
      }
      if (archived.value_or(0) == 0 || left() <= 0 || !IsTerminal(state)) continue;
      const JobPlace in_archive = begin.archived ? begin : beginning;
      RETURN_IF_ERROR(
          AddArchivedJobs(db, kinds_, request.study_id(), state, in_archive, left(), jobs));
    }
    return absl::OkStatus();
  }));
  return jobs;
}

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
    if (jobs.empty()) return NoSuch(fmt::format("job {}", job));
    *reply.mutable_job() = std::move(jobs.front());
    reply.mutable_job()->clear_log_tail();  // The attempts have theirs.
    RETURN_IF_ERROR(AddLastAttempt(db, job, reply));
    return AddLostAttempts(db, job, reply);
  }));
  return reply;
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
}  // namespace parallax
