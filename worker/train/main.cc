// The program `trainer`: trains the built-in stereo network on datasets, and predicts with it. It
// is a program of its own so that what goes wrong in torch takes no worker along.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/usage_error.h"
#include "common/base/version.h"
#include "common/image/io.h"
#include "common/image/picture_pair.h"
#include "worker/train/network/checkpoint_export.h"
#include "worker/train/network/exchange_network.h"
#include "worker/train/trained_predictor.h"
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
  const CLI::Option* learning_rate = nullptr;
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
  if (!job.start.empty() && options.learning_rate->count() == 0) {
    job.settings.learning_rate = kStartedLearningRate;
  }
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
  command->add_option("--seed", s.seed, "Seed of weights, order and augmentation")
      ->capture_default_str();
  auto* steps = command->add_option("--steps", s.steps, "Steps to train")->capture_default_str();
  command
      ->add_option("--minutes", o.job.minutes,
                   "Instead of --steps: as many steps as fit into this time, from timing a few")
      ->excludes(steps)
      ->check(CLI::Range(0.01, 1e6));
  command->add_option("--start", o.job.start,
                      "Begin with the weights of this checkpoint, of any run");
  command->add_option("--resume", o.job.resume, "Resume from this checkpoint of the same run");
  command->add_option("--threads", s.threads, "CPU threads; another number changes the result")
      ->capture_default_str();
  command->add_option("--crop", o.crop, "HEIGHTxWIDTH of the crops, multiples of 32")
      ->capture_default_str();
  command->add_option("--batch", s.batch, "Crops a step")->capture_default_str();
  o.learning_rate = command
                        ->add_option("--learning-rate", s.learning_rate,
                                     fmt::format("Peak of the one-cycle schedule; with --start {} "
                                                 "unless given",
                                                 kStartedLearningRate))
                        ->capture_default_str();
  command
      ->add_option("--scale-low", s.augment.scale_low,
                   "Least enlargement of crops, as a power of 2")
      ->capture_default_str();
  command
      ->add_option("--scale-high", s.augment.scale_high,
                   "Greatest enlargement of crops, as a power of 2")
      ->capture_default_str();
  command->add_option("--checkpoint-every", o.job.checkpoint_every, "Steps between checkpoints")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--checkpoint-s", o.job.checkpoint_s, "Also write one after this many seconds")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1e9));
  command->add_option("--progress-every", o.job.progress_every, "Steps between lines of progress")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command->add_option("--heldout", o.heldout, "Datasets to score at the end");
  command->add_option("--heldout-pairs", o.job.heldout_pairs, "Pairs of each dataset to score")
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
  std::string checkpoint, list, left, right, out, size, format = "checkpoint", channels = "rgb";
  std::vector<double> mean, std;
  PredictOptions options;
  NetworkConventions conventions;
  const CLI::App* convention_options = nullptr;  // Only for networks in exchange formats.
  const CLI::Option* search_option = nullptr;    // Only for checkpoints, as the next one.
  const CLI::Option* looks_option = nullptr;
};

using PredictPair =
    std::function<absl::StatusOr<ImageF>(const ImageRgb8& left, const ImageRgb8& right)>;

absl::StatusOr<PredictPair> LoadCheckpoint(const PredictArguments& a) {
  ASSIGN_OR_RETURN(Predictor loaded, Predictor::Load(a.checkpoint));
  const auto predictor = std::make_shared<Predictor>(std::move(loaded));
  return [predictor, &a](const ImageRgb8& left, const ImageRgb8& right) {
    return predictor->Predict(left, right, a.options);
  };
}

absl::StatusOr<PredictPair> LoadExchanged(const PredictArguments& a) {
  NetworkConventions conventions = a.conventions;
  conventions.bgr = a.channels == "bgr";
  if (!a.mean.empty()) std::copy_n(a.mean.begin(), 3, conventions.mean.begin());
  if (!a.std.empty()) std::copy_n(a.std.begin(), 3, conventions.std.begin());
  if (!a.size.empty()) {
    TrainSettings size;
    RETURN_IF_ERROR(ParseSize("--size", a.size, size));
    conventions.width_px = size.crop_width;
    conventions.height_px = size.crop_height;
  }
  const auto format = a.format == "onnx" ? ExchangeFormat::kOnnx : ExchangeFormat::kTorchScript;
  ASSIGN_OR_RETURN(ExchangeNetwork loaded,
                   ExchangeNetwork::Load(a.checkpoint, format, conventions, a.options.threads));
  const auto network = std::make_shared<ExchangeNetwork>(std::move(loaded));
  return [network](const ImageRgb8& left, const ImageRgb8& right) {
    return network->Predict(left, right);
  };
}

absl::Status PredictOne(const PredictPair& predict, const std::string& left_path,
                        const std::string& right_path, const std::string& out) {
  ASSIGN_OR_RETURN(const PicturePair pair, ReadPicturePair(left_path, right_path));
  for (const std::string& note : pair.notes) std::cerr << "note: " << note << "\n";
  absl::StatusOr<ImageF> disparity = predict(pair.left, pair.right);
  if (!disparity.ok()) return WithContext(disparity.status(), left_path + " and " + right_path);
  const absl::Status written = WritePfm(out, *disparity);
  // A full disk has the code of exhausted memory, and another exit status.
  return absl::IsResourceExhausted(written) ? Unavailable("{}", written.message()) : written;
}

absl::Status PredictList(const PredictPair& predict, const std::string& list) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(list));
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string left, right, out, more;
    if (!(words >> std::quoted(left))) continue;
    if (!(words >> std::quoted(right) >> std::quoted(out)) || (words >> more)) {
      return InvalidArgument("{}:{}: wanted \"left right output.pfm\", names with blanks in \"\"",
                             list, number);
    }
    RETURN_IF_ERROR(PredictOne(predict, left, right, out));
  }
  return absl::OkStatus();
}

// Tells of an option that has no effect with the format.
absl::Status CheckOptionsFit(const PredictArguments& a) {
  const bool exchanged = a.format != "checkpoint";
  for (const CLI::Option* option : {a.search_option, a.looks_option}) {
    if (!exchanged || option->count() == 0) continue;
    return InvalidArgument("{} has no effect on a network in the format {}", option->get_name(),
                           a.format);
  }
  for (const CLI::Option* option : a.convention_options->get_options()) {
    if (exchanged || option->count() == 0) continue;
    return InvalidArgument("{} has no effect without --format torchscript or onnx",
                           option->get_name());
  }
  return absl::OkStatus();
}

int Predict(const PredictArguments& a) {
  if (const absl::Status fit = CheckOptionsFit(a); !fit.ok()) return Fail(fit);
  if (a.list.empty() == (a.left.empty() || a.right.empty() || a.out.empty())) {
    return Fail(TrainerExit::kUsage, "predict: give --list, or --left, --right and --out");
  }
  const auto predict = a.format == "checkpoint" ? LoadCheckpoint(a) : LoadExchanged(a);
  if (!predict.ok()) return Fail(predict.status());
  const absl::Status status =
      a.list.empty() ? PredictOne(*predict, a.left, a.right, a.out) : PredictList(*predict, a.list);
  return status.ok() ? 0 : Fail(status);
}

// Options for networks in exchange formats.
void AddConventions(CLI::App& predict, PredictArguments& a) {
  CLI::App& command = *predict.add_option_group("TorchScript and ONNX");
  a.convention_options = &command;
  NetworkConventions& c = a.conventions;
  command.add_option("--pixel-range", c.pixel_range, "Value of a white pixel")
      ->capture_default_str()
      ->check(CLI::Range(1e-9, 1e9));
  command.add_option("--mean", a.mean, "Three values subtracted from the channels")
      ->expected(3)
      ->delimiter(',');
  command.add_option("--std", a.std, "Three values that the channels are divided by")
      ->expected(3)
      ->delimiter(',')
      ->check(CLI::Range(1e-9, 1e9));
  command.add_option("--channels", a.channels, "Order of the channels")
      ->capture_default_str()
      ->check(CLI::IsMember({"rgb", "bgr"}));
  command.add_option("--pad-multiple", c.pad_multiple, "Pictures are padded to multiples of this")
      ->capture_default_str()
      ->check(CLI::Range(1, 4096));
  command.add_option("--size", a.size,
                     "HEIGHTxWIDTH that the network takes; pictures are scaled to it");
  command.add_option("--output", c.output, "Number of its output; negative: from the end")
      ->capture_default_str();
  command.add_flag("--negate", c.negate, "Its output is negative disparity");
}

CLI::App* AddPredict(CLI::App& app, PredictArguments& a) {
  CLI::App* command = app.add_subcommand("predict", "Disparities of stereo pairs as PFM files");
  command
      ->add_option("--checkpoint", a.checkpoint,
                   "Checkpoint of `trainer train`, or a network of --format")
      ->required();
  command
      ->add_option("--format", a.format,
                   "torchscript or onnx: a network of any trainer, with the options below")
      ->capture_default_str()
      ->check(CLI::IsMember({"checkpoint", "torchscript", "onnx"}));
  command->add_option("--list", a.list, "File with a line \"left right output.pfm\" for each pair");
  command->add_option("--left", a.left, "Left image");
  command->add_option("--right", a.right, "Right image");
  command->add_option("--out", a.out, "Disparities of the left image, pixels");
  a.search_option = command
                        ->add_option("--max-disparity", a.options.max_disparity,
                                     "Pixels to search (default: as trained)")
                        ->check(CLI::Range(1.0, 1e5));
  a.looks_option = command
                       ->add_option("--looks", a.options.looks,
                                    "2: predict twice, reduced and enlarged (default); "
                                    "1: once, small pairs in a fifth of the time")
                       ->check(CLI::Range(1, 2));
  command->add_option("--threads", a.options.threads, "CPU threads")->check(CLI::Range(1, 1024));
  AddConventions(*command, a);
  return command;
}

struct ExportArguments {
  std::string checkpoint, torchscript, size, weights;
};

absl::Status Export(const ExportArguments& a) {
  if (!a.weights.empty()) return ExportWeights(a.checkpoint, a.weights);
  TrainSettings size;
  RETURN_IF_ERROR(ParseSize("--size", a.size, size));
  return ExportTorchScript(a.checkpoint, a.torchscript, size.crop_height, size.crop_width);
}

CLI::App* AddExport(CLI::App& app, ExportArguments& a) {
  CLI::App* command = app.add_subcommand(
      "export", "A checkpoint as a TorchScript module for one image size, or its weights");
  command->add_option("--checkpoint", a.checkpoint, "Of `trainer train`")->required();
  CLI::App* const what = command->add_option_group("What to write");
  CLI::Option* const module =
      what->add_option("--torchscript", a.torchscript, "A module: its file");
  what->add_option("--weights", a.weights,
                   "A checkpoint that predicts and starts runs, a quarter of the bytes: its file");
  what->require_option(1);
  CLI::Option* const size =
      command->add_option("--size", a.size, "HEIGHTxWIDTH of the module's images, multiples of 32");
  size->needs(module);
  module->needs(size);
  return command;
}

int Run(int argc, char** argv) {
  CLI::App app{"Trains and runs Parallax's built-in stereo network", "trainer"};
  app.set_version_flag("--version", std::string("trainer ") + kProgramVersion);
  app.require_subcommand(1);
  TrainOptions train;
  PredictArguments predict;
  ExportArguments exported;
  CLI::App* train_command = AddTrain(app, train);
  CLI::App* predict_command = AddPredict(app, predict);
  CLI::App* export_command = AddExport(app, exported);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "trainer: " << ExplainUsage(app, error, {argv + 1, argv + argc}) << std::endl;
    return static_cast<int>(TrainerExit::kUsage);
  }
  if (train_command->parsed()) return Train(train);
  if (predict_command->parsed()) return Predict(predict);
  if (export_command->parsed()) {
    const absl::Status status = Export(exported);
    return status.ok() ? 0 : Fail(status);
  }
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Run(argc, argv); }
