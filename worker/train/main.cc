// The program `trainer`: trains the built-in stereo network on datasets, and predicts with it. It
// is a program of its own so that what goes wrong in torch takes no worker along.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "common/base/file.h"
#include "common/base/status.h"
#include "common/base/version.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "worker/train/predictor.h"
#include "worker/train/torchscript.h"
#include "worker/train/training.h"

namespace parallax {
namespace {

std::atomic<bool> stop_requested = false;

void RequestStop(int) { stop_requested = true; }

int Fail(TrainerExit exit, std::string_view message) {
  std::cerr << "trainer: " << message << "\n";
  return static_cast<int>(exit);
}

int Fail(const absl::Status& status) {
  const bool usage = absl::IsInvalidArgument(status), memory = absl::IsResourceExhausted(status);
  return Fail(usage    ? TrainerExit::kUsage
              : memory ? TrainerExit::kOutOfMemory
                       : TrainerExit::kFailed,
              ToStd(status.message()));
}

// ---- train

struct TrainOptions {
  TrainingJob job;
  std::vector<std::string> data, heldout;
  std::string crop = "192x384";
  SourceOptions sources;
};

absl::Status ParseSize(const std::string& option, const std::string& text,
                       TrainSettings& settings) {
  char end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &settings.crop_height, &settings.crop_width, &end) == 2)
    return absl::OkStatus();
  return InvalidArgument("{} is \"{}\", but must be HEIGHTxWIDTH, for example 192x384", option,
                         text);
}

absl::Status ReadSources(const std::vector<std::string>& specs, const SourceOptions& options,
                         std::vector<TrainingSource>& sources) {
  for (const std::string& spec : specs) {
    ASSIGN_OR_RETURN(TrainingSource source, ReadTrainingSource(spec, options));
    if (source.heldout_left_out) {
      std::cerr << "note: " << source.path
                << ": the pairs of heldout are left out; give that variant's own folder for them\n";
    }
    sources.push_back(std::move(source));
  }
  return absl::OkStatus();
}

int Train(TrainOptions& options) {
  TrainingJob& job = options.job;
  absl::Status status = ParseSize("--crop", options.crop, job.settings);
  if (status.ok()) status = ReadSources(options.data, options.sources, job.sources);
  SourceOptions heldout = options.sources;
  heldout.heldout = true;
  if (status.ok()) status = ReadSources(options.heldout, heldout, job.heldout);
  if (!status.ok()) return Fail(status);
  std::signal(SIGTERM, RequestStop);
  std::signal(SIGINT, RequestStop);
  const TrainingEnd end = RunTraining(job, stop_requested, [](const nlohmann::ordered_json& line) {
    std::cout << line.dump() << std::endl;
  });
  return end.exit == TrainerExit::kDone ? 0 : Fail(end.exit, end.message);
}

CLI::App* AddTrain(CLI::App& app, TrainOptions& o) {
  CLI::App* command =
      app.add_subcommand("train", "Train on datasets; progress as JSON lines on stdout");
  TrainSettings& s = o.job.settings;
  command
      ->add_option("--data", o.data,
                   "A dataset's folder (all variants but heldout) or a variant's, with =WEIGHT in "
                   "mixtures; may be repeated")
      ->required();
  command->add_option("--out", o.job.out_dir, "Folder for checkpoints and train.json")->required();
  command->add_option("--seed", s.seed, "Of weights, order and augmentation")
      ->capture_default_str();
  auto* steps = command->add_option("--steps", s.steps, "Steps to train")->capture_default_str();
  command
      ->add_option("--minutes", o.job.minutes,
                   "Instead of --steps: as many as fit, by timing a few first")
      ->excludes(steps)
      ->check(CLI::Range(0.01, 1e6));
  command->add_option("--resume", o.job.resume, "A checkpoint of the same run to go on from");
  command->add_option("--threads", s.threads, "CPU threads; part of what decides the result")
      ->capture_default_str();
  command->add_option("--crop", o.crop, "HEIGHTxWIDTH of the crops, multiples of 32")
      ->capture_default_str();
  command->add_option("--batch", s.batch, "Crops a step")->capture_default_str();
  command->add_option("--learning-rate", s.learning_rate, "Peak of the one-cycle schedule")
      ->capture_default_str();
  command
      ->add_option("--scale-low", s.augment.scale_low,
                   "Least enlargement of crops, as a power of 2")
      ->capture_default_str();
  command
      ->add_option("--scale-high", s.augment.scale_high,
                   "Greatest enlargement of crops, as a power of 2")
      ->capture_default_str();
  command->add_option("--checkpoint-every", o.job.checkpoint_every, "Steps")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--checkpoint-s", o.job.checkpoint_s,
                   "Also when the last one is so old; seconds")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1e9));
  command->add_option("--progress-every", o.job.progress_every, "Steps")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command->add_option("--heldout", o.heldout, "Datasets to score at the end");
  command->add_option("--heldout-pairs", o.job.heldout_pairs, "Pairs of each")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command->add_flag("--unfiltered", o.sources.unfiltered,
                    "Also train on pairs that a filter turned down");
  command->add_flag("--allow-missing", o.sources.allow_missing,
                    "Leave out pairs whose files are missing");
  return command;
}

// ---- predict and export

struct PredictArguments {
  std::string checkpoint, list, left, right, out, size;
  PredictOptions options;
};

absl::Status PredictOne(const Predictor& predictor, const PredictArguments& a,
                        const std::string& left_path, const std::string& right_path,
                        const std::string& out) {
  ASSIGN_OR_RETURN(const ImageRgb8 left, ReadPictureRgb8(left_path));
  ASSIGN_OR_RETURN(const ImageRgb8 right, ReadPictureRgb8(right_path));
  absl::StatusOr<ImageF> disparity = predictor.Predict(left, right, a.options);
  if (!disparity.ok()) return WithContext(disparity.status(), left_path + " and " + right_path);
  const absl::Status written = WritePfm(out, *disparity);
  // A full disk has the code of exhausted memory, and another exit status.
  return absl::IsResourceExhausted(written) ? Unavailable("{}", written.message()) : written;
}

absl::Status PredictList(const Predictor& predictor, const PredictArguments& a) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(a.list));
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string left, right, out, more;
    if (!(words >> left)) continue;
    if (!(words >> right >> out) || (words >> more)) {
      return InvalidArgument("{}:{}: wanted \"left right output.pfm\"", a.list, number);
    }
    RETURN_IF_ERROR(PredictOne(predictor, a, left, right, out));
  }
  return absl::OkStatus();
}

int Predict(const PredictArguments& a) {
  if (a.list.empty() == (a.left.empty() || a.right.empty() || a.out.empty())) {
    return Fail(TrainerExit::kUsage, "predict: give --list, or --left, --right and --out");
  }
  const absl::StatusOr<Predictor> predictor = Predictor::Load(a.checkpoint);
  if (!predictor.ok()) return Fail(predictor.status());
  const absl::Status status = a.list.empty() ? PredictOne(*predictor, a, a.left, a.right, a.out)
                                             : PredictList(*predictor, a);
  return status.ok() ? 0 : Fail(status);
}

CLI::App* AddPredict(CLI::App& app, PredictArguments& a) {
  CLI::App* command = app.add_subcommand("predict", "Disparities of stereo pairs as PFM files");
  command->add_option("--checkpoint", a.checkpoint, "Of `trainer train`")->required();
  command->add_option("--list", a.list, "File with a line \"left right output.pfm\" for each pair");
  command->add_option("--left", a.left, "Left image");
  command->add_option("--right", a.right, "Right image");
  command->add_option("--out", a.out, "Disparities of the left image, pixels");
  command
      ->add_option("--max-disparity", a.options.max_disparity,
                   "Pixels to search (default: as trained)")
      ->check(CLI::Range(1.0, 1e5));
  command->add_option("--threads", a.options.threads, "CPU threads")->check(CLI::Range(1, 1024));
  return command;
}

int Export(const PredictArguments& a) {
  TrainSettings size;
  absl::Status status = ParseSize("--size", a.size, size);
  if (status.ok())
    status = ExportTorchScript(a.checkpoint, a.out, size.crop_height, size.crop_width);
  return status.ok() ? 0 : Fail(status);
}

CLI::App* AddExport(CLI::App& app, PredictArguments& a) {
  CLI::App* command =
      app.add_subcommand("export", "A checkpoint as a TorchScript module for one image size");
  command->add_option("--checkpoint", a.checkpoint, "Of `trainer train`")->required();
  command->add_option("--torchscript", a.out, "The module's file")->required();
  command->add_option("--size", a.size, "HEIGHTxWIDTH of its images, multiples of 32")->required();
  return command;
}

int Run(int argc, char** argv) {
  CLI::App app{"Trains and runs Parallax's built-in stereo network"};
  app.set_version_flag("--version", std::string("trainer ") + kProgramVersion);
  app.require_subcommand(1);
  TrainOptions train;
  PredictArguments predict, exported;
  CLI::App* train_command = AddTrain(app, train);
  CLI::App* predict_command = AddPredict(app, predict);
  CLI::App* export_command = AddExport(app, exported);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(TrainerExit::kUsage);
  }
  if (train_command->parsed()) return Train(train);
  if (predict_command->parsed()) return Predict(predict);
  if (export_command->parsed()) return Export(exported);
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Run(argc, argv); }
