// The durable job queue: studies go in, leases go out, results come back, and nothing is lost or
// counted twice.
//
// Invariants (JobQueue::Check re-derives each of them from the tables):
// - A job is in one state; only the holder of its newest fence can end it; a terminal row never
// changes.
// - What a completion implies (the jobs that it makes possible, replaced scenes,
// released followers and waiters, counters, published frames) is committed
//   in the same transaction as the completion itself. A call that returned OK is on disk.
// - A fence is never issued twice, neither after a restart nor from a restored backup.
// - One process and, in it, one thread writes the database; commands are committed in groups.
//
// Thread-safe. Every call that changes something blocks until its group is on disk (about one
// fsync); the ...Async forms call back from the queue's own thread instead, and such a callback
// must neither block nor call a blocking method of the queue. An I/O error at commit ends the
// process (see JobQueueOptions::on_fatal): a failed fsync can't be retried, a restart recovers.
//
// Errors: kNotFound for a study, variant or scene that there is not; those of the database; more
// where a call says so.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/version.h"
#include "common/config/limit_rules.h"
#include "coordinator/queue/fail_point.h"
#include "coordinator/queue/farm_history.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/policy.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// Guards that fault tests switch off to show that they would notice. No program, flag or
// environment variable sets them.
struct UnsafeForTest {
  bool synchronous_off = false;  // The writer's PRAGMA synchronous = OFF.
  bool ignore_fences = false;    // Any report of a leased job counts as its holder's.
  bool keep_epoch = false;       // A start goes on with the last epoch.
};

struct JobQueueOptions {
  std::string db_path;  // Made if absent; its folder must exist and be on a local file system.
  Clock* clock = &Clock::System();  // Must outlive the queue.
  double lease_s = 60;              // A lease that isn't heard of for so long goes back.
  bool own_timer = true;  // Expire leases and end back-offs by itself; tests call Tick() instead.
  int scenes_ahead =
      512;              // Unfinished scenes of a variant that exist as rows; the rest is a cursor.
  int max_batch = 512;  // Commands in one commit.
  int checkpoint_pages = 2000;  // The WAL is checkpointed each time it has grown by so much.
  double linger_s = 0.002;      // A group under load waits so long for more commands.
  int readers = 3;              // Connections for the reading calls.
  double read_deadline_s = 10;  // A reading call gives up with kDeadlineExceeded.
  StageVersions versions;       // Part of every result's key.
  // Kinds of jobs. Must outlive the queue; a database with jobs of others is refused.
  const KindRegistry* kinds = &KindRegistry::Builtin();
  RetryPolicy retry;
  LimitRules limits;  // Of users. Another set than at the last start stands in the audit table.
  // Jobs of studies that finished so long ago go to the archive: still listed,
  // their results still reused, but not retried. 0: never.
  double archive_after_s = 30 * 86400.0;
  // Logs of failed attempts that are kept, of at most 16 kB, and as many of archived jobs.
  int most_logs = 1000;
  std::string vfs;             // SQLite VFS by name; empty: the system's.
  FailPoint::Hook fail_point;  // For fault tests; null: as the environment says.
  UnsafeForTest unsafe_for_test;
  // Called once, from the queue's thread, when a commit failed; must not return. Absent: one line
  // on stderr, exit 70.
  std::function<void(const absl::Status&)> on_fatal;
};

// Slots of the whole farm at one moment that take a kind of job.
struct FarmSlots {
  int idle = 0;  // Without a job, those asked for here included.
  int all = 0;
};
// What the scheduler must know of a worker to choose for it.
struct WorkerFacts {
  std::string name;
  std::vector<std::string> kinds;  // Of jobs that it takes.
  int64_t memory_mb = 0;
  std::vector<std::string> tags;
  // By kind, of those whose jobs can be split: decides whether one is. Absent: it is not.
  std::map<std::string, FarmSlots> farm;
};

// Told by the queue's thread after the commit that caused it. Must not block.
class JobQueueObserver {
 public:
  virtual ~JobQueueObserver() = default;
  // Jobs may have become READY: workers with credit should ask for leases again.
  virtual void OnWorkReady() = 0;
  // This attempt's result is not wanted any more (cancelled, lease lost): tell the worker to stop
  // it.
  virtual void OnStop(const std::string& worker, const v1::AttemptId& attempt,
                      const std::string& reason) = 0;
  // These are now all orders to drain.
  virtual void OnDrains(const std::vector<v1::DrainOrder>& /*drains*/) {}
};

// For /metrics. Taken without touching the database.
struct JobQueueStats {
  // (kind, state) -> jobs, of all studies that this process has loaded; every kind with every
  // state.
  std::map<std::pair<std::string, std::string>, int64_t> jobs;
  int64_t leases_held = 0;
  uint64_t commits = 0;
  uint64_t commands = 0;
  uint64_t leases_granted = 0;
  uint64_t completions = 0;
  uint64_t failures = 0;  // App failures reported.
  uint64_t losses = 0;    // Infra losses.
  uint64_t stale_reports = 0;
  uint64_t splits = 0;         // Jobs made from rigs of another.
  uint64_t archived_jobs = 0;  // Moved to the archive.
  double commit_seconds = 0;   // In COMMIT, fsync included, summed.
  double commit_seconds_max = 0;
  uint64_t checkpoints = 0;  // Of the WAL; whoever waits for a commit waits for them too.
  double checkpoint_seconds = 0;
  double checkpoint_seconds_max = 0;
  int largest_batch = 0;
  int64_t wal_pages = 0;
  // How many commits took at most so long, and carried at most so many commands; cumulative, one
  // longer than their bounds: +Inf.
  std::vector<double> commit_bounds_s;
  std::vector<uint64_t> commit_counts;
  std::vector<double> batch_bounds;
  std::vector<uint64_t> batch_counts;
};

// A leased job that tells figures of itself.
struct RunningJob {
  int64_t job_id = 0;
  std::string study, kind, label;
  std::map<std::string, double> figures;  // See v1::Progress.
};

class JobQueue {
 public:
  // Opens or creates the database, migrates it forward, raises and commits the epoch, loads what is
  // unfinished. Errors: kFailedPrecondition for a database from the future, one that another
  // coordinator has open, a network file system; kDataLoss for a file that is not ours or is
  // corrupt; else as the system says.
  static absl::StatusOr<std::unique_ptr<JobQueue>> Open(JobQueueOptions options);
  ~JobQueue();  // Finishes accepted commands, closes. Leases stay: the next start adopts them.

  uint64_t epoch() const;
  const KindRegistry& kinds() const;
  // Names the database for as long as it exists, backups included: reports that carry it can't be
  // taken for those of another database's job of the same number.
  const std::string& database_id() const;
  int64_t schema_version() const;
  double lease_s() const;
  // Before the first call that leases; null takes it away. The observer must outlive the queue or
  // be taken away.
  void SetObserver(JobQueueObserver* observer);

  // ---- Clients. `actor` goes to the audit table. ------------------------------------------------
  // O(variants) whatever the number of pairs. The same idempotency key again returns the first
  // study. Errors: kInvalidArgument for a bad spec; kAlreadyExists for a used key with another
  // study; kFailedPrecondition for more than the user's limits allow, naming the limit.
  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request, std::string_view actor);
  // All unfinished jobs become CANCELLED, running attempts are told to stop. Again: no effect.
  // kNotFound.
  absl::Status Cancel(StudyId study, std::string_view reason, std::string_view actor);
  // No new leases; what runs goes on.
  absl::Status Pause(StudyId study, std::string_view reason, std::string_view actor);
  absl::Status Resume(StudyId study, std::string_view reason, std::string_view actor);
  // At most so many of its jobs are leased at a time from now on, 0: no limit of its own. What runs
  // goes on.
  absl::Status SetMaxRunning(StudyId study, int64_t max_running, std::string_view reason,
                             std::string_view actor);
  // Failed and quarantined jobs get a new generation as far as pairs are missing (a scene that was
  // already replaced isn't made again), and variants that gave up go on. Returns the new jobs.
  // kFailedPrecondition if cancelled, or if the user's limits allow no other unfinished study.
  absl::StatusOr<int64_t> Retry(StudyId study, std::string_view actor);

  // Removes a study that has ended for good: its jobs, and what it made and no other study uses. It
  // is gone at once; its rows go in the background, and its files become litter. Returns what it
  // had. kFailedPrecondition if it has not ended.
  absl::StatusOr<v1::ForgetReply> Forget(StudyId study, std::string_view reason,
                                         std::string_view actor);
  // Workers whose names match `order.pattern` (CheckDrainPattern) are to get no leases, until it is
  // undone; the queue itself only keeps the orders and tells the observer. kNotFound for an undone
  // order that there is not.
  absl::Status Drain(const v1::DrainOrder& order, bool undo);

  // ---- Workers ----------------------------------------------------------------------------------
  // Up to `max_jobs` leases, fewer or none if nothing fits.
  absl::StatusOr<std::vector<v1::Lease>> Lease(const WorkerFacts& worker, int max_jobs);
  void LeaseAsync(const WorkerFacts& worker, int max_jobs,
                  std::function<void(absl::StatusOr<std::vector<v1::Lease>>)> done);
  // OK, ALREADY_DONE, STALE_FENCE, CANCELLED are all definitive. kInvalidArgument too: the result
  // does not belong to the job (wrong kind, rigs not asked for, path outside the attempt's folder),
  // and the attempt counts as failed; or the reporter is not the holder, who then goes on.
  absl::StatusOr<v1::ReportOutcome> Complete(const v1::CompleteRequest& request);
  // `request` is not needed after the call. `invalid`: why the caller knows that the result can't
  // be right (files that aren't in the store); empty if it may be.
  void CompleteAsync(const v1::CompleteRequest& request, const std::string& invalid,
                     std::function<void(absl::StatusOr<v1::ReportOutcome>)> done);
  absl::StatusOr<v1::ReportOutcome> Fail(const v1::FailRequest& request);
  // Back without blame (drain): READY at once.
  absl::StatusOr<v1::ReportOutcome> HandBack(const std::string& worker,
                                             const v1::AttemptId& attempt, std::string_view reason);
  // A worker says Hello with what it still runs. Those that it rightly holds are its again and
  // returned; leases in its name that it does not know of are lost (infra): they never reached it
  // if it is the `same_process` as before, and say nothing against the job then. Everything in
  // `holding` that isn't returned must be stopped.
  absl::StatusOr<std::vector<v1::AttemptId>> Adopt(const std::string& worker,
                                                   const std::vector<v1::AttemptId>& holding,
                                                   bool same_process = false);
  // The worker is gone for good (grace is over): its leases are lost. Returns their number.
  absl::StatusOr<int> WorkerLost(const std::string& worker);
  // Keeps the named leases alive. In memory: cheap, never waits for the disk. Returns those that
  // the worker does not hold (any more) and must stop.
  std::vector<v1::AttemptId> Heartbeat(const std::string& worker,
                                       const std::vector<v1::Progress>& running);

  // Whether this is the worker's lease now. In memory: cheap.
  bool IsHeldBy(const std::string& worker, const v1::AttemptId& attempt) const;
  // How many leases the worker holds now. In memory: cheap.
  int HeldBy(const std::string& worker) const;

  // Expires leases and ends back-offs that are due. Returns the seconds until there is something to
  // do again. Called by the queue itself with own_timer.
  absl::StatusOr<double> Tick();

  // ---- Reads: own connections, consistent snapshots, never wait for the writer ----------------
  absl::StatusOr<v1::StudyStatus> GetStudy(StudyId study);  // With spec.
  // Newest first; with `before` only those with smaller ids.
  absl::StatusOr<std::vector<v1::StudyStatus>> ListStudies(int limit, int64_t before = 0);
  // `state` empty: jobs that need a look first, then by progress. A page goes on behind the last
  // job of the one before (after_job, after_state). limit <= 10,000. kNotFound for an after_job
  // that there is not.
  absl::StatusOr<std::vector<v1::JobStatus>> ListJobs(const v1::ListJobsRequest& request);
  // A job with all its attempts, the newest first. kNotFound.
  absl::StatusOr<v1::ListAttemptsReply> ListAttempts(int64_t job);
  absl::StatusOr<std::vector<v1::DrainOrder>> Drains();
  // In order of publication, after request.cursor. limit <= 10,000, 0 = 1,000.
  absl::StatusOr<std::vector<v1::PublishedFrame>> ListFrames(const v1::ListFramesRequest& request);
  // Results of jobs outside of scenes that have files, in the order of their ends, after
  // request.cursor. limit <= 10,000, 0 = 1,000.
  absl::StatusOr<std::vector<v1::JobResult>> ListResults(const v1::ListResultsRequest& request);
  absl::StatusOr<v1::Scene> GetScene(const v1::GetSceneRequest& request);
  // The newest first. limit <= 10,000, 0 = 100.
  absl::StatusOr<std::vector<v1::AuditEntry>> ListAudit(const v1::ListAuditRequest& request);
  // Users with unfinished studies and those that have rows of their own in the limits, by name.
  absl::StatusOr<std::vector<v1::UserStatus>> ListUsers();
  // The actor of the study's submit. kNotFound.
  absl::StatusOr<std::string> SubmitterOf(StudyId study);

  // At most 1,000 leased jobs that tell figures of themselves, by id.
  absl::StatusOr<std::vector<RunningJob>> ListRunning();
  JobQueueStats Stats() const;

  // ---- The farm's figures over time
  // Keeps a sample, at the latest with the next commit; does not wait for it. Samples of the last
  // two days are kept.
  void KeepSample(const HistorySample& sample);
  // Samples since then, the oldest first.
  absl::StatusOr<std::vector<HistorySample>> ListSamples(double since_unix_s);

  // ---- Litter: folders of the store that no result names or ever will -------------------------
  // Paths in the store that became litter at least `older_than_s` ago, the oldest first.
  absl::StatusOr<std::vector<std::string>> ListLitter(double older_than_s, int limit);
  // The janitor has removed them.
  absl::Status ForgetLitter(const std::vector<std::string>& paths);

  // ---- Operations -----------------------------------------------------------------------------
  // Re-derives every invariant; empty when all hold. Reads everything: seconds
  // for a million rows.
  absl::StatusOr<std::vector<std::string>> Check();
  // A consistent copy while work goes on; see backup.h.
  absl::Status Backup(const std::string& path);

 private:
  class Impl;
  explicit JobQueue(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
