#include "worker/agent/attempts/job_slots.h"

#include <time.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/log.h"
#include "common/base/system/log_capture.h"
#include "common/store/store.h"
#include "worker/agent/attempts/attempt_report.h"
#include "worker/agent/attempts/failure.h"
#include "worker/agent/attempts/job_run.h"

namespace parallax {
namespace {

constexpr double kTellingFraction = 0.2;  // Progress from which its speed is used.
constexpr double kNewestWeighs = 0.25;    // Weight of a new duration in its kind's mean.

double ProcessCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

using Outcome = absl::StatusOr<JobOutcome>;

bool SameAttempt(const v1::AttemptId& a, const v1::AttemptId& b) {
  return a.job_id() == b.job_id() && a.fence() == b.fence();
}

const char* CauseName(StopCause cause) {
  switch (cause) {
    case StopCause::kNone:
      return "none";
    case StopCause::kCoordinator:
      return "stopped by the coordinator";
    case StopCause::kHandBack:
      return "handed back";
    case StopCause::kLeaseLost:
      return "lease lost";
    case StopCause::kHung:
      return "hung";
  }
  return "";
}

}  // namespace

class JobSlots::Impl {
  struct Run {
    v1::Lease lease;
    AttemptFolder folder;
    std::string coordinator_id;
    CancelToken cancel;
    SteadyTime started{};
    std::shared_ptr<const LogCapture> log;  // Set before it works, for good.
    // Guarded by mu_.
    StopCause stop = StopCause::kNone;
    double fraction = 0;
    std::string stage;
    JobFigures figures;
    std::string program_log;  // Path of the log of a program that it runs.
    SteadyTime progressed{};  // When it last told its progress.
    double cpu_s = 0;
    bool working = false;
  };

 public:
  Impl(int slots, std::string worker, const JobHandlers& handlers, Clock& clock, ReportSink sink,
       std::function<void()> on_end)
      : slots_(slots),
        worker_(std::move(worker)),
        handlers_(handlers),
        clock_(clock),
        sink_(std::move(sink)),
        on_end_(std::move(on_end)),
        cpu_seen_s_(ProcessCpuSeconds()) {
    for (int i = 0; i < slots; ++i) threads_.emplace_back([this] { Loop(); });
  }

  ~Impl() {
    {
      std::lock_guard lock(mu_);
      closing_ = true;
      for (const auto& run : runs_) StopRun(*run, StopCause::kHandBack);
    }
    work_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  bool Start(v1::Lease lease, AttemptFolder folder, std::string coordinator_id) {
    std::lock_guard lock(mu_);
    if (static_cast<int>(runs_.size()) >= 2 * slots_) return false;
    auto run = std::make_shared<Run>();
    run->lease = std::move(lease);
    run->folder = std::move(folder);
    run->coordinator_id = std::move(coordinator_id);
    runs_.push_back(run);
    waiting_.push_back(run);
    work_.notify_one();
    return true;
  }

  bool Stop(const v1::AttemptId& attempt, StopCause cause) {
    std::lock_guard lock(mu_);
    for (const auto& run : runs_) {
      if (!SameAttempt(run->lease.attempt(), attempt)) continue;
      StopRun(*run, cause);
      return true;
    }
    return false;
  }

  void StopAll(StopCause cause) {
    std::lock_guard lock(mu_);
    for (const auto& run : runs_) StopRun(*run, cause);
  }

  bool Abandon(const v1::AttemptId& attempt) {
    std::shared_ptr<Run> hung;
    std::string place;
    double idle_s = 0;
    {
      std::lock_guard lock(mu_);
      for (const auto& run : runs_) {
        if (SameAttempt(run->lease.attempt(), attempt) && run->stop == StopCause::kNone) hung = run;
      }
      if (hung == nullptr) return false;
      StopRun(*hung, StopCause::kHung);
      place = PlaceOf(*hung);
      idle_s = SecondsBetween(hung->progressed, clock_.Steady());
    }
    const absl::Status status = DeadlineExceeded("no progress for {} s", static_cast<int>(idle_s));
    sink_(FailReport(hung->lease, NamesOf(*hung), WithLog(status, *hung), place));
    return true;
  }

  std::vector<RunningAttempt> Running() const {
    std::lock_guard lock(mu_);
    std::vector<RunningAttempt> running;
    for (const auto& run : runs_) {
      const double idle_s = run->working ? SecondsBetween(run->progressed, clock_.Steady()) : 0;
      running.push_back({run->lease.attempt(), run->stop, run->fraction, run->stage, run->figures,
                         idle_s, !run->working, RemainingSeconds(*run), run->log,
                         run->program_log});
    }
    return running;
  }

  int busy() const {
    std::lock_guard lock(mu_);
    return static_cast<int>(runs_.size());
  }

  std::vector<v1::AttemptId> TakeWaiting() {
    std::lock_guard lock(mu_);
    std::vector<v1::AttemptId> taken;
    for (const auto& waiting : waiting_) {
      taken.push_back(waiting->lease.attempt());
      std::erase(runs_, waiting);
    }
    waiting_.clear();
    return taken;
  }

  std::vector<EndedAttempt> TakeEnded() {
    std::lock_guard lock(mu_);
    return std::move(ended_);
  }

 private:
  // Requires mu_.
  double RemainingSeconds(const Run& run) const {
    if (!run.working) return std::numeric_limits<double>::infinity();
    const double elapsed_s = SecondsBetween(run.started, clock_.Steady());
    if (run.fraction >= kTellingFraction) return elapsed_s * (1 - run.fraction) / run.fraction;
    const auto usual = usual_s_.find(run.lease.kind());
    if (usual == usual_s_.end()) return std::numeric_limits<double>::infinity();
    return std::max(0.0, usual->second - elapsed_s);
  }

  static void StopRun(Run& run, StopCause cause) {
    if (run.stop == StopCause::kNone) run.stop = cause;
    run.cancel.Cancel();
  }

  void Loop() {
    while (true) {
      std::shared_ptr<Run> run;
      {
        std::unique_lock lock(mu_);
        work_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        run = std::move(waiting_.front());
        waiting_.pop_front();
        ChargeCpu();
        run->started = run->progressed = clock_.Steady();
        run->working = true;
        run->log = std::make_shared<LogCapture>(run->lease.attempt().fence());
      }
      Work(*run);
    }
  }

  void Work(Run& run) {
    LogContext names;
    names.job = run.lease.attempt().job_id();
    names.attempt = run.lease.attempt().fence();
    names.study = run.lease.study();
    names.variant = run.lease.variant();
    names.scene = run.lease.scene();
    ScopedLogContext scope(names);
    LogInfo("job started", {{"kind", run.lease.kind()}, {"try", run.lease.attempt_number()}});
    const Outcome outcome = run.cancel.cancelled()          ? Cancelled("before it started")
                            : IsStoreGone(LookAtStore(run)) ? Unavailable("the store is gone")
                                                            : Perform(run);
    Finish(run, outcome);
  }

  // OK where this machine sees no store.
  static absl::Status LookAtStore(const Run& run) {
    return run.folder.path.empty() || run.folder.store == nullptr ? absl::OkStatus()
                                                                  : run.folder.store->CheckMarker();
  }

  Outcome Perform(Run& run) {
    const JobProgressFn progress(
        [this, &run](double fraction, std::string_view stage, const JobFigures& figures) {
          const SteadyTime now = clock_.Steady();
          std::lock_guard lock(mu_);
          run.fraction = fraction;
          run.stage = stage;
          run.figures = figures;
          run.progressed = now;
        },
        [this, &run](const std::string& path) {
          std::lock_guard lock(mu_);
          run.program_log = path;
        },
        [this, &run] {
          const SteadyTime now = clock_.Steady();
          std::lock_guard lock(mu_);
          run.progressed = now;
        });
    return RunJob(FindHandler(handlers_, run.lease.kind()), run.lease, run.folder, run.cancel,
                  progress);
  }

  void Finish(Run& run, const Outcome& outcome) {
    const double wall_s = SecondsBetween(run.started, clock_.Steady());
    EndedAttempt ended;
    ended.attempt = run.lease.attempt();
    ended.succeeded = outcome.ok();
    std::string place;
    double cpu_s;
    // With the store gone nothing was written and nothing failed: others do the job. Finished work
    // is given up only if that is certain.
    const absl::Status marker = LookAtStore(run);
    const bool gone = outcome.ok() ? IsStoreGone(marker) : !marker.ok();
    {
      std::lock_guard lock(mu_);
      ChargeCpu();
      run.working = false;
      if (gone && run.stop == StopCause::kNone) run.stop = StopCause::kHandBack;
      ended.stop = run.stop;
      if (ended.succeeded) {
        const auto [usual, first] = usual_s_.try_emplace(run.lease.kind(), wall_s);
        if (!first) usual->second += kNewestWeighs * (wall_s - usual->second);
      }
      place = PlaceOf(run);
      cpu_s = run.cpu_s + (outcome.ok() ? outcome->children_cpu_s : 0);
    }
    // Work finished before it learnt of the drain is worth reporting; the fence decides.
    const bool report = ended.stop == StopCause::kNone ||
                        (ended.stop == StopCause::kHandBack && outcome.ok() && !gone);
    LogEnd(outcome, report, ended.stop, wall_s, cpu_s);
    CleanUpAfter(FindHandler(handlers_, run.lease.kind()), run.folder,
                 /*kept=*/outcome.ok() && report);
    if (report) {
      sink_(outcome.ok()
                ? CompleteReport(run.lease, NamesOf(run), *outcome, wall_s, cpu_s)
                : FailReport(run.lease, NamesOf(run), WithLog(outcome.status(), run), place));
      ended.reported = true;
    }
    {
      std::lock_guard lock(mu_);
      std::erase_if(runs_, [&run](const auto& other) { return other.get() == &run; });
      ended_.push_back(std::move(ended));
    }
    on_end_();
  }

  // Returns the attempt's error with the end of our log, unless it has that of the job's own
  // program, which tells more.
  static absl::Status WithLog(const absl::Status& status, const Run& run) {
    const bool wants_log = run.log != nullptr && LogTailOf(status).empty();
    return wants_log ? WithLogTail(status, run.log->Text()) : status;
  }

  // Requires mu_.
  static std::string PlaceOf(const Run& run) {
    return run.lease.kind() + (run.stage.empty() ? "" : "/" + run.stage);
  }

  static void LogEnd(const Outcome& outcome, bool report, StopCause stop, double wall_s,
                     double cpu_s) {
    if (!report) {
      LogInfo("job ended without a report", {{"cause", CauseName(stop)}, {"wall_s", wall_s}});
    } else if (outcome.ok()) {
      LogInfo("job done", {{"wall_s", wall_s}, {"cpu_s", cpu_s}});
    } else {
      LogWarning("job failed",
                 {{"wall_s", wall_s}, {"error", DescribeFailure(outcome.status(), "").error}});
    }
  }

  ReportNames NamesOf(const Run& run) const { return {worker_, run.coordinator_id}; }

  // Divides the CPU time since the last call among the running attempts, because threads of
  // different jobs can't be told apart. Requires mu_.
  void ChargeCpu() {
    const double now_s = ProcessCpuSeconds();
    int working = 0;
    for (const auto& run : runs_) working += run->working ? 1 : 0;
    for (const auto& run : runs_) {
      if (run->working) run->cpu_s += (now_s - cpu_seen_s_) / working;
    }
    cpu_seen_s_ = now_s;
  }

  const int slots_;
  const std::string worker_;
  const JobHandlers& handlers_;
  Clock& clock_;
  const ReportSink sink_;
  const std::function<void()> on_end_;

  mutable std::mutex mu_;
  std::condition_variable work_;
  // Guarded by mu_.
  std::vector<std::shared_ptr<Run>> runs_;
  std::deque<std::shared_ptr<Run>> waiting_;
  std::vector<EndedAttempt> ended_;
  double cpu_seen_s_;
  std::map<std::string, double> usual_s_;  // By kind of job.
  bool closing_ = false;

  std::vector<std::thread> threads_;
};

JobSlots::JobSlots(int slots, std::string worker, const JobHandlers& handlers, Clock& clock,
                   ReportSink sink, std::function<void()> on_end)
    : impl_(std::make_unique<Impl>(slots, std::move(worker), handlers, clock, std::move(sink),
                                   std::move(on_end))) {}
JobSlots::~JobSlots() = default;
bool JobSlots::Start(v1::Lease lease, AttemptFolder folder, std::string coordinator_id) {
  return impl_->Start(std::move(lease), std::move(folder), std::move(coordinator_id));
}
bool JobSlots::Stop(const v1::AttemptId& attempt, StopCause cause) {
  return impl_->Stop(attempt, cause);
}
void JobSlots::StopAll(StopCause cause) { impl_->StopAll(cause); }
bool JobSlots::Abandon(const v1::AttemptId& attempt) { return impl_->Abandon(attempt); }
std::vector<v1::AttemptId> JobSlots::TakeWaiting() { return impl_->TakeWaiting(); }
std::vector<RunningAttempt> JobSlots::Running() const { return impl_->Running(); }
int JobSlots::busy() const { return impl_->busy(); }
std::vector<EndedAttempt> JobSlots::TakeEnded() { return impl_->TakeEnded(); }

}  // namespace parallax
