#include "coordinator/queue/reads/page_reader.h"

#include <fmt/core.h>

#include <algorithm>

#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/reads/reader_rows.h"
#include "coordinator/queue/reads/readers.h"
#include "coordinator/study/rigs.h"

namespace parallax {
namespace {

constexpr int kConnections = 4;
constexpr double kDeadline_s = 5;
constexpr int kMostPairs = 200;
constexpr int kMostProblems = 2000;
constexpr size_t kMostExamples = 5;
constexpr int kMostAttempts = 100;

#define PARALLAX_PAIR                                                                \
  "SELECT f.cursor, f.study_id, s.name, v.name, f.ordinal, f.reused, r.bytes, f.rig" \
  " FROM frames AS f JOIN variants AS v ON v.id = f.variant_id"                      \
  " JOIN studies AS s ON s.id = f.study_id JOIN results AS r ON r.work_key = f.frame_key "

absl::StatusOr<std::vector<PublishedPair>> PairsOf(SqliteQuery& query) {
  std::vector<PublishedPair> pairs;
  while (query.Next()) {
    PublishedPair& pair = pairs.emplace_back();
    pair.number = query.Int(0);
    pair.study_id = query.Int(1);
    pair.study = std::string(query.Text(2));
    pair.variant = std::string(query.Text(3));
    pair.scene = static_cast<uint32_t>(query.Int(4));
    pair.reused = query.Int(5) != 0;
    RETURN_IF_ERROR(UnpackMessage(query.Blob(6), pair.frame));
  }
  RETURN_IF_ERROR(query.status());
  return pairs;
}

// ---- Problems
// The last failure of a job that is not simply lost or handed back comes along.
#define PARALLAX_PROBLEM_OF(table, losses)                                                \
  "SELECT j.id, j.kind, j.state, j.error, coalesce(j.finished_unix_s, j.ready_unix_s),"   \
  " coalesce((SELECT l.fingerprint FROM " losses                                          \
  " AS l WHERE l.job_id = j.id AND l.ledger = 'app' ORDER BY l.unix_s DESC LIMIT 1), '')" \
  " FROM " table " AS j WHERE "

// Errors that differ only in numbers have one cause.
std::string WithoutNumbers(std::string_view error) {
  std::string text;
  for (const char c : error.substr(0, 200)) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit) text += c;
    if (digit && (text.empty() || text.back() != '#')) text += '#';
  }
  return text;
}

using CausesByKey = std::map<std::string, ProblemCause>;

absl::Status AddProblems(SqliteQuery& query, CausesByKey& causes) {
  while (query.Next()) {
    const std::string fingerprint(query.Text(5)), error(query.Text(3)), kind(query.Text(1));
    ProblemCause& cause =
        causes[kind + "\n" + (fingerprint.empty() ? WithoutNumbers(error) : fingerprint)];
    const double unix_s = query.Real(4);
    if (cause.jobs == 0 || unix_s > cause.newest_unix_s) {
      cause.fingerprint = fingerprint;
      cause.error = error;
      cause.kind = kind;
      cause.newest_unix_s = unix_s;
    }
    ++cause.jobs;
    ++cause.states[std::string(query.Text(2))];
    if (cause.examples.size() < kMostExamples) cause.examples.push_back(query.Int(0));
  }
  return query.status();
}

absl::Status AddProblemsOfStudy(SqliteConnection& db, int64_t study, CausesByKey& causes) {
  constexpr char kHeld[] = PARALLAX_PROBLEM_OF("jobs", "attempt_losses")
      "j.state IN ('FAILED', 'QUARANTINED') AND j.variant_id IN"
      " (SELECT id FROM variants WHERE study_id = ?1) ORDER BY j.finished_unix_s DESC LIMIT ?2";
  constexpr char kWaiting[] = PARALLAX_PROBLEM_OF(
      "jobs", "attempt_losses") "j.state = 'RETRY_WAIT' AND j.study_id = ?1 LIMIT ?2";
  constexpr char kArchived[] = PARALLAX_PROBLEM_OF("archived_jobs", "archived_losses")
      "j.state IN ('FAILED', 'QUARANTINED') AND j.variant_id IN"
      " (SELECT id FROM variants WHERE study_id = ?1) LIMIT ?2";
  for (const char* sql : {kHeld, kWaiting, kArchived}) {
    SqliteQuery query(db, sql, study, kMostProblems);
    RETURN_IF_ERROR(AddProblems(query, causes));
  }
  return absl::OkStatus();
}

// ---- Jobs
absl::Status FillJob(const SqliteQuery& row, const KindRegistry& kinds, JobDetail& job) {
  v1::JobStatus& status = job.status;
  status.set_job_id(row.Int(0));
  job.study_id = row.Int(1);
  job.study = std::string(row.Text(2));
  status.set_variant(std::string(row.Text(3)));
  status.set_kind(std::string(row.Text(4)));
  ASSIGN_OR_RETURN(const KindId kind, kinds.IdOf(row.Text(4)));
  status.set_scene(kinds[kind].traits().of_scene ? static_cast<uint32_t>(row.Int(5)) : kNoScene);
  status.set_label(kinds[kind].LabelOf(row.Blob(6)));
  if (const auto rigs = ParseRigs(row.Text(7)); rigs.ok()) {
    status.mutable_rigs()->Add(rigs->begin(), rigs->end());
  }
  job.generation = static_cast<int>(row.Int(8));
  status.set_state(std::string(row.Text(9)));
  job.fence = static_cast<uint64_t>(row.Int(10));
  status.set_worker(std::string(row.Text(11)));
  status.set_attempts(static_cast<int>(row.Int(12)));
  job.app_failures = static_cast<int>(row.Int(13));
  job.infra_losses = static_cast<int>(row.Int(14));
  job.reused = row.Int(15) != 0;
  job.awaits_job = row.Int(16);
  job.not_before_unix_s = row.Real(17);
  job.ready_unix_s = row.Real(18);
  job.finished_unix_s = row.Real(19);
  status.set_error(std::string(row.Text(20)));
  return absl::OkStatus();
}

absl::Status AddAttempts(SqliteConnection& db, JobDetail& job) {
  SqliteQuery query(db,
                    "SELECT fence, ledger, worker, fingerprint, error, unix_s, log_tail"
                    " FROM all_losses WHERE job_id = ?1 ORDER BY unix_s DESC LIMIT ?2",
                    job.status.job_id(), kMostAttempts);
  while (query.Next()) {
    LostAttempt& attempt = job.attempts.emplace_back();
    attempt.fence = static_cast<uint64_t>(query.Int(0));
    attempt.ledger = std::string(query.Text(1));
    attempt.worker = std::string(query.Text(2));
    attempt.fingerprint = std::string(query.Text(3));
    attempt.error = std::string(query.Text(4));
    attempt.unix_s = query.Real(5);
    attempt.log_tail = std::string(query.Text(6));
  }
  std::reverse(job.attempts.begin(), job.attempts.end());
  return query.status();
}

absl::Status AddResult(SqliteConnection& db, const KindRegistry& kinds, JobDetail& job) {
  if (job.status.state() != NameOf(JobState::kSucceeded)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const KindId kind, kinds.IdOf(job.status.kind()));
  SqliteQuery query(db,
                    "SELECT r.bytes FROM all_jobs AS j JOIN results AS r"
                    " ON r.work_key = j.work_key AND r.stage = j.kind WHERE j.id = ?1",
                    job.status.job_id());
  if (query.Next()) {
    if (auto folder = kinds[kind].FolderOf(query.Blob(0))) {
      job.result_path = std::move(folder->path);
      job.result_files.assign(folder->files.begin(), folder->files.end());
    }
  }
  return query.status();
}

absl::Status AddPairsOfJob(SqliteConnection& db, int64_t variant, JobDetail& job) {
  if (job.status.rigs().empty()) return absl::OkStatus();
  SqliteQuery query(db, PARALLAX_PAIR "WHERE f.variant_id = ?1 AND f.ordinal = ?2 ORDER BY f.rig",
                    variant, job.status.scene());
  ASSIGN_OR_RETURN(std::vector<PublishedPair> pairs, PairsOf(query));
  for (PublishedPair& pair : pairs) {
    if (std::count(job.status.rigs().begin(), job.status.rigs().end(), pair.frame.rig()) > 0) {
      job.pairs.push_back(std::move(pair));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<PageReader>> PageReader::Open(const std::string& db_path,
                                                             const KindRegistry& kinds) {
  ASSIGN_OR_RETURN(auto readers, Readers::Open(db_path, "", kConnections, kDeadline_s, kinds));
  return std::unique_ptr<PageReader>(new PageReader(std::move(readers), kinds));
}

PageReader::PageReader(std::unique_ptr<Readers> readers, const KindRegistry& kinds)
    : readers_(std::move(readers)), kinds_(kinds) {}

PageReader::~PageReader() = default;

absl::StatusOr<std::vector<PublishedPair>> PageReader::NewestPairs(const PairQuery& asked) {
  const int limit = std::clamp(asked.limit, 1, kMostPairs);
  using Pairs = absl::StatusOr<std::vector<PublishedPair>>;
  return readers_->Get(kDeadline_s, [&](SqliteConnection& db) -> Pairs {
    if (asked.variant.empty()) {
      SqliteQuery query(db,
                        PARALLAX_PAIR
                        "WHERE f.study_id = ?1 AND (?2 = 0 OR f.cursor < ?2)"
                        " ORDER BY f.cursor DESC LIMIT ?3",
                        asked.study_id, asked.before, limit);
      return PairsOf(query);
    }
    ASSIGN_OR_RETURN(const auto variant,
                     db.Integer("SELECT id FROM variants WHERE study_id = ?1 AND name = ?2",
                                asked.study_id, asked.variant));
    if (!variant) return NoSuch("variant '" + asked.variant + "'");
    SqliteQuery query(db,
                      PARALLAX_PAIR
                      "WHERE f.variant_id = ?1 AND (?2 = 0 OR (f.ordinal, f.rig) <"
                      " (SELECT b.ordinal, b.rig FROM frames AS b WHERE b.cursor = ?2))"
                      " ORDER BY f.ordinal DESC, f.rig DESC LIMIT ?3",
                      *variant, asked.before, limit);
    return PairsOf(query);
  });
}

absl::StatusOr<PublishedPair> PageReader::Pair(int64_t number) {
  ASSIGN_OR_RETURN(std::vector<PublishedPair> pairs,
                   readers_->Get(kDeadline_s, [&](SqliteConnection& db) {
                     SqliteQuery query(db, PARALLAX_PAIR "WHERE f.cursor = ?1", number);
                     return PairsOf(query);
                   }));
  if (pairs.empty()) return NoSuch(fmt::format("pair {}", number));
  return std::move(pairs.front());
}

absl::StatusOr<PageReader::Neighbours> PageReader::NeighboursOf(const PublishedPair& pair) {
  return readers_->Get(kDeadline_s, [&](SqliteConnection& db) -> absl::StatusOr<Neighbours> {
    ASSIGN_OR_RETURN(
        const auto older,
        db.Integer("SELECT max(cursor) FROM frames WHERE study_id = ?1 AND cursor < ?2",
                   pair.study_id, pair.number));
    ASSIGN_OR_RETURN(
        const auto newer,
        db.Integer("SELECT min(cursor) FROM frames WHERE study_id = ?1 AND cursor > ?2",
                   pair.study_id, pair.number));
    return Neighbours{older.value_or(0), newer.value_or(0)};
  });
}

absl::StatusOr<std::vector<ProblemCause>> PageReader::Problems(int64_t study_id) {
  CausesByKey causes;
  RETURN_IF_ERROR(readers_->Read(
      kDeadline_s, [&](SqliteConnection& db) { return AddProblemsOfStudy(db, study_id, causes); }));
  std::vector<ProblemCause> sorted;
  for (auto& [key, cause] : causes) sorted.push_back(std::move(cause));
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ProblemCause& a, const ProblemCause& b) { return a.jobs > b.jobs; });
  return sorted;
}

absl::StatusOr<JobDetail> PageReader::Job(int64_t job_id) {
  JobDetail job;
  RETURN_IF_ERROR(readers_->Read(kDeadline_s, [&](SqliteConnection& db) -> absl::Status {
    int64_t variant = 0;
    {
      SqliteQuery query(db,
                        "SELECT j.id, j.study_id, s.name, v.name, j.kind, j.ordinal, j.input,"
                        " j.rigs, j.generation, j.state, j.fence, j.worker, j.attempts,"
                        " j.app_failures, j.infra_losses, j.reused, j.awaits_job,"
                        " j.not_before_unix_s, j.ready_unix_s, j.finished_unix_s, j.error,"
                        " j.variant_id FROM all_jobs AS j JOIN variants AS v ON v.id = j.variant_id"
                        " JOIN studies AS s ON s.id = j.study_id WHERE j.id = ?1",
                        job_id);
      RETURN_IF_ERROR(FirstRow(query, fmt::format("job {}", job_id)));
      RETURN_IF_ERROR(FillJob(query, kinds_, job));
      variant = query.Int(21);
    }
    RETURN_IF_ERROR(AddAttempts(db, job));
    RETURN_IF_ERROR(AddResult(db, kinds_, job));
    return AddPairsOfJob(db, variant, job);
  }));
  return job;
}

absl::StatusOr<std::vector<StudyScore>> PageReader::Scores(int64_t study_id) {
  std::vector<StudyScore> scores;
  RETURN_IF_ERROR(readers_->Read(kDeadline_s, [&](SqliteConnection& db) -> absl::Status {
    SqliteQuery query(db,
                      "SELECT j.id, j.kind, j.input, r.bytes, s.cursor FROM study_results AS s"
                      " JOIN all_jobs AS j ON j.id = s.job_id"
                      " JOIN results AS r ON r.work_key = s.work_key"
                      " WHERE s.study_id = ?1 ORDER BY s.cursor LIMIT 10000",
                      study_id);
    while (query.Next()) {
      ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(query.Text(1)));
      auto score = kinds_[kind].ScoreOf(query.Blob(2), query.Blob(3));
      if (score) scores.push_back({query.Int(0), *std::move(score)});
    }
    return query.status();
  }));
  return scores;
}

}  // namespace parallax
