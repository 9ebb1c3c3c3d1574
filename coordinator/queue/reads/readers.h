// Reads the queue's database on query_only connections. Every call reads one short snapshot with a
// deadline. Reads never wait for the writer and never checkpoint. Thread-safe.
//
// Errors: kNotFound for an unknown study or scene; kDeadlineExceeded for a read that takes too
// long; those of the database.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/lease.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class Readers {
 public:
  // Opens `connections` connections. `kinds` must outlive the readers.
  static absl::StatusOr<std::unique_ptr<Readers>> Open(const std::string& path,
                                                       const std::string& vfs, int connections,
                                                       double deadline_s,
                                                       const KindRegistry& kinds);

  // Runs `read` in a read transaction, for at most `deadline_s` seconds; 0: no deadline.
  absl::Status Read(double deadline_s, const std::function<absl::Status(SqliteConnection&)>& read);
  // The same for a function that returns a StatusOr, which is returned.
  template <typename Function>
  auto Get(double deadline_s, const Function& read) {
    std::invoke_result_t<const Function&, SqliteConnection&> found = Unknown("not read");
    const absl::Status status = Read(deadline_s, [&](SqliteConnection& db) {
      found = read(db);
      return found.status();
    });
    if (!status.ok()) found = status;
    return found;
  }

  // The reads of JobQueue, which documents them (job_queue.h).
  absl::StatusOr<v1::StudyStatus> GetStudy(int64_t study);
  absl::StatusOr<std::vector<v1::StudyStatus>> ListStudies(int limit, int64_t before,
                                                           bool only_unfinished);
  // Returns for each user, by name, the sums over its unfinished studies. The limits are not set.
  absl::StatusOr<std::vector<v1::UserStatus>> ListUsers();
  absl::StatusOr<std::vector<v1::JobStatus>> ListJobs(const v1::ListJobsRequest& request);
  absl::StatusOr<v1::ListAttemptsReply> ListAttempts(int64_t job);
  absl::StatusOr<std::vector<v1::PublishedFrame>> ListFrames(const v1::ListFramesRequest& request);
  absl::StatusOr<std::vector<v1::JobResult>> ListResults(const v1::ListResultsRequest& request);
  // Returns the jobs of `figures` (figures by job id) with their names. Jobs that are no longer in
  // the table are left out.
  absl::StatusOr<std::vector<RunningJob>> ListRunning(
      const std::map<int64_t, std::map<std::string, double>>& figures);
  absl::StatusOr<std::vector<HistorySample>> ListSamples(double since_unix_s);
  absl::StatusOr<std::vector<std::string>> ListLitter(double before_unix_s, int limit);
  absl::StatusOr<std::vector<std::string>> ListContentFolders();
  absl::StatusOr<v1::Scene> GetScene(const v1::GetSceneRequest& request);
  absl::StatusOr<std::vector<v1::AuditEntry>> ListAudit(const v1::ListAuditRequest& request);
  absl::StatusOr<std::string> SubmitterOf(int64_t study);
  absl::StatusOr<std::vector<int64_t>> ListSubmitted(const std::string& prefix,
                                                     const std::string& user);
  // Returns the message that hands a committed lease to its worker.
  absl::StatusOr<v1::Lease> LeaseMessage(const GrantedLease& lease);

 private:
  Readers(double deadline_s, const KindRegistry& kinds) : deadline_s_(deadline_s), kinds_(kinds) {}

  const double deadline_s_;
  const KindRegistry& kinds_;
  std::mutex mutex_;
  std::condition_variable free_one_;
  std::vector<std::unique_ptr<SqliteConnection>> free_;  // Guarded by mutex_.
};

// Stores a sample of the farm's figures, on the writing thread. Removes samples that are older than
// two days, and samples from the future, which exist after the clock was set back. Errors: the
// database's.
absl::Status KeepSampleIn(SqliteConnection& db, const HistorySample& sample);

}  // namespace parallax
