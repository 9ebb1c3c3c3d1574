// The state machine of jobs: carries out each command as changes of the tables, inside the writer's
// transaction. A method is one command. It does the whole command, or returns an error and the
// writer undoes it. All consequences of a move happen in the same call: followers are released,
// jobs that a success makes possible are inserted, lost scenes are noted as missing, counters are
// kept. The machine never names a kind of job; it asks the KindRegistry for the differences.
//
// Sharing of work. At most one attempt at a time does a given piece of work, or makes a group's
// part. When a job is leased, READY jobs that need the same become BLOCKED on it. When the lease
// ends, for whatever reason, each of them is settled again: done if there is a result, BLOCKED on
// another job that computes it, else READY. So such a BLOCKED job always awaits a LEASED one, and
// can't be stuck behind a paused study, a back-off or a worker that never comes.
//
// Waiting for work. A job that waits for other jobs or for a variant's pairs is BLOCKED with OPEN
// rows in `waits`. While a command runs, it notes which jobs and variants end. Before the command
// ends, each waiter whose last wait is met is settled, and each that waits in vain is cancelled.
//
// Used by the writing thread only.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/commands/loss_evidence.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/reads/farm_history.h"
#include "coordinator/queue/tables/job_archive.h"
#include "coordinator/queue/tables/job_store.h"
#include "coordinator/queue/tables/ledger.h"
#include "coordinator/queue/tables/left_folders.h"
#include "coordinator/queue/tables/loss_table.h"
#include "coordinator/queue/tables/ready_board.h"
#include "coordinator/queue/tables/result_table.h"
#include "coordinator/queue/tables/scene_table.h"
#include "coordinator/queue/tables/waits.h"
#include "coordinator/study/expansion.h"

namespace parallax {

// A committed lease. The reader that hands it out writes its spec.
struct GrantedLease {
  LeasedJob work;
  uint64_t fence = 0;
  std::string worker;
  int attempt_number = 0;
  std::string study;
  std::string variant;
};

// The begin or the end of a lease, for the records of leases in memory.
struct LeaseRef {
  int64_t job = 0;
  uint64_t fence = 0;
  std::string worker;
  bool stop = false;  // The worker still works on it and must be told to stop, and why.
  std::string reason;
  // How the lease ended, if it did; see LossEvidence.
  LeaseEnd end = LeaseEnd::kOver;
  std::string machine = {};  // Its worker's, if that was lost.
  double progress = 0;
};

struct EffectCounts {
  bool work_ready = false;
  uint64_t completions = 0, failures = 0, losses = 0, stale = 0, splits = 0, archived = 0;
  uint64_t workers_lost = 0;
  std::shared_ptr<const std::vector<v1::DrainOrder>> drains;  // All orders, if they have changed.
};
// The effects of commands outside of the database, for when they are on disk.
struct Effects : EffectCounts {
  std::vector<LeaseRef> granted;
  std::vector<LeaseRef> ended;
  ReadyChanges ready;
};

class Machine final : private WorkDesk {
 public:
  // `options` and `db` must outlive the machine.
  Machine(SqliteConnection& db, const JobQueueOptions& options, uint64_t epoch);

  // Reads all unfinished studies. Call it first. Errors: the database's.
  absl::Status Load();
  Ledger& ledger() { return ledger_; }
  // Sets the function that says how far a leased job has come, in a measure that grows; 0 if nobody
  // knows. By default nobody does.
  void SetProgress(std::function<double(int64_t job)> progress_of) {
    progress_of_ = std::move(progress_of);
  }

  // ---- Commands ---------------------------------------------------------------------------------
  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request, std::string_view actor);
  absl::Status Cancel(int64_t study, std::string_view reason, std::string_view actor);
  absl::Status SetPaused(int64_t study, bool paused, std::string_view reason,
                         std::string_view actor);
  // Errors: kNotFound; the database's.
  absl::Status SetMaxRunning(int64_t study, int64_t max_running, std::string_view reason,
                             std::string_view actor);
  absl::StatusOr<int64_t> Retry(int64_t study, std::string_view actor);
  // The commands are those of JobQueue; see job_queue.h. Errors: kNotFound; kFailedPrecondition if
  // the study has not ended.
  absl::StatusOr<v1::ForgetReply> Forget(int64_t study, std::string_view reason,
                                         std::string_view actor);
  // Removes up to `limit` rows of a forgotten study. Returns true if there may be more. Errors: the
  // database's.
  absl::StatusOr<bool> RemoveForgotten(int limit);
  // Errors: kNotFound if there is no such order to undo.
  absl::Status Drain(const v1::DrainOrder& order, bool undo);
  absl::StatusOr<std::vector<GrantedLease>> Lease(const WorkerFacts& worker, int max_jobs);
  struct Verdict {
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;
    // Why the result does not belong to the job, for which the attempt has failed; else empty.
    std::string invalid;
  };
  absl::StatusOr<Verdict> Complete(const CheckedReport& report);
  absl::StatusOr<v1::ReportOutcome> Fail(const v1::FailRequest& request);
  absl::StatusOr<v1::ReportOutcome> HandBack(const std::string& worker,
                                             const v1::AttemptId& attempt, std::string_view reason);
  absl::StatusOr<std::vector<v1::AttemptId>> Adopt(const std::string& worker,
                                                   const std::vector<v1::AttemptId>& holding,
                                                   bool same_process);
  absl::StatusOr<int> WorkerLost(const std::string& worker);
  // Errors: the database's.
  absl::StatusOr<int> WorkerLeft(const std::string& worker);
  // Ends leases that were not heard of in time.
  absl::Status Expire(const std::vector<LeaseRef>& leases);
  // Stores a sample of the farm's figures. Removes samples that are older than two days, and
  // samples from the future, which exist after the clock was set back. Errors: the database's.
  absl::Status KeepSample(const HistorySample& sample);
  // Ends back-offs that are due.
  absl::Status WakeRetries();
  absl::Status ForgetLitter(const std::vector<std::string>& paths);
  // Errors: those of AddJob.
  absl::StatusOr<TakenBack> TakeBack(const std::vector<DamagedResult>& damaged,
                                     std::string_view actor);
  // Errors: the database's.
  absl::Status KeepScrub(const ScrubState& scrub);
  // Moves up to `limit` jobs of a study that finished long ago to the archive. Returns true if
  // there may be more.
  absl::StatusOr<bool> Archive(int limit);
  // Makes at most `limit` of the scenes that variants need. Returns true if more are needed and may
  // be made now.
  absl::StatusOr<bool> Expand(int64_t limit);
  // Returns whether some variant may need new scenes.
  bool WantsExpansion() const { return !hungry_.empty(); }
  // Marks changed studies as finished or not. Call it once for each group, before Ledger::Flush.
  absl::Status Settle();

  absl::StatusOr<std::optional<double>> NextBackoff() { return store_.NextBackoff(); }

  // Every command runs between BeginCommand and either EndCommand or UndoCommand.
  void BeginCommand();
  absl::Status EndCommand();  // Writes the command's delayed changes. Not after an error.
  void UndoCommand();
  // Returns the effects of the commands since the last call.
  Effects TakeEffects();
  // Reads everything again, after the group was rolled back.
  absl::Status Reload();

 private:
  // A worker that asks for leases.
  struct Taker {
    const WorkerFacts& facts;
    std::array<bool, kMostKinds> takes{};      // By kind: it meets the kind's needs.
    std::array<int, kMostKinds> idle_slots{};  // The farm's, that this call has not filled yet.
    std::array<int, kMostKinds> slots{};
  };

  // machine_desk.cc: the reads and changes of kinds; see WorkDesk.
  const StageVersions& versions() const override { return options_.versions; }
  absl::StatusOr<VariantFacts> VariantOf(int64_t variant) override;
  absl::StatusOr<SceneFacts> SceneOf(int64_t variant, uint32_t ordinal) override;
  absl::StatusOr<JobFacts> NewestOf(int64_t job) override;
  absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key) override;
  absl::StatusOr<bool> HasResult(const Sha256Digest& key) override;
  absl::StatusOr<bool> PutResult(const JobFacts& by, std::string_view stage,
                                 const Sha256Digest& key, const StoredResult& result) override;
  absl::Status SetScene(const JobFacts& job, const Sha256Digest& scene_hash) override;
  absl::Status Publish(const JobFacts& job, std::span<const FrameLink> frames) override;
  absl::Status Discard(std::string_view path) override;
  absl::StatusOr<int64_t> AddJob(const NewJob& job) override;

  // machine_jobs.cc: adds, moves and ends jobs.
  absl::StatusOr<JobRow> RowOf(int64_t id);  // Errors: kInternal if there is no such job.
  const JobKind& KindOf(const JobFacts& job) const { return kinds_[job.kind]; }
  struct Standing {  // The state in which a job without a lease belongs.
    JobState state = JobState::kReady;
    bool part_missing = false;  // Its group's part does not exist yet.
    int64_t awaits_job = 0;
    std::string result;    // Set with kSucceeded; see KnownWork.
    std::string rejected;  // Set with kRejected: the reason.
  };
  absl::StatusOr<Standing> StandingOf(const JobRow& job);
  // Returns BLOCKED if a leased job computes what this one needs, else READY.
  absl::StatusOr<Standing> StandingAmongLeased(const JobRow& job, bool whole_group);
  // Moves a job without a lease to the state where it belongs. `waits_met`: its waits are over.
  absl::Status SettleJob(int64_t job, bool waits_met = false);
  absl::Status ReleaseFollowers(int64_t leader);
  absl::Status BlockSiblings(const JobRow& leader, bool whole_group);
  // Splits `job` if slots would idle otherwise: it keeps the first of its rigs, and new jobs get
  // the rest.
  absl::Status SplitIfIdle(JobRow& job, const Taker& worker);
  // Returns whether only READY jobs of this kind are left to do for scenes.
  bool OnlyTheseLeft(KindId kind) const;
  struct SceneChange {
    int jobs_open = 0;
    int rigs_lost = 0;
    bool all_lost = false;
    int rigs_done = 0;
    std::optional<Sha256Digest> scene_hash;
  };
  absl::StatusOr<SceneRow> ChangeScene(Variant& variant, uint32_t ordinal,
                                       const SceneChange& change);
  // Returns the scene as the current command sees it. With `change`, the scene is written when the
  // command ends or opens another scene. The pointer is valid until then.
  absl::StatusOr<SceneRow*> OpenScene(int64_t variant, uint32_t ordinal, bool change);
  absl::Status FlushScene();
  // Counts a job that has moved.
  void NoteMove(Variant& variant, const JobRow& before, JobState to);
  // Counts a job that has become READY (`change` 1) or no longer is (-1). Its study is loaded.
  void CountReady(const JobRow& job, int64_t change);
  // Carry out the consequences of a job that has succeeded or was lost. Its row is written already.
  absl::Status EnterSuccess(const JobRow& job, Variant& variant, const Ending& ending,
                            bool by_own_attempt);
  absl::Status EnterLoss(const JobRow& job, Variant& variant, JobState state);
  // Cancels the unfinished jobs of a variant, or of the whole study if `variant` is 0.
  absl::Status CancelJobs(int64_t study, int64_t variant, const std::string& reason,
                          bool only_of_scenes = false);
  absl::Status CancelJob(const JobRow& job, const std::string& reason);
  // Ends the variant if it has no prospect. `job` was lost or rejected last and says why.
  absl::Status GiveUpIfHopeless(Variant& variant, int64_t job);

  // machine_expand.cc: makes scenes.
  absl::Status TopUp(Variant& variant, const ScenePlan& scene);

  // machine_limits.cc: the limits of users and studies.
  // Checks that the user may have `studies` more unfinished studies, with `pairs` more pairs to
  // make. Errors: kFailedPrecondition naming the first limit that does not allow it.
  absl::Status CheckUser(const std::string& user, int64_t studies, int64_t pairs);
  // Returns how many more jobs of the study may be leased now.
  static int64_t RoomOf(const Study& study);

  // machine_retry.cc: makes new generations of jobs.
  absl::StatusOr<bool> RetryOfScene(Variant& variant, const JobRow& job);
  absl::StatusOr<bool> RetryOther(Variant& variant, const JobRow& job);

  // machine_repair.cc: takes damaged results back and asks for them again.
  using SceneId = std::pair<int64_t, uint32_t>;  // Variant and ordinal.
  absl::StatusOr<std::string> FolderOfResult(const Sha256Digest& key);
  // Take back what studies have of a result. Add the pairs and jobs to make again.
  absl::Status TakePairsBack(const DamagedResult& result, TakenBack& taken,
                             std::map<SceneId, std::vector<uint32_t>>& lost);
  absl::Status TakeStudyResultsBack(const Sha256Digest& key, std::vector<int64_t>& jobs);
  absl::StatusOr<bool> GoesOn(int64_t study);
  absl::Status AskForPairs(int64_t variant, uint32_t ordinal, std::vector<uint32_t> rigs);
  absl::Status AskForResult(int64_t job);
  absl::StatusOr<bool> HasWhatItWaitedFor(const JobRow& job);
  // Returns whether the files of a stored result are there. If not, it is taken back at the end of
  // the command.
  bool FilesAreThere(const Sha256Digest& key, std::string_view stage, std::string_view bytes);

  // machine_forget.cc: drains workers and forgets studies.
  absl::Status NoSuchDrain(const std::string& pattern);
  absl::StatusOr<bool> RemoveSomeOf(int64_t study, int limit);
  absl::StatusOr<int> RemoveReferences(int64_t study, const char* table, const char* key,
                                       int limit);
  absl::StatusOr<int> RemoveScenes(int64_t study, int limit);
  struct Twins {
    std::vector<int64_t> of_layout, of_scene;
  };
  absl::StatusOr<Twins> TwinsOf(int64_t variant);
  absl::StatusOr<bool> AnyHasScene(const std::vector<int64_t>& variants, uint32_t ordinal);
  absl::Status RemoveScene(int64_t variant, uint32_t ordinal,
                           const std::optional<Sha256Digest>& recipe, const Twins& twins);
  absl::Status RemoveResult(const Sha256Digest& key);

  // machine_waits.cc: lets jobs wait for jobs and for pairs.
  enum class Prospect { kMet, kOpen, kVain };
  struct Outlook {
    Prospect prospect = Prospect::kOpen;
    std::string why;  // Set with kVain: "job 12, which it waits for, is FAILED".
  };
  absl::StatusOr<Outlook> OutlookOf(const JobWait& wait);
  // Sets the state of a new job with waits: BLOCKED, or CANCELLED if it would wait in vain. Returns
  // the states of its rows, in the order of `waits`.
  absl::StatusOr<std::vector<const char*>> PlanWaits(const std::vector<JobWait>& waits,
                                                     JobRow& job);
  absl::Status SettleWaiters();  // Settles waiters for all that has ended in this command.
  absl::Status Release(int64_t waiter);
  absl::Status CancelWaiters(const std::vector<int64_t>& waiters, const std::string& why);

  // machine_report.cc: ends leases.
  struct Holding {
    JobRow job;
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;  // OK if the attempt holds the job.
  };
  absl::StatusOr<Holding> HoldingOf(const v1::AttemptId& attempt);
  absl::Status StoreResult(const JobRow& job, const CheckedReport& report);
  absl::StatusOr<std::string> WhyNotOf(const JobRow& job, const CheckedReport& report);
  std::string WhyNotHolder(const JobRow& job, const std::string& worker) const;
  struct AppFailure {
    std::string worker, error, fingerprint;
    bool retryable = true;
    std::string log_tail;
  };
  absl::Status FailAttempt(const JobRow& job, const AppFailure& failure);
  enum class LossKind { kLost, kReturned };
  // Returns whether the job is to blame for the loss of its worker.
  absl::StatusOr<bool> IsToBlame(const JobRow& job, double progress, double now);
  std::string MachineOf(const std::string& worker) const;
  int Machines() const;  // Different machines of the workers that are around.
  double ProgressOf(const JobRow& job) const;
  // `now` must be the same for all attempts that a worker loses at one time.
  absl::Status LoseAttempt(const JobRow& job, LossKind kind, const std::string& reason, bool stop,
                           double now);
  absl::Status EndAttempt(const JobRow& job, const LossUpdate& update);
  // Makes litter of the folder of an attempt that will not win, or keeps it if later attempts may
  // continue from it.
  absl::Status Litter(const JobRow& job);
  absl::Status LitterOfLate(const JobRow& job, const CheckedReport& report);

  // machine_lease.cc: chooses jobs for workers.
  absl::StatusOr<Taker> TakerOf(const WorkerFacts& worker) const;
  absl::StatusOr<std::optional<JobRow>> Choose(const Taker& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseOf(Study& study, KindId kind, const Taker& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseWarm(const Taker& worker);
  bool FitsJob(const JobRow& job, const Taker& worker) const;  // Meets the job's own needs.
  absl::StatusOr<GrantedLease> Grant(JobRow job, const Taker& worker);
  bool OthersAround(const std::string& worker);
  StudyShare ShareOf(Study& study, const Taker& worker);

  // machine.cc
  // Adds an entry to the audit table. `study` is 0 if the action concerns none.
  absl::Status Audit(std::string_view actor, std::string_view action, int64_t study,
                     std::string_view detail);
  uint64_t NextFence() { return (epoch_ << 32) | ++sequence_; }
  double Now() { return options_.clock->UnixSeconds(); }
  double SteadySeconds();

  SqliteConnection& db_;
  const JobQueueOptions& options_;
  const KindRegistry& kinds_;
  const uint64_t epoch_;
  JobStore store_;
  LossTable losses_;
  SceneTable scenes_;
  ResultTable results_;
  LeftFolders folders_;
  JobArchive archive_;
  WaitTable waits_;
  Ledger ledger_;
  uint32_t sequence_ = 0;
  std::set<int64_t> hungry_;  // Variants that may need scenes; a superset.
  double virtual_pass_ = 0;   // Pass of the study that was served last.
  int64_t leased_now_ = 0;
  // READY jobs whose group had no part when they became READY. While they are READY, no job makes
  // the part (they would be BLOCKED on it), so it need not be looked for.
  std::unordered_set<int64_t> without_part_;
  uint64_t ending_fence_ = 0;           // Fence of the attempt whose result is being stored.
  std::vector<DamagedResult> missing_;  // Results that the current command found without files.
  // Jobs and variants that have ended in the current command and whose waiters are not settled yet.
  std::vector<std::pair<int64_t, JobState>> ended_jobs_;
  std::set<int64_t> changed_variants_;  // They published pairs, gave up or were cancelled.
  struct {
    int64_t variant = 0;  // 0: none is open.
    uint32_t ordinal = 0;
    SceneRow row;
    bool is_new = false;
    bool changed = false;
  } scene_;

  // The scheduler's memory of workers; forgotten at a restart.
  struct WorkerMemory {
    double seen_s = 0;
    std::string machine;              // Empty: not known.
    std::deque<Sha256Digest> groups;  // Groups that are warm there, the latest first.
  };
  std::map<std::string, WorkerMemory> workers_;
  LossEvidence evidence_;
  std::function<double(int64_t job)> progress_of_;
  // Jobs and fences of workers that were given up, by worker. Forgotten at a restart, so it is only
  // a guess, which may spare jobs a loss.
  std::map<std::string, std::vector<std::pair<int64_t, uint64_t>>> given_up_;

  Effects effects_;
  size_t granted_mark_ = 0, ended_mark_ = 0, ready_mark_ = 0;
  EffectCounts counts_mark_;
};

// Returns the orders to drain, sorted by pattern. Errors: the database's.
absl::StatusOr<std::vector<v1::DrainOrder>> ListDrains(SqliteConnection& db);

}  // namespace parallax
