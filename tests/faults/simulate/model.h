// A model of the job queue: a map of studies and one of jobs, without SQL. It hears what the
// coordinator takes in and what it answers, in that order, and complains about every answer that
// breaks a promise made before.
//
// A command that was under way when the coordinator died may have had its effect or not: what it
// touches is in doubt until the next answer about it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/queue/job_queue.h"

namespace parallax::faults {

class QueueModel {
 public:
  struct Options {
    double lease_s = 60;
    double grace_s = 30;       // Until a worker whose stream broke is lost.
    double slack_s = 0;        // The longest way of a command through the coordinator.
    int64_t user_running = 0;  // The limit of jobs of all studies; 0: none.
    bool pairs_stay = true;    // None is taken back for its files.
    bool disk_lies = false;    // Commands may fail for the disk's errors, with one clear line.
  };
  // `clock`, the coordinator's, must outlive the model.
  QueueModel(const Options& options, Clock& clock) : options_(options), clock_(clock) {}

  // ---- The coordinator's life
  void Starts();
  // `release`: of the coordinator.
  void Started(uint64_t epoch, int release);
  void Died();
  // The database of then has been put back. Fences stay given.
  void Rewind(const QueueModel& then);
  // Somebody has changed its files. Before, no database counts as damaged.
  void DiskLies() { files_changed_ = true; }
  // There are studies that no client has submitted: nothing is known of their end.
  void HasOtherStudies() { studies_[0].in_doubt = true; }

  // ---- Clients. Begins: the command has come; Ends: it was answered with success.
  enum class Order { kCancel, kPause, kResume, kRetry, kForget };
  void SubmitEnds(const v1::StudySpec& spec, int64_t id);
  void OrderBegins(int64_t study);
  void OrderFails(int64_t study);
  void OrderEnds(int64_t study, Order order);
  void LimitEnds(int64_t study, int64_t max_running);
  void DrainEnds(const std::string& worker, bool undo);

  // ---- Workers
  void JoinBegins(const std::string& worker);
  void JoinFails(const std::string& worker);
  // `stream` distinguishes the worker's streams.
  void JoinEnds(const std::string& worker, const void* stream,
                const std::vector<v1::AttemptId>& holding,
                const std::vector<v1::AttemptId>& adopted);
  void Heard(const std::string& worker, const std::vector<v1::AttemptId>& running, bool draining);
  void HeardCredit(const std::string& worker) { workers_[worker].heard_s = Now(); }
  void StreamEnds(const std::string& worker, const void* stream);
  void LeaseGiven(const std::string& worker, const v1::Lease& lease, const JobQueue& queue);
  // JobQueueObserver::OnStop.
  void LeaseTaken(const v1::AttemptId& attempt, const std::string& reason);
  // A worker of this release has made the attempt's result.
  void Made(const v1::AttemptId& attempt, int release) { made_by_[attempt.fence()] = release; }
  // A report or a hand-back.
  void ReportBegins(const v1::AttemptId& attempt);
  enum class Report { kComplete, kFail, kHandBack };
  void ReportEnds(const v1::AttemptId& attempt, Report report,
                  const absl::StatusOr<v1::ReportOutcome>& outcome);

  // ---- Questions
  // Compares the queue's tables with the model. `at_end`: every study must have ended.
  void Compare(JobQueue& queue, bool at_end);
  void Complain(const std::string& what);
  // Complains about an error, unless a disk that lies explains it and it is told in one line.
  void Expect(const absl::Status& status, const std::string& what);
  // Returns whether the study was acknowledged and is still there.
  bool Knows(int64_t study) const { return studies_.count(study) > 0; }
  const std::vector<std::string>& complaints() const { return complaints_; }
  // Returns whether the audit has found what somebody has changed in the database's files.
  bool found_damage() const { return found_damage_; }
  int64_t done() const { return done_; }
  int64_t stale() const { return stale_; }

 private:
  struct Study {
    std::string name;
    bool cancelled = false, paused = false, forgotten = false;
    bool in_doubt = false;   // An order was under way at a death.
    double order_s = -1e18;  // Time of the last order.
    int64_t max_running = 0;
    int64_t pairs = 0;  // Each variant wants so many; 0: unknown.
  };
  struct Job {
    enum State { kOpen, kHeld, kDone } state = kOpen;
    int64_t study = 0;
    std::string kind;
    uint64_t fence = 0;  // The newest.
    std::string worker;
    double heard_s = 0;
    bool in_doubt = false;
    bool taken = false;  // The queue has ended the lease by itself.
  };
  struct Worker {
    double heard_s = -1e18;
    double gone_s = 1e18;  // When its stream ended; infinite while it has one.
    const void* stream = nullptr;
    bool draining = false, left = false;
    double drained_s = 1e18;  // Since when it is to get nothing.
    // The first start that has found it away. Absent once it has said hello.
    std::optional<double> unheard_unix_s;
  };

  double Now() { return SecondsOf(clock_.Steady()); }
  static double SecondsOf(SteadyTime time);
  std::string Name(int64_t job, const Job& row) const;
  // Returns whether the queue may give the lease away by now.
  bool IsExcused(const Job& job);
  // `study` < 0: of all studies, which are one user's. `limit` 0: none.
  void CheckLimit(int64_t study, int64_t limit, const JobQueue& queue);
  void CompareStudy(JobQueue& queue, int64_t id, Study& study, bool at_end);
  void CompareJobs(JobQueue& queue, int64_t id);
  void CompareFrames(JobQueue& queue, int64_t id, const v1::StudyStatus& status);

  const Options options_;
  Clock& clock_;
  uint64_t epoch_ = 0;
  int release_ = 0;
  std::map<int64_t, Study> studies_;
  std::map<std::string, int64_t> study_of_name_;
  std::map<int64_t, Job> jobs_;
  std::map<std::string, Worker> workers_;
  std::set<uint64_t> fences_;        // Given.
  std::map<uint64_t, int> made_by_;  // Releases, by fence.
  std::set<uint64_t> accepted_;      // Whose results were taken, or may have been.
  std::multiset<std::pair<int64_t, uint64_t>> reporting_;  // Job and fence.
  std::multiset<std::string> joining_;
  std::multiset<int64_t> ordering_;
  std::vector<std::string> complaints_;
  int64_t done_ = 0;
  int64_t stale_ = 0;
  bool files_changed_ = false;
  bool found_damage_ = false;
};

}  // namespace parallax::faults
