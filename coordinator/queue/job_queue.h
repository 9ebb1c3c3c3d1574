// The durable job queue: clients submit studies, workers lease jobs and report results, and no
// result is lost or counted twice.
//
// Invariants (JobQueue::Check re-derives each of them from the tables):
// - A job is in one state. Only the holder of its newest fence can end it. A terminal row never
//   changes.
// - A completion is committed in one transaction with all that it implies: the jobs that it makes
//   possible, replaced scenes, released followers and waiters, counters, published frames. The
//   effects of a call that returned OK are on disk.
// - A fence is never issued twice, neither after a restart nor from a restored backup.
// - One process, and one thread of it, writes the database. Commands are committed in groups.
//
// Thread-safe. Every call that changes something blocks until its group is on disk (about one
// fsync). The ...Async forms return at once and call back from the queue's own thread; the callback
// must not block or call a blocking method of the queue. An I/O error at commit ends the process
// (see JobQueueOptions::on_fatal), because a failed fsync can't be retried; a restart recovers.
//
// Errors of all calls: kNotFound for an unknown study, variant or scene; those of the database; and
// those named at the call.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/base/version.h"
#include "common/config/check/limit_rules.h"
#include "coordinator/queue/commands/policy.h"
#include "coordinator/queue/database/fail_point.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/notice.h"
#include "coordinator/queue/reads/farm_history.h"
#include "coordinator/queue/ready_key.h"
#include "coordinator/queue/stored_outputs.h"
#include "coordinator/queue/study_costs.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// Switches off guards of the queue, so that fault tests can prove that they detect it. No program,
// flag or environment variable sets them.
struct UnsafeForTest {
  bool synchronous_off = false;  // The writer's PRAGMA synchronous = OFF.
  bool ignore_fences = false;    // Accept any report of a leased job as its holder's.
  bool keep_epoch = false;       // Keep the last epoch at a start.
  bool keep_waiters = false;     // Leave jobs blocked whose waits are met.
  bool adopt_nothing = false;    // Take every lease from a worker that says Hello.
  bool expire_early = false;     // End leases after half of their time.
  bool ignore_limits = false;    // Lease jobs of studies and users that have reached their limits.
  bool keep_generation = false;  // Give a retry the generation of its predecessor.
  bool forget_unfinished = false;  // Forget studies that have not ended.
  bool archive_newest = false;     // Archive the newest job of all, too.
  bool hear_at_start = false;      // Count every lease as just heard of at each start.
  bool any_version = false;        // Keep the leases of a start with other versions of stages.
};

// Options of a queue. The defaults are those of `coordinator serve`.
struct JobQueueOptions {
  std::string db_path;  // Made if absent; its folder must exist and be on a local file system.
  Clock* clock = &Clock::System();  // Must outlive the queue.
  double lease_s = 60;              // Seconds without a heartbeat until a lease is lost.
  bool own_timer = true;  // Expire leases and end back-offs by itself. Tests call Tick() instead.
  // Work on threads of its own. Without them, the thread that calls the queue does its work, in
  // calls that wait and in Work().
  bool own_threads = true;
  // Unfinished scenes of a variant that exist as rows; all later ones are a cursor.
  int scenes_ahead = 512;
  int max_batch = 512;          // Commands in one commit.
  int checkpoint_pages = 2000;  // Growth of the WAL, in pages, between checkpoints.
  double linger_s = 0.002;      // Under load, a group waits so long for more commands.
  int readers = 3;              // Connections for reading calls.
  double read_deadline_s = 10;  // A reading call then fails with kDeadlineExceeded.
  StageVersions versions;       // Part of every result's key.
  // Kinds of jobs. Must outlive the queue. A database with jobs of another kind is refused.
  const KindRegistry* kinds = &KindRegistry::Builtin();
  RetryPolicy retry;
  LimitRules limits;  // Per user. Another set than at the last start is noted in the audit table.
  // Jobs of studies that finished so many seconds ago go to the archive. They are still listed and
  // their results are still reused, but they can't be retried. 0: never.
  double archive_after_s = 30 * 86400.0;
  // Number of logs of failed attempts to keep, of at most 16 kB each, and as many of archived jobs.
  int most_logs = 1000;
  // Receivers of notices, such as "webhook": what happens to studies is kept for each of them until
  // it has it. kStudyTarget stands for the studies' own. Empty: nothing is kept.
  std::vector<std::string> notice_targets;
  double notice_gather_s = 60;  // Failures of one study within this time are one notice.
  // Opens the store of the results and returns its id. Called by Open before any command, with the
  // store that the database knows; the database keeps the id. Errors end Open. If absent, the
  // database keeps none.
  std::function<absl::StatusOr<std::string>(const KnownStore& known)> open_store;
  // Returns whether files are in the store with their sizes. A result whose files are not is never
  // used again, but taken back. Called by the writing thread, so it must be quick. If absent, all
  // are taken to be there.
  std::function<bool(const std::vector<JobKind::OutputFile>& files)> files_there;
  std::string vfs;             // SQLite VFS by name; empty: the system's.
  FailPoint::Hook fail_point;  // For fault tests; null: as the environment variable says.
  UnsafeForTest unsafe_for_test;
  // Called once, from the queue's thread, when a commit failed; must not return. If absent, writes
  // one line to stderr and exits with status 70.
  std::function<void(const absl::Status&)> on_fatal;
};

// The slots of the whole farm that take a kind of job, at one moment.
struct FarmSlots {
  int idle = 0;  // Slots without a job, those of the asking worker included.
  int all = 0;
};
// The facts about a worker by which the scheduler chooses jobs for it.
struct WorkerFacts {
  std::string name;
  std::string machine;  // Where it runs, equal for workers of one machine; empty: its own one.
  std::vector<std::string> kinds;  // Kinds of jobs that it takes.
  int64_t memory_mb = 0;
  std::vector<std::string> tags;
  // Slots by kind, for kinds whose jobs can be split; decides whether a job is. Absent: it is not.
  std::map<std::string, FarmSlots> farm;
};

// Gets news from the queue. Called by the queue's thread after the commit that caused it; must not
// block.
class JobQueueObserver {
 public:
  virtual ~JobQueueObserver() = default;
  // Jobs may have become READY, so workers with credit should ask for leases again.
  virtual void OnWorkReady() = 0;
  // Called when an attempt's result is not wanted any more (job cancelled, lease lost), so that the
  // worker can be told to stop it.
  virtual void OnStop(const std::string& worker, const v1::AttemptId& attempt,
                      const std::string& reason) = 0;
  // Called when the drain orders have changed; `drains` has all of them.
  virtual void OnDrains(const std::vector<v1::DrainOrder>& /*drains*/) {}
};

// Figures for /metrics, from memory only.
struct JobQueueStats {
  // Number of jobs by (kind, state), for every kind and state, in all studies that are loaded.
  std::map<std::pair<std::string, std::string>, int64_t> jobs;
  int64_t leases_held = 0;
  uint64_t commits = 0;
  uint64_t commands = 0;
  uint64_t leases_granted = 0;
  uint64_t completions = 0;
  uint64_t failures = 0;  // Reported app failures.
  uint64_t losses = 0;    // Infra losses.
  uint64_t stale_reports = 0;
  uint64_t splits = 0;         // Jobs made from rigs of another job.
  uint64_t archived_jobs = 0;  // Jobs moved to the archive.
  double commit_seconds = 0;   // Sum of the time in COMMIT, fsync included.
  double commit_seconds_max = 0;
  uint64_t checkpoints = 0;  // Checkpoints of the WAL, for which commits have to wait.
  double checkpoint_seconds = 0;
  double checkpoint_seconds_max = 0;
  int largest_batch = 0;
  int64_t wal_pages = 0;
  // Cumulative histograms: numbers of commits that took at most so many seconds, and that had at
  // most so many commands. Counts are one longer than their bounds, for +Inf.
  std::vector<double> commit_bounds_s;
  std::vector<uint64_t> commit_counts;
  std::vector<double> batch_bounds;
  std::vector<uint64_t> batch_counts;
};

// A leased job that reports figures.
struct RunningJob {
  int64_t job_id = 0;
  std::string study, kind, label;
  std::map<std::string, double> figures;  // See v1::Progress.
};

class JobQueue {
 public:
  // Opens or creates the database, migrates it forward, commits a new epoch and loads all
  // unfinished studies. Errors: kFailedPrecondition if the database is of a newer version, is open
  // in another coordinator, or is on a network file system; kDataLoss for a file that is not ours
  // or is corrupt; else the system's.
  static absl::StatusOr<std::unique_ptr<JobQueue>> Open(JobQueueOptions options);
  ~JobQueue();  // Finishes accepted commands and closes. Leases stay for the next start to adopt.

  uint64_t epoch() const;
  const KindRegistry& kinds() const;
  // Returns the id of the database, which it and its backups keep for ever. Reports carry the id,
  // so that they can't be mistaken for reports on a job with the same number in another database.
  const std::string& database_id() const;
  int64_t schema_version() const;
  double lease_s() const;
  // Sets the observer; null removes it. Call it before the first call that leases. The observer
  // must outlive the queue or be removed before.
  void SetObserver(JobQueueObserver* observer);

  // ---- Clients. `actor` goes to the audit table.
  // O(variants) whatever the number of pairs. The same idempotency key again returns the first
  // study. Errors: kInvalidArgument for a bad spec; kAlreadyExists for a used key with another
  // study; kFailedPrecondition for more than the user's limits allow, naming the limit.
  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request, std::string_view actor);
  // Cancels a study: its unfinished jobs become CANCELLED, and running attempts are told to stop.
  // Idempotent. Errors: kNotFound; kFailedPrecondition if it has succeeded or failed.
  absl::Status Cancel(StudyId study, std::string_view reason, std::string_view actor);
  // Pause stops new leases of a study's jobs; running attempts continue. Resume ends the pause.
  absl::Status Pause(StudyId study, std::string_view reason, std::string_view actor);
  absl::Status Resume(StudyId study, std::string_view reason, std::string_view actor);
  // Keeps a text with the study, in the audit table. Errors: kInvalidArgument if it is empty.
  absl::Status Comment(StudyId study, std::string_view text, std::string_view actor);
  // Bounds the number of the study's jobs that are leased at a time; 0: no limit of its own. What
  // runs goes on.
  absl::Status SetMaxRunning(StudyId study, int64_t max_running, std::string_view reason,
                             std::string_view actor);
  // Sets the study's priority: from now on its READY jobs are leased before those of studies with a
  // lower one. What runs goes on.
  absl::Status SetPriority(StudyId study, int priority, std::string_view reason,
                           std::string_view actor);
  // Gives failed and quarantined jobs a new generation as far as pairs are missing (a scene that
  // was already replaced isn't made again), and variants that gave up go on. Returns the new jobs.
  // kFailedPrecondition if cancelled, or if the user's limits allow no other unfinished study.
  absl::StatusOr<int64_t> Retry(StudyId study, std::string_view actor,
                                std::string_view reason = "");
  // Retries one job of the study: one that failed, was quarantined or cancelled gets a new
  // generation, with no attempts yet; one that waits for its next attempt gets it now. A variant
  // that gave up does not go on by it. Errors: those of Retry; kNotFound for a job of another
  // study; kFailedPrecondition if the job has not failed, was retried before, or its scene was
  // replaced.
  absl::Status RetryJob(StudyId study, int64_t job, std::string_view reason,
                        std::string_view actor);

  // Removes an ended study for good: its jobs, and the results that no other study uses. The study
  // disappears at once; its rows are removed in the background, and its files become litter.
  // Returns the numbers of its jobs, pairs and results. Errors: kFailedPrecondition if it has not
  // ended.
  absl::StatusOr<v1::ForgetReply> Forget(StudyId study, std::string_view reason,
                                         std::string_view actor);
  // Cancels a study, whatever its state, and forgets it. Returns false while jobs of it still run:
  // call again. True for one that is gone already. Errors: the database's.
  absl::StatusOr<bool> CancelAndForget(StudyId study, std::string_view reason,
                                       std::string_view actor);
  // Orders that workers whose names match `order.pattern` (CheckDrainPattern) get no leases, or
  // undoes that order. The queue only stores the orders and tells the observer. Errors: kNotFound
  // if there is no such order to undo.
  absl::Status Drain(const v1::DrainOrder& order, bool undo);

  // ---- Workers
  // Leases up to `max_jobs` jobs; fewer or none if no more fit the worker.
  absl::StatusOr<std::vector<v1::Lease>> Lease(const WorkerFacts& worker, int max_jobs);
  void LeaseAsync(const WorkerFacts& worker, int max_jobs,
                  std::function<void(absl::StatusOr<std::vector<v1::Lease>>)> done);
  // Reports a result. The outcomes OK, ALREADY_DONE, STALE_FENCE and CANCELLED are final: don't
  // report again. Errors: kInvalidArgument, final too, either because the result does not belong to
  // the job (wrong kind, rigs not asked for, path outside the attempt's folder), and then the
  // attempt has failed; or because the reporter is not the holder, who then continues.
  absl::StatusOr<v1::ReportOutcome> Complete(const v1::CompleteRequest& request);
  // As Complete; `request` need not outlive the call. `invalid` says why the caller knows that the
  // result is wrong (files that are not in the store); empty if it may be right.
  void CompleteAsync(const v1::CompleteRequest& request, const std::string& invalid,
                     std::function<void(absl::StatusOr<v1::ReportOutcome>)> done);
  // Reports that an attempt has failed. Outcomes and errors are those of Complete.
  absl::StatusOr<v1::ReportOutcome> Fail(const v1::FailRequest& request);
  // Ends an attempt without blame, when a worker drains: the job is READY again at once.
  absl::StatusOr<v1::ReportOutcome> HandBack(const std::string& worker,
                                             const v1::AttemptId& attempt, std::string_view reason);
  // Takes in a worker that says Hello with the attempts that it still runs. Returns those that it
  // rightly holds; it must stop all others in `holding`. Leases that the worker does not list are
  // lost. If the worker is the `same_process` as before, their messages never reached it, and the
  // loss is not counted against the job.
  absl::StatusOr<std::vector<v1::AttemptId>> Adopt(const std::string& worker,
                                                   const std::vector<v1::AttemptId>& holding,
                                                   bool same_process = false);
  // Ends all leases of a worker that is lost (its grace is over). Returns their number.
  absl::StatusOr<int> WorkerLost(const std::string& worker);
  // Ends the leases of a worker that has drained and left without blame. Returns their number.
  absl::StatusOr<int> WorkerLeft(const std::string& worker);
  // Renews the leases in `running`. Works in memory and never waits for the disk. Returns the
  // attempts that the worker does not hold (any more) and must stop.
  std::vector<v1::AttemptId> Heartbeat(const std::string& worker,
                                       const std::vector<v1::Progress>& running);

  // Returns whether the worker holds this lease now. Works in memory.
  bool IsHeldBy(const std::string& worker, const v1::AttemptId& attempt) const;
  // Returns the number of leases that the worker holds now. Works in memory.
  int HeldBy(const std::string& worker) const;

  // Expires leases and ends back-offs that are due. Returns the seconds until the next are due.
  // With own_timer, the queue calls it itself.
  absl::StatusOr<double> Tick();
  // Without own_threads: commits the next group of what was accepted or is due, and calls back.
  // Returns false if there was nothing to do.
  bool Work();

  // ---- Reads: own connections, consistent snapshots, never wait for the writer
  absl::StatusOr<v1::StudyStatus> GetStudy(StudyId study);  // With spec.
  // Returns studies, the newest first; with `before`, only those with smaller ids. limit <= 10,000.
  absl::StatusOr<std::vector<v1::StudyStatus>> ListStudies(int limit, int64_t before = 0,
                                                           bool only_unfinished = false);
  // `state` empty: jobs that need attention first, then by progress. A page continues after the
  // last job of the one before (after_job, after_state). limit <= 10,000.
  // Errors: kNotFound if after_job does not exist.
  absl::StatusOr<std::vector<v1::JobStatus>> ListJobs(const v1::ListJobsRequest& request);
  // Returns a job with all its attempts, the newest first. Errors: kNotFound.
  absl::StatusOr<v1::ListAttemptsReply> ListAttempts(int64_t job);
  // Returns the orders to drain.
  absl::StatusOr<std::vector<v1::DrainOrder>> Drains();
  // Returns published frames in the order of publication, after request.cursor. limit <= 10,000; 0
  // stands for 1,000.
  absl::StatusOr<std::vector<v1::PublishedFrame>> ListFrames(const v1::ListFramesRequest& request);
  // Returns results with files of jobs without a scene, in the order in which they ended, after
  // request.cursor. limit <= 10,000; 0 stands for 1,000.
  absl::StatusOr<std::vector<v1::JobResult>> ListResults(const v1::ListResultsRequest& request);
  // Returns the recipe of a solved scene. Errors: kNotFound if it is not solved.
  absl::StatusOr<v1::Scene> GetScene(const v1::GetSceneRequest& request);
  // Returns entries of the audit table, the newest first. limit <= 10,000; 0 stands for 100.
  absl::StatusOr<std::vector<v1::AuditEntry>> ListAudit(const v1::ListAuditRequest& request);
  // Users with unfinished studies and those that have rows of their own in the limits, by name.
  absl::StatusOr<std::vector<v1::UserStatus>> ListUsers();
  // Returns the actor who submitted the study. Errors: kNotFound.
  absl::StatusOr<std::string> SubmitterOf(StudyId study);
  // Returns the studies that the actor's user submitted under idempotency keys that begin with
  // `prefix` and that are not forgotten, by id.
  absl::StatusOr<std::vector<int64_t>> ListSubmitted(const std::string& prefix,
                                                     std::string_view actor);

  // Returns at most 1,000 leased jobs that report figures, by id.
  absl::StatusOr<std::vector<RunningJob>> ListRunning();
  // Returns whether a study is in the archive, where it can't be retried.
  absl::StatusOr<bool> IsArchived(StudyId study);
  // Returns the numbers of READY jobs by what they need of a worker; `study` 0: of all studies.
  // Works in memory; its cost grows with the groups, not with the jobs.
  std::map<ReadyKey, int64_t> ReadyGroups(int64_t study = 0) const;
  // Returns the figures of this process. Works in memory.
  JobQueueStats Stats() const;

  // ---- The farm's figures over time
  // Keeps a sample, at the latest with the next commit; does not wait for it. Samples of the last
  // two days are kept.
  void KeepSample(const HistorySample& sample);
  // Samples since then, the oldest first.
  absl::StatusOr<std::vector<HistorySample>> ListSamples(double since_unix_s);

  // ---- Notices for the operator, and for the receivers of studies
  // Returns notices that are due, the longest due first, at most `limit`.
  absl::StatusOr<std::vector<Notice>> ListNotices(int limit);
  // Adds a notice of an event of notice.h that only its caller knows of, for each target that wants
  // it.
  absl::Status RaiseNotice(StudyId study, const char* event);
  // Removes a notice that its receiver has, or nobody wants; it comes again if it has happened
  // again.
  absl::Status EndNotice(const Notice& notice);
  // Delivers a notice again, but not before `delay_s` from now; at most an hour.
  absl::Status DelayNotice(const Notice& notice, double delay_s);

  // ---- Litter: folders of the store that no result names or ever will
  // Returns paths in the store that became litter at least `older_than_s` seconds ago, the oldest
  // first, at most `limit`.
  absl::StatusOr<std::vector<std::string>> ListLitter(double older_than_s, int limit);
  // Forgets litter that the janitor has removed.
  absl::Status ForgetLitter(const std::vector<std::string>& paths);
  // Returns the folders of all attempts that the database knows, in the store's paths: of results,
  // litter, kept folders and leases. Reads all results.
  absl::StatusOr<std::set<std::string>> ListAttemptFolders();
  // Returns the folders of users' content that the variants of all studies name, without those of
  // forgotten studies. common/store/content.h says how a folder in the store is named. Reads all
  // variants.
  absl::StatusOr<std::vector<std::string>> ListContentFolders();

  // ---- Damage in the store
  // Returns results with files whose keys come after `after` (32 bytes; empty: all), in the order
  // of keys, at most `limit`.
  absl::StatusOr<std::vector<StoredOutput>> ListStoredOutputs(const std::string& after, int limit);
  // Says who has a result, for people: "study 3 (baseline), variant narrow, scene 5, rig 2".
  absl::StatusOr<std::vector<std::string>> ListUsesOf(const Sha256Digest& key);
  // Takes damaged results back: their pairs are no longer published, their networks are no longer
  // those of their studies, and jobs are added that make them again. Results that are not as named
  // are left alone.
  absl::StatusOr<TakenBack> TakeBack(const std::vector<DamagedResult>& damaged,
                                     std::string_view actor);
  // Read and keep the state of the pass that looks for damage; absent: there was none yet.
  absl::StatusOr<std::optional<ScrubState>> GetScrub();
  absl::Status KeepScrub(const ScrubState& scrub);

  // ---- Streams (coordinator/stream)
  // Keeps a stream's record under the name of its study, in place of an earlier one.
  absl::Status KeepStream(const v1::StreamRecord& record);
  // Removes the record of that name, if it is there.
  absl::Status RemoveStream(const std::string& name);
  // Returns all records, by name.
  absl::StatusOr<std::vector<v1::StreamRecord>> ListStreams();

  // ---- Searches (coordinator/search)
  // Keeps a search's record under the name of its study, in place of an earlier one.
  absl::Status KeepSearch(const v1::SearchRecord& record);
  // Removes the record of that name, if it is there.
  absl::Status RemoveSearch(const std::string& name);
  // Returns all records, by name.
  absl::StatusOr<std::vector<v1::SearchRecord>> ListSearches();
  // Returns how long the study's results took to make. Reads all of its pairs and results.
  absl::StatusOr<StudyCosts> CostsOf(StudyId study);

  // ---- Operations
  // Checks every invariant. Returns a line for each violation; empty if all hold. Reads all rows,
  // which takes seconds for a million.
  absl::StatusOr<std::vector<std::string>> Check();
  // Writes a consistent copy of the database to `path` while work continues; see backup.h.
  absl::Status Backup(const std::string& path);

 private:
  class Impl;
  explicit JobQueue(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
