#include "worker/jobs/training/training_run.h"

#include <fmt/core.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <set>
#include <sstream>
#include <thread>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/child_process.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "worker/agent/attempts/failure.h"
#include "worker/jobs/files/store_files.h"
#include "worker/jobs/training/log_reader.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPoll(50);
// Time for a stopped trainer to write its last checkpoint; the agent gives stopped work three
// seconds.
constexpr double kStop_s = 2.5;
// Programs of others write checkpoints in place: one is whole when it has kept still for so long.
constexpr double kSettled_s = 1;
constexpr int64_t kMostStepsBetween = 250;
constexpr double kNewestLossWeighs = 0.1;

constexpr char kCurveHead[] = "step,loss,epe_px,train_s\n";

// A line of the curve for each progress that names a step, up to `step`.
std::string CurveUpTo(const std::string& curve, int64_t step) {
  std::istringstream lines(curve);
  std::string kept = kCurveHead;
  for (std::string line; std::getline(lines, line);) {
    char* end = nullptr;
    const int64_t at = std::strtoll(line.c_str(), &end, 10);
    if (end != line.c_str() && at <= step) kept += line + "\n";
  }
  return kept;
}

// The step in a file's name, if it fits the pattern "checkpoints/*_name.pth".
std::optional<int64_t> StepOf(const std::string& name, const std::string& pattern) {
  const size_t star = pattern.find('*');
  const std::string before = pattern.substr(0, star), after = pattern.substr(star + 1);
  if (name.size() <= before.size() + after.size() || name.rfind(before, 0) != 0 ||
      name.compare(name.size() - after.size(), after.size(), after) != 0) {
    return std::nullopt;
  }
  const std::string digits = name.substr(before.size(), name.size() - before.size() - after.size());
  if (digits.find_first_not_of("0123456789") != std::string::npos || digits.size() > 15) {
    return std::nullopt;
  }
  return std::stoll(digits);
}

class Training {
 public:
  Training(const TrainingPlan& plan, const std::optional<ResumePoint>& resume,
           CheckpointKeeper& keeper, const CancelToken& cancel, const JobProgressFn& progress)
      : plan_(plan),
        contract_(plan.trainer.contract),
        resume_(resume),
        keeper_(keeper),
        cancel_(cancel),
        progress_(progress),
        out_(plan.work_dir + "/out"),
        log_(plan.work_dir + "/log.txt"),
        reader_(log_),
        curve_(resume ? CurveUpTo(resume->curve, resume->facts.step) : kCurveHead),
        earlier_s_(resume ? resume->facts.train_s : 0),
        can_resume_(!contract_.resume.empty()) {
    if (resume) step_ = taken_step_ = resume->facts.step;
  }

  absl::StatusOr<TrainedNetwork> Run() {
    ASSIGN_OR_RETURN(command_, Command());
    RETURN_IF_ERROR(Prepare());
    ASSIGN_OR_RETURN(const auto child, ChildProcess::Start({.command = command_,
                                                            .directory = directory_,
                                                            .log = log_,
                                                            .environment = contract_.environment}));
    LogInfo("trainer started",
            {{"trainer", contract_.name}, {"steps", plan_.steps}, {"from", step_}});
    began_ = plan_.clock->Steady();
    RETURN_IF_ERROR(Watch(*child));
    return Collect(child->cpu_seconds());
  }

 private:
  CommandValues Values() const {
    CommandValues values;
    values.data = plan_.data;
    values.values = {
        {"out", out_},
        {"seed", std::to_string(plan_.seed)},
        {"steps", std::to_string(plan_.steps)},
        {"threads", std::to_string(plan_.threads)},
        {"device", contract_.gpus > 0 ? "cuda" : "cpu"},
        {"repository", plan_.trainer.repository},
        {"checkpoint_every", std::to_string(CheckpointEvery(plan_.steps, plan_.checkpoints))},
        {"width", std::to_string(plan_.width_px)},
        {"height", std::to_string(plan_.height_px)},
        {"batch", std::to_string(plan_.batch)},
        {"start", plan_.start}};
    if (resume_) values.values["resume"] = resume_->path;
    return values;
  }

  absl::Status Add(const std::vector<std::string>& more, const char* what,
                   std::vector<std::string>& command) const {
    if (more.empty()) {
      return Unimplemented("trainer {} has no option for the {}", contract_.name, what);
    }
    command.insert(command.end(), more.begin(), more.end());
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<std::string>> Command() const {
    std::vector<std::string> command = contract_.train;
    if (plan_.width_px > 0 || plan_.height_px > 0) {
      RETURN_IF_ERROR(Add(contract_.size, "size of crops", command));
    }
    if (plan_.batch > 0) RETURN_IF_ERROR(Add(contract_.batch, "batch", command));
    if (!plan_.start.empty())
      RETURN_IF_ERROR(Add(contract_.start, "network to start from", command));
    if (resume_) RETURN_IF_ERROR(Add(contract_.resume, "checkpoint to resume from", command));
    return CommandToRun(command, Values());
  }

  // Folders and links.
  absl::Status Prepare() {
    RETURN_IF_ERROR(MakeFolders(out_));
    ASSIGN_OR_RETURN(const auto directory, ExpandCommand({contract_.directory}, Values()));
    directory_ = contract_.directory.empty() ? out_ : directory.at(0);
    ASSIGN_OR_RETURN(const auto links, ExpandCommand(contract_.links, Values()));
    for (const std::string& link : links) {
      const size_t equals = link.find('=');
      if (equals == std::string::npos) continue;
      const fs::path path = fs::path(out_) / link.substr(0, equals);
      RETURN_IF_ERROR(MakeFolders(path.parent_path()));
      std::error_code error;
      fs::create_directory_symlink(link.substr(equals + 1), path, error);
      if (error) return ErrnoError(error.value(), "link " + path.string());
    }
    return absl::OkStatus();
  }

  double TrainSeconds() const { return earlier_s_ + SecondsAgo(began_); }
  double SecondsAgo(SteadyTime then) const { return SecondsBetween(then, plan_.clock->Steady()); }

  // ---- While it runs
  absl::Status Watch(ChildProcess& child) {
    while (true) {
      const std::optional<int> ended = child.Poll();
      for (const std::string& line : reader_.NewLines(ended.has_value())) Hear(line);
      if (!lost_.empty()) {
        child.Kill();
        return Failed(absl::StatusCode::kFailedPrecondition, lost_);
      }
      if (ended) return CheckEnd(*ended);
      if (cancel_.cancelled()) return Stop(child);
      RETURN_IF_ERROR(TakeCheckpoints(/*settled=*/false));
      std::this_thread::sleep_for(kPoll);
    }
  }

  void Hear(const std::string& line) {
    const std::optional<TrainerProgress> told = ReadProgress(contract_, line);
    if (!told) return;
    step_ = told->step.value_or(step_);
    JobFigures figures = {{"step", static_cast<double>(step_)},
                          {"steps", static_cast<double>(plan_.steps)}};
    if (told->loss) {
      if (!std::isfinite(*told->loss))
        lost_ = fmt::format("the loss is not finite at step {}", step_);
      loss_ = loss_ == 0 ? *told->loss : loss_ + kNewestLossWeighs * (*told->loss - loss_);
      figures["loss"] = loss_;
    }
    if (told->epe_px) figures["epe_px"] = *told->epe_px;
    const double run_s = TrainSeconds() - earlier_s_;
    const auto done = static_cast<double>(step_ - (resume_ ? resume_->facts.step : 0));
    if (told->eta_s) {
      figures["eta_s"] = *told->eta_s;
    } else if (done > 0) {
      figures["eta_s"] =
          run_s / done * static_cast<double>(std::max<int64_t>(0, plan_.steps - step_));
    }
    if (told->loss || told->epe_px) {
      curve_ +=
          fmt::format("{},{},{},{:g}\n", step_, told->loss ? fmt::format("{:g}", *told->loss) : "",
                      told->epe_px ? fmt::format("{:g}", *told->epe_px) : "", TrainSeconds());
    }
    progress_(std::clamp(static_cast<double>(step_) / static_cast<double>(plan_.steps), 0.0, 1.0),
              "train", figures);
  }

  // Terminates it, so that it can write where it stands, and kills what hasn't ended in time. The
  // newest file of a trainer that a signal has ended may be half a checkpoint.
  absl::Status Stop(ChildProcess& child) {
    child.Terminate();
    const SteadyTime told = plan_.clock->Steady();
    while (!child.Poll() && SecondsAgo(told) < kStop_s) std::this_thread::sleep_for(kPoll);
    const std::optional<int> ended = child.Poll();
    child.Kill();
    // If a checkpoint can't be kept, an older one is there.
    TakeCheckpoints(/*settled=*/ended && WIFEXITED(*ended)).IgnoreError();
    return Cancelled("while it trained");
  }

  // ---- Checkpoints
  // Takes the new checkpoints in order of steps. With `settled` all files are whole; else those
  // are that have kept still for a while.
  absl::Status TakeCheckpoints(bool settled) {
    if (contract_.checkpoint_pattern.empty()) return absl::OkStatus();
    if (!can_resume_ && plan_.checkpoints < 2) return absl::OkStatus();
    const fs::path pattern(contract_.checkpoint_pattern);
    const fs::path folder = fs::path(out_) / pattern.parent_path();
    std::map<int64_t, fs::path> found;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const auto step = StepOf(entry.path().filename(), pattern.filename());
      if (step && *step > taken_step_ && *step < plan_.steps) found[*step] = entry.path();
    }
    for (const auto& [step, path] : found) {
      if (!settled && !HasSettled(path)) break;
      RETURN_IF_ERROR(Take(step, path));
    }
    return absl::OkStatus();
  }

  static bool HasSettled(const fs::path& path) {
    std::error_code error;
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(path, error);
    return !error && std::chrono::duration<double>(age).count() >= kSettled_s;
  }

  absl::Status Take(int64_t step, const fs::path& path) {
    const int64_t next_for_curve = NextForCurve(taken_step_);
    const bool for_curve = next_for_curve > 0 && step >= next_for_curve;
    if (can_resume_) RETURN_IF_ERROR(KeepForResume(step, path, for_curve));
    if (for_curve) for_curve_.push_back({step, path});
    taken_step_ = step;
    return absl::OkStatus();
  }

  // Puts a checkpoint into the store, for attempts that go on from it.
  absl::Status KeepForResume(int64_t step, const fs::path& path, bool for_curve) {
    CheckpointFacts facts;
    facts.step = step;
    facts.name = path.filename();
    facts.for_curve = for_curve;
    facts.train_s = TrainSeconds();
    std::error_code error;
    facts.size = static_cast<int64_t>(fs::file_size(path, error));
    ASSIGN_OR_RETURN(facts.sha256, Sha256HexOfFile(path));
    return keeper_.Put(facts, path, CurveUpTo(curve_, step));
  }

  // The first step after `step` at which a checkpoint is kept for learning curves; 0: none.
  int64_t NextForCurve(int64_t step) const {
    for (int k = 1; k < plan_.checkpoints; ++k) {
      const int64_t at = plan_.steps * k / plan_.checkpoints;
      if (at > step) return at;
    }
    return 0;
  }

  // ---- The end
  absl::Status Failed(absl::StatusCode code, const std::string& what) const {
    return WithLogTail(MakeError(code, fmt::format("trainer {}: {}", contract_.name, what)),
                       reader_.Tail());
  }

  absl::Status CheckEnd(int wait_status) const {
    const std::string said = reader_.LastLine();
    const std::string because = said.empty() ? "" : ": " + said;
    if (WIFSIGNALED(wait_status)) {
      const bool killed = WTERMSIG(wait_status) == SIGKILL;
      return Failed(
          killed ? absl::StatusCode::kResourceExhausted : absl::StatusCode::kAborted,
          DescribeExit(wait_status) + (killed ? ", as when memory is exhausted" : because));
    }
    const int status = WEXITSTATUS(wait_status);
    const auto means = [&](const char* name) {
      const auto exit = contract_.exits.find(name);
      return exit != contract_.exits.end() && exit->second == status;
    };
    if (status == 0) return absl::OkStatus();
    if (means("usage")) return Failed(absl::StatusCode::kInvalidArgument, said);
    if (means("not_finite")) return Failed(absl::StatusCode::kFailedPrecondition, said);
    if (means("out_of_memory") || SaysOutOfMemory()) {
      return Failed(absl::StatusCode::kResourceExhausted, "out of memory" + because);
    }
    return Failed(absl::StatusCode::kInternal, DescribeExit(wait_status) + because);
  }

  // Whether the log has an out-of-memory message of a common framework.
  bool SaysOutOfMemory() const {
    const std::string tail = reader_.Tail();
    for (const char* words :
         {"OutOfMemoryError", "CUDA out of memory", "std::bad_alloc", "MemoryError"}) {
      if (tail.find(words) != std::string::npos) return true;
    }
    return false;
  }

  absl::StatusOr<TrainedNetwork> Collect(double cpu_s) {
    RETURN_IF_ERROR(TakeCheckpoints(/*settled=*/true));
    TrainedNetwork trained;
    trained.final_path = out_ + "/" + contract_.final_checkpoint;
    std::error_code error;
    if (!fs::is_regular_file(trained.final_path, error)) {
      return Failed(absl::StatusCode::kInternal, "it ended without " + contract_.final_checkpoint);
    }
    trained.checkpoints = for_curve_;
    trained.log_path = log_;
    trained.curve = curve_;
    trained.command = command_;
    trained.loss = loss_;
    trained.train_s = TrainSeconds();
    trained.cpu_s = cpu_s;
    return trained;
  }

  const TrainingPlan& plan_;
  const TrainerContract& contract_;
  const std::optional<ResumePoint>& resume_;
  CheckpointKeeper& keeper_;
  const CancelToken& cancel_;
  const JobProgressFn& progress_;
  const std::string out_, log_;
  LogReader reader_;
  std::vector<std::string> command_;
  std::string directory_;
  std::string curve_;
  std::string lost_;  // Why the training makes no sense any more.
  const double earlier_s_;
  const bool can_resume_;
  SteadyTime began_{};
  int64_t step_ = 0, taken_step_ = 0;
  double loss_ = 0;
  std::vector<std::pair<int64_t, std::string>> for_curve_;
};

}  // namespace

int64_t CheckpointEvery(int64_t steps, int checkpoints) {
  const int64_t distance = std::max<int64_t>(1, steps / std::max(1, checkpoints));
  // The longest divisor of the distance that isn't too long; a prime distance is cut at will.
  for (int64_t every = std::min(distance, kMostStepsBetween); every > kMostStepsBetween / 5;
       --every) {
    if (distance % every == 0) return every;
  }
  return std::min(distance, kMostStepsBetween);
}

absl::StatusOr<TrainedNetwork> RunTrainer(const TrainingPlan& plan,
                                          const std::optional<ResumePoint>& resume,
                                          CheckpointKeeper& keeper, const CancelToken& cancel,
                                          const JobProgressFn& progress) {
  return Training(plan, resume, keeper, cancel, progress).Run();
}

}  // namespace parallax
