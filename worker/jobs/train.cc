// Kind `train`: pairs -> a trained network, its log and its learning curve.
#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/ability_tags.h"
#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/installation.h"
#include "common/base/system/log.h"
#include "common/base/version.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/agent/attempts/failure.h"
#include "worker/jobs/files/kept_files.h"
#include "worker/jobs/files/store_files.h"
#include "worker/jobs/jobs.h"
#include "worker/jobs/training/checkpoint_keeper.h"
#include "worker/jobs/training/network_predictor.h"
#include "worker/jobs/training/training_data_folder.h"
#include "worker/jobs/training/training_run.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

absl::StatusOr<int64_t> StepsOf(const v1::TrainJob& job, const TrainerContract& contract) {
  if (job.steps() > 0) return job.steps();
  if (job.minutes() > 0 && contract.steps_per_minute > 0) {
    return std::max<int64_t>(1, static_cast<int64_t>(job.minutes() * contract.steps_per_minute));
  }
  if (job.minutes() == 0 && contract.default_steps > 0) return contract.default_steps;
  return FailedPrecondition("trainer {}: the study must say how many steps", contract.name);
}

// Returns the path of the network that the training begins with; "" for none. Errors: those of
// FindNetwork; kFailedPrecondition if this worker's is another one.
absl::StatusOr<std::string> StartOf(const v1::TrainJob& job) {
  if (job.start().empty()) return std::string();
  ASSIGN_OR_RETURN(const std::string path, FindNetwork());
  ASSIGN_OR_RETURN(const std::string hash, Sha256HexOfFile(path));
  if (NetworkTag(hash) == job.start()) return path;
  return FailedPrecondition("{} is {}, but the training begins with {}", path, NetworkTag(hash),
                            job.start());
}

absl::StatusOr<TrainingPlan> PlanOf(const v1::TrainJob& job, const InstalledTrainers& trainers) {
  TrainingPlan plan;
  ASSIGN_OR_RETURN(plan.trainer, trainers.Find(job.trainer()));
  ASSIGN_OR_RETURN(plan.steps, StepsOf(job, plan.trainer.contract));
  if ((job.width_px() > 0) != (job.height_px() > 0)) {
    return InvalidArgument("a size of crops with a width or a height alone");
  }
  ASSIGN_OR_RETURN(plan.start, StartOf(job));
  plan.seed = job.seed();
  plan.threads = std::max(1, job.threads());
  plan.width_px = job.width_px();
  plan.height_px = job.height_px();
  plan.batch = job.batch();
  plan.checkpoints = std::max(1, job.checkpoints());
  return plan;
}

// The network's card: all that is needed to repeat the training, and its results.
Json CardOf(const v1::TrainJob& job, const TrainingPlan& plan, const Json& data,
            const TrainedNetwork& trained, const std::string& own_card) {
  Json card = {{"schema", "parallax-training-1"},
               {"set", job.name()},
               {"trainer", job.trainer()},
               {"seed", job.seed()},
               {"steps", plan.steps},
               {"width_px", plan.width_px},
               {"height_px", plan.height_px},
               {"batch", plan.batch},
               {"threads", plan.threads},
               {"start", job.start().empty() ? "scratch" : job.start()},
               {"checkpoints", Json::array()},
               {"loss", trained.loss},
               {"train_s", trained.train_s},
               {"data", data},
               {"command", trained.command},
               {"environment", plan.trainer.contract.environment},
               {"program_version", kProgramVersion}};
  const Json own = Json::parse(own_card, nullptr, /*allow_exceptions=*/false);
  if (own.is_object()) card["trainer_says"] = own;
  return card;
}

// One attempt.
class TrainAttempt {
 public:
  TrainAttempt(const v1::TrainJob& job, const JobOptions& options, const AttemptFolder& folder,
               const CancelToken& cancel, const JobProgressFn& progress)
      : job_(job),
        options_(options),
        folder_(folder),
        cancel_(cancel),
        progress_(progress),
        keeper_(*folder.store, folder.path),
        kept_(folder) {}

  absl::StatusOr<JobOutcome> Run() {
    ASSIGN_OR_RETURN(plan_, PlanOf(job_, options_.trainers));
    plan_.work_dir = folder_.scratch;
    RETURN_IF_ERROR(MakeFolders(plan_.work_dir + "/earlier"));
    CoreShare::Hold cores;
    std::unique_ptr<Predictor> curator;
    if (job_.curated()) {
      ASSIGN_OR_RETURN(curator, OpenCurator());
      ASSIGN_OR_RETURN(cores, TakeCores());  // It predicts while the data are made.
    }
    progress_(0, "data");
    ASSIGN_OR_RETURN(const TrainingDataFolder data,
                     MakeTrainingData(job_, plan_.trainer.contract, DataOptions(curator.get())));
    plan_.data = data.parts;
    RETURN_IF_ERROR(FindResumePoint(plan_.steps));
    if (!job_.curated()) {
      ASSIGN_OR_RETURN(cores, TakeCores());
    }
    progress_(0, "train");
    ASSIGN_OR_RETURN(const TrainedNetwork trained, TrainFromNewest());
    progress_(1, "keep");
    return Keep(trained, data);
  }

 private:
  absl::StatusOr<CoreShare::Hold> TakeCores() const {
    if (options_.cores == nullptr) return CoreShare::Hold();
    return options_.cores->TakeAlone(plan_.threads, cancel_,
                                     [this] { progress_(0, "wait for cores"); });
  }

  absl::StatusOr<std::unique_ptr<Predictor>> OpenCurator() const {
    const std::string dir = plan_.work_dir + "/curator";
    RETURN_IF_ERROR(MakeFolders(dir));
    return OpenStoredNetwork({job_.trainer(), job_.curator_path(), job_.curator()},
                             options_.trainers, *folder_.store, dir, plan_.threads);
  }

  TrainingDataOptions DataOptions(Predictor* curator) const {
    return {.store = folder_.store.get(),
            .cache = options_.frame_cache,
            .dir = plan_.work_dir + "/data",
            .cancel = cancel_,
            .progress = [this](double fraction) { progress_(fraction, "data"); },
            .curator = {job_.curator().sha256(), curator}};
  }

  // Trains from the resume point. Where the trainer fails before it has told of a step beyond it,
  // the checkpoint may be at fault: the next older one is tried, and at last the start.
  absl::StatusOr<TrainedNetwork> TrainFromNewest() {
    while (true) {
      int64_t told_step = 0;
      const JobProgressFn progress = [&](double fraction, std::string_view stage,
                                         const JobFigures& figures) {
        const auto step = figures.find("step");
        if (step != figures.end()) told_step = static_cast<int64_t>(step->second);
        progress_(fraction, stage, figures);
      };
      progress_.FollowLog(plan_.work_dir + "/log.txt");
      absl::StatusOr<TrainedNetwork> trained =
          RunTrainer(plan_, resume_, keeper_, cancel_, progress);
      const bool went_on = !resume_ || told_step > resume_->facts.step;
      if (trained.ok() || went_on || !MayBeTheCheckpoint(trained.status())) return trained;
      LogWarning("a trainer can't go on from a checkpoint; an older one is tried",
                 {{"trainer", job_.trainer()},
                  {"step", resume_->facts.step},
                  {"error", std::string(ToStd(trained.status().message()))}});
      RETURN_IF_ERROR(StepBack());
    }
  }

  // Whether an error may be that of the checkpoint: not a stop, no lost training and no lack of
  // memory, which have codes of their own.
  bool MayBeTheCheckpoint(const absl::Status& status) const {
    return !cancel_.cancelled() && (absl::IsInternal(status) || absl::IsAborted(status));
  }

  absl::Status StepBack() {
    std::error_code error;
    fs::remove_all(plan_.work_dir + "/out", error);
    if (error) return ErrnoError(error.value(), "remove " + plan_.work_dir + "/out");
    const int64_t failed_step = resume_->facts.step;
    keeper_.Forget();
    return FindResumePoint(failed_step);
  }

  // Finds the newest checkpoint of earlier attempts before step `before` that is whole, and those
  // for learning curves before it; all of them are put under this attempt, since the others'
  // folders may be removed any time.
  absl::Status FindResumePoint(int64_t before) {
    resume_.reset();
    earlier_.clear();
    if (plan_.trainer.contract.resume.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(const auto left, ListCheckpoints(*folder_.store, job_.resume_folder()));
    for (size_t i = left.size(); i-- > 0 && !resume_;) {
      if (left[i].facts.step >= before) continue;
      ResumePoint point{.facts = left[i].facts, .path = PathOf(left[i].facts)};
      const absl::Status fetched =
          FetchCheckpoint(*folder_.store, left[i], point.path, &point.curve);
      if (fetched.ok()) resume_ = std::move(point);
      if (!fetched.ok()) LogWarning("a checkpoint can't be used", {{"error", fetched}});
    }
    if (!resume_) return absl::OkStatus();
    LogInfo("training goes on", {{"from", resume_->facts.step}});
    RETURN_IF_ERROR(TakeOverForCurve(left));
    return keeper_.Put(resume_->facts, resume_->path, resume_->curve);
  }

  absl::Status TakeOverForCurve(const std::vector<LeftCheckpoint>& left) {
    for (const LeftCheckpoint& one : left) {
      if (!one.facts.for_curve || one.facts.step > resume_->facts.step) continue;
      if (!earlier_.empty() && earlier_.back().first == one.facts.step) continue;
      const std::string path = PathOf(one.facts);
      std::string curve;
      if (!FetchCheckpoint(*folder_.store, one, path, &curve).ok()) continue;
      earlier_.push_back({one.facts.step, path});
      if (one.facts.step == resume_->facts.step) continue;
      RETURN_IF_ERROR(keeper_.Put(one.facts, path, curve));
    }
    return absl::OkStatus();
  }

  // Where a checkpoint of earlier attempts is brought.
  std::string PathOf(const CheckpointFacts& facts) const {
    return fmt::format("{}/earlier/{}{}", plan_.work_dir, facts.step,
                       fs::path(facts.name).extension().string());
  }

  // ---- Results
  absl::Status KeepCheckpoint(int64_t step, const std::string& path, Json& card) {
    const bool last = step == plan_.steps;
    const std::string name =
        (last ? "final" : fmt::format("checkpoint-{}", step)) + fs::path(path).extension().string();
    ASSIGN_OR_RETURN(const std::string hash, kept_.Keep(path, name));
    v1::TrainedCheckpoint& checkpoint = *result_.add_checkpoints();
    checkpoint.set_name(name);
    checkpoint.set_step(step);
    card["checkpoints"].push_back({{"name", name}, {"step", step}, {"sha256", hash}});
    return absl::OkStatus();
  }

  absl::StatusOr<JobOutcome> Keep(const TrainedNetwork& trained, const TrainingDataFolder& data) {
    const absl::StatusOr<std::string> own = ReadFile(plan_.work_dir + "/out/train.json");
    Json card = CardOf(job_, plan_, data.facts, trained, own.ok() ? *own : "");
    for (const auto& [step, path] : earlier_) RETURN_IF_ERROR(KeepCheckpoint(step, path, card));
    for (const auto& [step, path] : trained.checkpoints) {
      RETURN_IF_ERROR(KeepCheckpoint(step, path, card));
    }
    RETURN_IF_ERROR(KeepCheckpoint(plan_.steps, trained.final_path, card));
    RETURN_IF_ERROR(kept_.Keep(trained.log_path, "log.txt").status());
    RETURN_IF_ERROR(kept_.KeepText(trained.curve, "curve.csv"));
    RETURN_IF_ERROR(kept_.KeepText(card.dump(2) + "\n", "training.json"));
    // The checkpoints stay: until the coordinator has the result, another attempt may need them.
    result_.set_path(folder_.path);
    result_.set_loss(trained.loss);
    result_.set_train_s(trained.train_s);
    result_.set_pairs(data.pairs);
    *result_.mutable_files() = kept_.entries();
    return JobOutcome{result_.SerializeAsString(), kept_.outputs(), trained.cpu_s};
  }

  const v1::TrainJob& job_;
  const JobOptions& options_;
  const AttemptFolder& folder_;
  const CancelToken& cancel_;
  const JobProgressFn& progress_;
  CheckpointKeeper keeper_;
  KeptFiles kept_;
  TrainingPlan plan_;
  std::optional<ResumePoint> resume_;
  std::vector<std::pair<int64_t, std::string>> earlier_;  // For learning curves, by step.
  v1::TrainResult result_;
};

class TrainHandler final : public JobHandler {
 public:
  explicit TrainHandler(std::shared_ptr<const JobOptions> options)
      : JobHandler("train", /*writes_output=*/true, /*resumes=*/true),
        options_(std::move(options)) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::TrainJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return InvalidArgument("a spec that is no TrainJob");
    }
    return TrainAttempt(job, *options_, folder, cancel, progress).Run();
  }

 private:
  const std::shared_ptr<const JobOptions> options_;
};

}  // namespace

std::unique_ptr<JobHandler> MakeTrainHandler(std::shared_ptr<const JobOptions> options) {
  return std::make_unique<TrainHandler>(std::move(options));
}

}  // namespace parallax
