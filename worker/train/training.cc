#include "worker/train/training.h"

#include <ATen/Parallel.h>
#include <fmt/core.h>
#include <torch/version.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/version.h"
#include "worker/train/data/batch_loader.h"
#include "worker/train/network/checkpoint.h"
#include "worker/train/network/loss.h"
#include "worker/train/trained_predictor.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;
using torch::Tensor;

// Steps that are run before a run of given minutes, and how many of them are not timed.
constexpr int kTimingSteps = 6, kUntimedSteps = 2;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct BatchTensors {
  Tensor left, right, disparity, weight;
};

BatchTensors ToTensors(TrainingBatch& batch) {
  const auto stack = [&](auto member, int64_t channels) {
    std::vector<Tensor> parts;
    for (TrainingCrop& crop : batch.crops) {
      parts.push_back(torch::from_blob((crop.*member).data(), {channels, crop.height, crop.width}));
    }
    return torch::stack(parts);  // A copy.
  };
  return {stack(&TrainingCrop::left, 3), stack(&TrainingCrop::right, 3),
          stack(&TrainingCrop::disparity_px, 1), stack(&TrainingCrop::weight, 1)};
}

Json HashesOf(const std::vector<TrainingSource>& sources) {
  Json hashes = Json::array();
  for (const TrainingSource& source : sources)
    hashes.push_back({{"sha256", source.data_hash}, {"weight", source.weight}});
  return hashes;
}

// A full disk has the code of exhausted memory, and another exit status.
absl::Status DiskError(const absl::Status& written) {
  return absl::IsResourceExhausted(written) ? Unavailable("{}", ToStd(written.message())) : written;
}

TrainingEnd OutOfMemory(const std::string& why) {
  return {TrainerExit::kOutOfMemory, "out of memory: take a smaller --crop or --batch" +
                                         (why.empty() ? "" : " (" + why + ")")};
}

std::string CheckpointName(int64_t step) { return fmt::format("/checkpoint-{:06}.pt", step); }

// One training run from start to end; exceptions of torch pass through.
class Run {
 public:
  Run(const TrainingJob& job, const std::atomic<bool>& stop,
      const std::function<void(const Json&)>& progress)
      : job_(job), settings_(job.settings), stop_(stop), progress_(progress) {}

  absl::StatusOr<TrainingEnd> Go() {
    at::set_num_threads(settings_.threads);
    InitialiseWeights(network_, settings_.seed);
    if (!job_.start.empty()) RETURN_IF_ERROR(TakeWeights());
    optimiser_.emplace(network_);
    if (!job_.resume.empty()) {
      RETURN_IF_ERROR(Resume());
    } else if (job_.minutes > 0) {
      RETURN_IF_ERROR(ChooseSteps());
    }
    RETURN_IF_ERROR(WriteCard(Json()));
    ASSIGN_OR_RETURN(const TrainingEnd end, Loop());
    if (end.exit != TrainerExit::kDone) return end;
    RETURN_IF_ERROR(Save("/final.pt"));
    RETURN_IF_ERROR(Finish());
    return end;
  }

 private:
  Json SettingsJson() const {
    Json json = ToJson(settings_);
    json["data"] = HashesOf(job_.sources);
    json["start"] = start_;
    return json;
  }

  // Begins with the weights that predict of another run.
  absl::Status TakeWeights() {
    ASSIGN_OR_RETURN(start_, Sha256HexOfFile(job_.start));
    ASSIGN_OR_RETURN(const Checkpoint checkpoint, ReadCheckpoint(job_.start, network_));
    const Tensor& weights = checkpoint.state.average;
    if (!at::isfinite(weights).all().item<bool>()) {
      return DataLoss("{}: its weights are not finite: its training has diverged", job_.start);
    }
    SetWeights(network_, weights);
    return absl::OkStatus();
  }

  absl::Status Resume() {
    ASSIGN_OR_RETURN(const Checkpoint checkpoint, ReadCheckpoint(job_.resume, network_));
    if (job_.minutes > 0) settings_.steps = checkpoint.settings.value("steps", settings_.steps);
    const std::string difference = DifferenceOf(checkpoint.settings, SettingsJson());
    if (!difference.empty()) {
      return FailedPrecondition("{} is a checkpoint of another run: it has {} is wanted",
                                job_.resume, difference);
    }
    if (checkpoint.state.weights.numel() == 0) {
      return FailedPrecondition("{} has only weights, a run can't resume from it: --start {}",
                                job_.resume, job_.resume);
    }
    optimiser_->Restore(checkpoint.state);
    first_ = checkpoint.step;
    return absl::OkStatus();
  }

  // Times forward and backward passes without changing the weights.
  absl::Status ChooseSteps() {
    BatchLoader loader(job_.sources, settings_, 0, job_.loader_threads);
    double from = Now();
    for (int i = 0; i < kTimingSteps; ++i) {
      if (i == kUntimedSteps) from = Now();
      ASSIGN_OR_RETURN(TrainingBatch batch, loader.Next());
      LossOfBatch(batch).loss.backward();
      for (const Tensor& weight : network_.parameters()) weight.grad().zero_();
    }
    const double seconds = (Now() - from) / (kTimingSteps - kUntimedSteps);
    settings_.steps = std::max<int64_t>(1, static_cast<int64_t>(60 * job_.minutes / seconds));
    return absl::OkStatus();
  }

  BatchLoss LossOfBatch(TrainingBatch& batch) {
    const BatchTensors tensors = ToTensors(batch);
    const StereoOutput output =
        network_.Forward(tensors.left, tensors.right, settings_.max_disparity);
    return LossOf(output, tensors.disparity, tensors.weight);
  }

  absl::StatusOr<TrainingEnd> Loop() {
    BatchLoader loader(job_.sources, settings_, first_, job_.loader_threads);
    Json start = {
        {"event", "start"}, {"step", first_}, {"steps", settings_.steps}, {"pairs", PairCount()}};
    progress_(start);
    began_ = saved_ = Now();
    for (int64_t step = first_; step < settings_.steps; ++step) {
      if (stop_) {
        RETURN_IF_ERROR(Save(CheckpointName(step)));
        return TrainingEnd{TrainerExit::kStopped, fmt::format("stopped at step {}", step)};
      }
      ASSIGN_OR_RETURN(TrainingBatch batch, loader.Next());
      const BatchLoss result = LossOfBatch(batch);
      const double loss = result.loss.item<double>();
      result.loss.backward();
      const double norm = optimiser_->Step(settings_, step);
      if (!std::isfinite(loss) || !std::isfinite(norm)) return NotFinite(step, batch);
      done_ = step + 1;
      if (done_ % job_.progress_every == 0 || done_ == settings_.steps) Report(result, loss, norm);
      const bool due = done_ % job_.checkpoint_every == 0 || Now() - saved_ >= job_.checkpoint_s;
      if (due && done_ < settings_.steps) RETURN_IF_ERROR(Save(CheckpointName(done_)));
    }
    return TrainingEnd{};
  }

  TrainingEnd NotFinite(int64_t step, const TrainingBatch& batch) const {
    std::string names;
    for (const std::string& name : batch.names) names += (names.empty() ? "" : ", ") + name;
    return {
        TrainerExit::kNotFinite,
        fmt::format("the loss or its gradient is not finite at step {} (pairs {})", step, names)};
  }

  void Report(const BatchLoss& result, double loss, double norm) const {
    const double seconds = (Now() - began_) / static_cast<double>(done_ - first_);
    progress_({{"step", done_},
               {"steps", settings_.steps},
               {"loss", loss},
               {"epe_px", result.epe_px},
               {"bad3", result.bad3},
               {"gradient_norm", norm},
               {"learning_rate", LearningRate(settings_, done_ - 1)},
               {"seconds_per_step", seconds},
               {"eta_s", seconds * static_cast<double>(settings_.steps - done_)}});
  }

  absl::Status Save(const std::string& name) {
    const int64_t step = name == "/final.pt" ? settings_.steps : std::max(done_, first_);
    RETURN_IF_ERROR(DiskError(WriteCheckpoint(job_.out_dir + name, network_,
                                              {step, SettingsJson(), optimiser_->state()})));
    saved_ = Now();
    progress_({{"event", "checkpoint"}, {"step", step}, {"path", job_.out_dir + name}});
    return absl::OkStatus();
  }

  absl::Status Finish() {
    Json result = {{"event", "done"}, {"steps", settings_.steps}, {"wall_s", Now() - began_}};
    if (!job_.heldout.empty()) {
      ASSIGN_OR_RETURN(result["heldout"], ScoreHeldout());
    }
    progress_(result);
    result.erase("event");
    return WriteCard(result);
  }

  // EPE and bad pixels over visible pixels, each the mean over pairs.
  absl::StatusOr<Json> ScoreHeldout() {
    ASSIGN_OR_RETURN(const Predictor predictor, Predictor::Load(job_.out_dir + "/final.pt"));
    double sums[4] = {};
    int pairs = 0;
    for (const TrainingSource& source : job_.heldout) {
      const size_t wanted = static_cast<size_t>(job_.heldout_pairs);
      const size_t stride = std::max<size_t>(1, source.frames.size() / wanted);
      for (size_t i = 0; i < source.frames.size() && i / stride < wanted; i += stride) {
        ASSIGN_OR_RETURN(const TrainingPair pair, ReadTrainingPair(source.frames[i].dir));
        ASSIGN_OR_RETURN(const ImageF seen,
                         predictor.Predict(pair.left.image, pair.right.image, {}));
        double counts[5] = {};
        for (size_t p = 0; p < seen.pixels(); ++p) {
          if (pair.left.trust.values()[p] != kVisible) continue;
          const double error = std::abs(seen.values()[p] - pair.left.disparity_px.values()[p]);
          counts[0] += error;
          for (int t = 1; t <= 3; ++t) counts[t] += error > t;
          ++counts[4];
        }
        if (counts[4] == 0) continue;
        for (int t = 0; t < 4; ++t) sums[t] += counts[t] / counts[4];
        ++pairs;
      }
    }
    if (pairs == 0) return FailedPrecondition("no held-out pair has visible pixels");
    return Json{{"pairs", pairs},
                {"epe_px", sums[0] / pairs},
                {"bad1", sums[1] / pairs},
                {"bad2", sums[2] / pairs},
                {"bad3", sums[3] / pairs}};
  }

  int64_t PairCount() const {
    int64_t count = 0;
    for (const TrainingSource& source : job_.sources)
      count += static_cast<int64_t>(source.frames.size());
    return count;
  }

  // train.json: all that repeats the run, and its outcome once there is one.
  absl::Status WriteCard(const Json& result) const {
    Json data = Json::array();
    for (const TrainingSource& source : job_.sources) {
      data.push_back({{"path", source.path},
                      {"weight", source.weight},
                      {"pairs", source.frames.size()},
                      {"left_out_by_filters", source.left_out},
                      {"sha256", source.data_hash}});
    }
    int64_t weights = 0;
    for (const Tensor& weight : network_.parameters()) weights += weight.numel();
    Json card = {{"trainer", "builtin"},           {"program_version", kProgramVersion},
                 {"torch_version", TORCH_VERSION}, {"weights", weights},
                 {"settings", ToJson(settings_)},  {"data", data},
                 {"start_sha256", start_},         {"resumed_from_step", first_}};
    if (!result.is_null()) card["result"] = result;
    return DiskError(WriteFile(job_.out_dir + "/train.json", card.dump(2) + "\n"));
  }

  const TrainingJob& job_;
  TrainSettings settings_;
  const std::atomic<bool>& stop_;
  const std::function<void(const Json&)>& progress_;
  StereoNetwork network_;
  std::optional<Optimiser> optimiser_;
  Json start_;  // SHA-256 of the file whose weights it begins with, or null.
  int64_t first_ = 0, done_ = 0;
  double began_ = 0, saved_ = 0;
};

}  // namespace

TrainingEnd RunTraining(const TrainingJob& job, const std::atomic<bool>& stop,
                        const std::function<void(const Json&)>& progress) {
  try {
    const absl::Status settings = CheckSettings(job.settings);
    if (!settings.ok()) return {TrainerExit::kUsage, std::string(ToStd(settings.message()))};
    std::error_code error;
    std::filesystem::create_directories(job.out_dir, error);
    absl::StatusOr<TrainingEnd> end = Run(job, stop, progress).Go();
    if (end.ok()) return *end;
    const std::string why(ToStd(end.status().message()));
    if (absl::IsResourceExhausted(end.status())) return OutOfMemory(why);
    if (absl::IsInvalidArgument(end.status())) return {TrainerExit::kUsage, why};
    return {TrainerExit::kFailed, why};
  } catch (const std::bad_alloc&) {
    return OutOfMemory("");
  } catch (const std::exception& error) {
    const std::string text = error.what();
    const std::string line = text.substr(0, text.find('\n'));
    if (text.find("can't allocate memory") != std::string::npos ||
        text.find("out of memory") != std::string::npos) {
      return OutOfMemory(line);
    }
    return {TrainerExit::kFailed, line};
  }
}

}  // namespace parallax
