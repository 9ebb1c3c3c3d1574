#include "coordinator/client/runs/embedded_run.h"

#include <fmt/core.h>
#include <sys/resource.h>

#include <chrono>

#include "common/base/system/memory_end.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/runs/local_farm.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/queue/commands/policy.h"

namespace parallax::client {
namespace {

// Writing the index reads every frame's line: not after each frame of a large dataset.
constexpr double kIndexEvery_s = 30;
constexpr double kEndGrace_s = 10;

double OwnCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

int64_t FreshPairs(const v1::StudyStatus& study) {
  const PairCounts counts = CountsOf(study);
  return counts.done - counts.reused;
}

std::string LogDir(const OutDir& out_dir) { return out_dir.work_dir() + "/logs"; }

}  // namespace

absl::Status CheckDiskError(const std::string& error) {
  for (const char* cause : {"No space left on device", "Disk quota exceeded",
                            "Read-only file system", "Permission denied", "Input/output error"}) {
    if (error.find(cause) != std::string::npos) return ResourceExhausted("{}", error);
  }
  return absl::OkStatus();
}

absl::Status CheckMemoryError(const std::string& error, int attempts, int64_t address_space) {
  if (address_space == 0 || attempts < 2 || !SaysOutOfMemory(error)) return absl::OkStatus();
  return Aborted(
      "{}; the address space of a process is limited to {} MB (ulimit -v), too little for this "
      "study",
      error, address_space >> 20);
}

EmbeddedRun::EmbeddedRun(const EmbeddedRunOptions& options, const OutDir& out_dir,
                         Environment& environment)
    : options_(options),
      out_dir_(out_dir),
      store_dir_(options.store_dir.empty() ? out_dir.work_dir() : options.store_dir),
      environment_(environment),
      display_(environment.err, {false, environment.plain_line_s}) {}

absl::StatusOr<std::unique_ptr<EmbeddedRun>> EmbeddedRun::Open(const EmbeddedRunOptions& options,
                                                               const OutDir& out_dir,
                                                               Environment& environment) {
  std::unique_ptr<EmbeddedRun> run(new EmbeddedRun(options, out_dir, environment));
  LogCoordinatorTo(LogDir(out_dir));
  ASSIGN_OR_RETURN(run->archive_, ArchiveSync::Open(out_dir.path(), options.study));
  ASSIGN_OR_RETURN(run->results_, StudyResults::Open(out_dir.path(), options.study));
  ASSIGN_OR_RETURN(run->coordinator_, EmbeddedCoordinator::Start(run->store_dir_));
  ASSIGN_OR_RETURN(run->connection_, Connection::Open(run->coordinator_->address()));
  RETURN_IF_ERROR(run->EnterStudy());
  RETURN_IF_ERROR(run->StandAlone());
  if (!options.page.empty()) {
    ASSIGN_OR_RETURN(run->page_link_, run->coordinator_->ServePage(options.page));
  }
  return run;
}

absl::StatusOr<v1::StudyStatus> EmbeddedRun::SubmitStudy() {
  const std::string key = IdempotencyKey(options_.study);
  v1::SubmitRequest request;
  *request.mutable_study() = options_.study;
  // A cancelled study can't go on. Another takes its place and reuses its results.
  for (int again = 0;; ++again) {
    request.set_idempotency_key(again == 0 ? key : fmt::format("{} again {}", key, again));
    ASSIGN_OR_RETURN(const v1::SubmitReply reply, connection_->Submit(request));
    ASSIGN_OR_RETURN(v1::StudyStatus study, connection_->GetStudy(reply.study_id()));
    if (!reply.existed() || study.state() != v1::STUDY_STATE_CANCELLED) return study;
  }
}

absl::Status EmbeddedRun::EnterStudy() {
  ASSIGN_OR_RETURN(const v1::StudyStatus study, SubmitStudy());
  study_id_ = study.study_id();
  fresh_before_ = FreshPairs(study);
  if (study.state() == v1::STUDY_STATE_PAUSED) {
    RETURN_IF_ERROR(connection_->Resume(study_id_, "run again").status());
  }
  // Jobs that failed for a passing cause (a full disk) get another chance. Jobs that fail again are
  // reported again.
  if (CountsOf(study).failed > 0 || study.state() == v1::STUDY_STATE_FAILED) {
    RETURN_IF_ERROR(connection_->Retry(study_id_).status());
  }
  return absl::OkStatus();
}

absl::Status EmbeddedRun::StandAlone() {
  // The same folder with another --pairs is a study of its own there; only the one asked for is
  // worked on.
  ASSIGN_OR_RETURN(const v1::ListStudiesReply list, connection_->ListStudies(1000));
  for (const v1::StudyStatus& other : list.studies()) {
    if (other.study_id() == study_id_ || other.state() != v1::STUDY_STATE_RUNNING) continue;
    RETURN_IF_ERROR(connection_->Pause(other.study_id(), "another run with this store").status());
  }
  return absl::OkStatus();
}

absl::Status EmbeddedRun::StartWorkers() {
  ASSIGN_OR_RETURN(WorkerPoolOptions pool, PoolOf({.coordinator = coordinator_->address(),
                                                   .store_dir = store_dir_,
                                                   .log_dir = LogDir(out_dir_),
                                                   .workers = options_.workers,
                                                   .machine = options_.machine,
                                                   .clock = environment_.clock}));
  pool_ = std::make_unique<WorkerPool>(std::move(pool));
  return pool_->Start();
}

absl::StatusOr<RunReport> EmbeddedRun::Work() {
  const double start_s = SteadySeconds(*environment_.clock);
  const double own_cpu_s = OwnCpuSeconds();
  RETURN_IF_ERROR(LookAt(*connection_, study_id_, start_s, view_));
  if (!IsFinished(view_.study().state())) {
    RETURN_IF_ERROR(StartWorkers());
    const absl::Status worked = Loop();
    const bool interrupted = absl::IsCancelled(worked);
    Drain(/*hurry=*/!worked.ok() && !interrupted);
    if (!worked.ok()) {
      // Results that arrived while draining belong to the dataset too, if the disk takes them.
      (void)CatchUp(SteadySeconds(*environment_.clock), /*last=*/true);
      (void)LookAt(*connection_, study_id_, SteadySeconds(*environment_.clock), view_);
      display_.Keep();
      const std::string cause = interrupted ? "" : std::string(ToStd(worked.message())) + "; ";
      return MakeError(worked.code(), cause + Progress());
    }
  }
  const double end_s = SteadySeconds(*environment_.clock);
  const double own_cpu_used_s = OwnCpuSeconds() - own_cpu_s;
  RETURN_IF_ERROR(CatchUp(end_s, /*last=*/true));
  RETURN_IF_ERROR(LookAt(*connection_, study_id_, end_s, view_));
  display_.Keep();

  RunReport report;
  report.study = view_.study();
  report.out_dir = out_dir_.path();
  report.pairs_rendered = FreshPairs(report.study) - fresh_before_;
  for (const auto& [variant, frames] : archive_->writer().Frames()) {
    report.frames_in_dataset += frames;
  }
  report.trainings = results_->trainings();
  report.evaluations = results_->evaluations();
  report.score_files = results_->score_files();
  report.elapsed_s = end_s - start_s;
  report.core_seconds = own_cpu_used_s + (pool_ == nullptr ? 0 : pool_->cpu_seconds());
  report.worker_crashes = pool_ == nullptr ? 0 : pool_->crashes();
  return report;
}

absl::Status EmbeddedRun::Loop() {
  while (true) {
    const double now_s = SteadySeconds(*environment_.clock);
    RETURN_IF_ERROR(Step(now_s));
    const bool finished = IsFinished(view_.study().state());
    display_.Show(view_, now_s, finished);
    if (finished) return absl::OkStatus();
    if (interrupts_.WaitFor(std::chrono::duration<double>(environment_.poll_s))) {
      return Cancelled("interrupted");
    }
  }
}

absl::Status EmbeddedRun::Step(double now_s) {
  RETURN_IF_ERROR(LookAt(*connection_, study_id_, now_s, view_));
  RETURN_IF_ERROR(ShowProblems());
  RETURN_IF_ERROR(out_dir_.CheckFreeSpace());
  RETURN_IF_ERROR(CheckFreeSpaceOf(store_dir_));
  RETURN_IF_ERROR(CatchUp(now_s, /*last=*/false));
  if (IsFinished(view_.study().state())) return absl::OkStatus();
  const int crashes = pool_->crashes();
  const PairCounts counts = CountsOf(view_.study());
  RETURN_IF_ERROR(
      pool_->Poll(counts.done + JobsInState(view_.study(), "SUCCEEDED") + counts.rejected));
  if (pool_->crashes() > crashes) {
    display_.Print(environment_.err.Paint(Tone::kWarning, "note:") +
                   " a worker crashed; its jobs are done again (logs: " + LogDir(out_dir_) + ")");
  }
  return absl::OkStatus();
}

void EmbeddedRun::Note(const std::string& place, const std::string& error) {
  // A cause that many jobs have is reported once.
  if (!shown_problems_.insert(error).second) return;
  display_.Print(environment_.err.Paint(Tone::kWarning, "note:") + " " + place + ": " + error);
}

absl::Status EmbeddedRun::ShowProblems() {
  // A job that waits for its next try has no problem yet in the study's eyes; but no try mends a
  // full disk or a narrow address space.
  v1::ListJobsRequest waiting;
  waiting.set_study_id(study_id_);
  waiting.set_state("RETRY_WAIT");
  waiting.set_limit(20);
  ASSIGN_OR_RETURN(const v1::ListJobsReply retries, connection_->ListJobs(waiting));
  for (const v1::JobStatus& job : retries.jobs()) {
    RETURN_IF_ERROR(CheckDiskError(FirstLine(job.error())));
    RETURN_IF_ERROR(CheckMemoryError(FirstLine(job.error()), job.attempts(), AddressSpaceLimit()));
    Note(PlaceOf(job), FirstLine(job.error()) + "; it will be tried again");
  }
  for (const v1::VariantStatus& variant : view_.study().variants()) {
    for (const v1::JobProblem& problem : variant.problems()) {
      RETURN_IF_ERROR(CheckDiskError(FirstLine(problem.error())));
      Note(PlaceOf(variant.name(), problem), FirstLine(problem.error()));
    }
  }
  return absl::OkStatus();
}

void EmbeddedRun::Drain(bool hurry) {
  if (pool_ == nullptr || pool_->running() == 0) return;
  const int signals = interrupts_.count();
  const bool interrupted = signals > 0;
  if (interrupted) {
    display_.Keep();
    *environment_.err.stream << "stopping: the pairs that are being rendered may take a minute to "
                                "finish; Ctrl-C again stops at once\n"
                             << std::flush;
  }
  pool_->Drain(interrupted ? kDrainGrace_s : kEndGrace_s,
               [&] { return hurry || interrupts_.count() > signals; });
}

absl::Status EmbeddedRun::CatchUp(double now_s, bool last) {
  RETURN_IF_ERROR(archive_->CatchUp(*connection_, study_id_));
  RETURN_IF_ERROR(results_->CatchUp(*connection_, study_id_));
  if (!last && now_s - indexed_s_ < kIndexEvery_s) return absl::OkStatus();
  indexed_s_ = now_s;
  return archive_->Finish();
}

std::string EmbeddedRun::Progress() const {
  const PairCounts counts = CountsOf(view_.study());
  return FormatCount(counts.done) + " of " + Plural(counts.wanted, "pair") +
         " are finished and kept; the same command resumes";
}

}  // namespace parallax::client
