// The job machine: what each command means, as changes of the tables inside the writer's
// transaction. Each method is one command: it either does all of it or returns an error and the
// writer undoes it. Everything that a move implies happens in the same call: followers are
// released, render jobs inserted, lost scenes entered as missing, counters kept.
//
// Sharing of work. At most one attempt at a time computes a given layout or scene or set of frames:
// when a job is leased, READY jobs that need the same thing become BLOCKED on it; whatever ends the
// lease, each of them is settled anew (a result is there: done; somebody else computes it: BLOCKED
// on that; else READY). So a BLOCKED job always awaits a LEASED one, and nothing can be stuck
// behind a paused study, a back-off or a worker that never comes.
//
// Used by the writing thread only.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "coordinator/queue/hints.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/job_store.h"
#include "coordinator/queue/ledger.h"
#include "coordinator/queue/report_check.h"
#include "coordinator/study/expansion.h"

namespace parallax {

// A lease as committed; its payload (layout, recipe) is fetched by the reader that hands it out.
struct GrantedLease {
  int64_t job = 0;
  uint64_t fence = 0;
  std::string worker;
  WorkKind kind = WorkKind::kSolve;
  int attempt_number = 0;
  std::string study;
  std::string variant;
  uint32_t ordinal = 0;
  SceneSeed seed;
  std::shared_ptr<const v1::SceneConfig> config;
  std::string rigs;
  Sha256Digest work_key{};
  Sha256Digest group_key{};
  bool layout_given = false;
};

// A lease's begin or end, for what is kept of leases in memory.
struct LeaseRef {
  int64_t job = 0;
  uint64_t fence = 0;
  std::string worker;
  bool stop = false;  // It ended against its worker's will: tell it, and why.
  std::string reason;
};

// What must happen outside the database once the command is on disk.
struct Effects {
  std::vector<LeaseRef> granted;
  std::vector<LeaseRef> ended;
  bool work_ready = false;
  uint64_t completions = 0, failures = 0, losses = 0, stale = 0, splits = 0, archived = 0;
};

class Machine {
 public:
  // `options` and `db` must outlive the machine.
  Machine(SqliteConnection& db, const JobQueueOptions& options, uint64_t epoch);

  absl::Status Load();
  Ledger& ledger() { return ledger_; }

  // ---- Commands ---------------------------------------------------------------------------------
  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request, std::string_view actor);
  absl::Status Cancel(int64_t study, std::string_view reason, std::string_view actor);
  absl::Status SetPaused(int64_t study, bool paused, std::string_view reason,
                         std::string_view actor);
  absl::StatusOr<int64_t> Retry(int64_t study, std::string_view actor);
  absl::StatusOr<std::vector<GrantedLease>> Lease(const WorkerFacts& worker, int max_jobs);
  struct Verdict {
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;
    std::string
        invalid;  // Not empty: the result did not belong to the job; the attempt has failed for it.
  };
  absl::StatusOr<Verdict> Complete(const CheckedReport& report);
  absl::StatusOr<v1::ReportOutcome> Fail(const v1::FailRequest& request);
  absl::StatusOr<v1::ReportOutcome> HandBack(const std::string& worker,
                                             const v1::AttemptId& attempt, std::string_view reason);
  absl::StatusOr<std::vector<v1::AttemptId>> Adopt(const std::string& worker,
                                                   const std::vector<v1::AttemptId>& holding,
                                                   bool same_process);
  absl::StatusOr<int> WorkerLost(const std::string& worker);
  // These leases were not heard of in time.
  absl::Status Expire(const std::vector<LeaseRef>& leases);
  // Ends back-offs that are due.
  absl::Status WakeRetries();
  absl::Status ForgetLitter(const std::vector<std::string>& paths);
  // Moves up to `limit` jobs of a study that is finished for long to the
  // archive. True if there may be more.
  absl::StatusOr<bool> Archive(int limit);
  // Makes at most `limit` of the scenes that variants need. True if more are
  // needed and may be made now.
  absl::StatusOr<bool> Expand(int64_t limit);
  bool WantsExpansion() const { return !hungry_.empty(); }
  // Marks changed studies finished or not. Once a group, before Ledger::Flush.
  absl::Status Settle();

  absl::StatusOr<std::optional<double>> NextBackoff() { return store_.NextBackoff(); }

  void BeginCommand();
  absl::Status EndCommand();  // Writes what the command kept back. Not after an error.
  void UndoCommand();
  // The group is on disk.
  void Committed() { hints_.Committed(); }
  // Effects of the commands since the last call.
  Effects TakeEffects();
  // The group was rolled back: everything is read again.
  absl::Status Reload();

 private:
  // machine_jobs.cc: jobs come, move and go.
  absl::Status InsertSolve(Study& study, Variant& variant, uint32_t ordinal, int generation);
  absl::Status InsertRender(Study& study, Variant& variant, uint32_t ordinal,
                            const Sha256Digest& scene_hash, std::vector<uint32_t> rigs,
                            int generation, bool new_recipe = false);
  struct Standing {  // Where a job that nobody holds belongs.
    JobState state = JobState::kReady;
    bool no_layout = false;  // A solve whose layout nobody has made yet.
    int64_t awaits_job = 0;
    std::optional<Sha256Digest> scene_hash;
    std::string rejected;
  };
  absl::StatusOr<Standing> StandingOf(const JobRow& job, const Variant& variant);
  // BLOCKED on whoever computes what the job needs, else READY.
  absl::StatusOr<Standing> StandingAmongLeased(const JobRow& job, bool whole_group);
  absl::Status SettleJob(int64_t job);
  absl::Status ReleaseFollowers(int64_t leader);
  absl::Status BlockSiblings(const JobRow& leader, bool whole_group);
  // Leaves `job` the first of its rigs and makes jobs of the rest, if slots
  // would idle otherwise.
  absl::Status SplitIfIdle(JobRow& job, const WorkerFacts& worker);
  // Nothing but the READY renders is left to do.
  bool OnlyRendersLeft() const;
  absl::Status PublishReused(const JobRow& job, Variant& variant, std::span<const uint32_t> rigs);
  struct SceneChange {
    int jobs_open = 0;
    int rigs_lost = 0;
    bool all_lost = false;
    int rigs_done = 0;
    std::optional<Sha256Digest> scene_hash;
  };
  absl::StatusOr<SceneRow> ChangeScene(Variant& variant, uint32_t ordinal,
                                       const SceneChange& change);
  // The scene as this command sees it; with `change`, it is written when the
  // command ends or goes on to another scene. The pointer lives until then.
  absl::StatusOr<SceneRow*> OpenScene(int64_t variant, uint32_t ordinal, bool change);
  absl::Status FlushScene();
  // Counts a job that is new or has moved, in the ledger and the hints.
  void NoteNew(Variant& variant, const JobRow& job);
  void NoteMove(Variant& variant, const JobRow& before, JobState to, int64_t awaits_job = 0);
  absl::Status Solved(const JobRow& job, Study& study, Variant& variant,
                      const Sha256Digest& scene_hash, bool new_recipe);
  absl::Status EnterLoss(const JobRow& job, Variant& variant, JobState state);
  absl::Status CancelJobs(int64_t study, int64_t variant, const std::string& reason);
  absl::Status GiveUpIfHopeless(Variant& variant);
  absl::Status TopUp(Study& study, Variant& variant, const ScenePlan& scene);

  // machine_report.cc: leases end.
  struct Holding {
    JobRow job;
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;  // OK: the attempt holds the job.
  };
  absl::StatusOr<Holding> HoldingOf(const v1::AttemptId& attempt);
  absl::Status CompleteSolve(const JobRow& job, const CheckedReport& report);
  absl::Status CompleteRender(const JobRow& job, const CheckedReport& report);
  std::string WhyNotOf(const JobRow& job, const Variant& variant, const CheckedReport& report);
  struct AppFailure {
    std::string worker, error, fingerprint;
    bool retryable = true;
  };
  absl::Status FailAttempt(const JobRow& job, const AppFailure& failure);
  enum class LossKind { kLost, kReturned };
  // `now`: the same for all that one worker loses at one time.
  absl::Status LoseAttempt(const JobRow& job, LossKind kind, const std::string& reason, bool stop,
                           double now);
  absl::Status EndAttempt(const JobRow& job, const LossUpdate& update);
  // The folder of an attempt that will not win.
  absl::Status Litter(const JobRow& job);
  absl::Status LitterOfLate(const JobRow& job, const CheckedReport& report);

  // machine.cc: choosing.
  absl::StatusOr<std::optional<JobRow>> Choose(const WorkerFacts& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseOf(Study& study, WorkKind kind,
                                                 const WorkerFacts& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseWarm(const WorkerFacts& worker);
  absl::StatusOr<GrantedLease> Grant(JobRow job, const WorkerFacts& worker);
  bool OthersAround(const std::string& worker);
  StudyShare ShareOf(Study& study, const WorkerFacts& worker);
  uint64_t NextFence() { return (epoch_ << 32) | ++sequence_; }
  double Now() { return options_.clock->UnixSeconds(); }
  double SteadySeconds();

  SqliteConnection& db_;
  const JobQueueOptions& options_;
  const uint64_t epoch_;
  JobStore store_;
  Ledger ledger_;
  uint32_t sequence_ = 0;
  std::set<int64_t> hungry_;  // Variants that may need scenes; a superset.
  double virtual_pass_ = 0;   // Of the study served last.
  int64_t leased_now_ = 0;
  int idle_slots_ = 0;  // Render slots that the Lease at hand hasn't filled yet.
  JobHints hints_;
  // READY solves that had no layout to share when they became READY. As long as
  // they are READY nobody makes one (they would be BLOCKED on it), so it
  // needn't be looked for.
  std::unordered_set<int64_t> without_layout_;
  struct {
    int64_t variant = 0;  // 0: none is open.
    uint32_t ordinal = 0;
    SceneRow row;
    bool is_new = false;
    bool changed = false;
  } scene_;

  // What the scheduler remembers of workers; forgotten at restart.
  struct WorkerMemory {
    double seen_s = 0;
    std::deque<Sha256Digest> scenes;  // Built most recently first.
  };
  std::map<std::string, WorkerMemory> workers_;
  // What workers that were given up held, by job and fence. A guess, as long as nobody remembers
  // them after a restart: it only spares jobs.
  std::map<std::string, std::vector<std::pair<int64_t, uint64_t>>> given_up_;

  Effects effects_;
  size_t granted_mark_ = 0, ended_mark_ = 0;
  Effects counters_mark_;
};

}  // namespace parallax
