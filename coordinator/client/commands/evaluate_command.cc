// evaluate: the errors of one predictor on benchmarks, as score files.
#include "coordinator/client/commands/evaluate_command.h"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "coordinator/client/cancellable.h"
#include "coordinator/client/content/predictor_choice.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "worker/evaluate/evaluation.h"
#include "worker/evaluate/group_errors.h"
#include "worker/evaluate/prediction_sheet.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr size_t kMostNotes = 6;  // Printed for the pairs of one benchmark.

struct EvaluateCommandOptions {
  PredictorChoice predictor;
  std::vector<std::string> benchmarks = {"shipped"};
  std::string benchmarks_dir;
  std::string out;
  std::string variant, trainer;
  std::optional<int64_t> seed;
  int pairs = 0;
  bool pictures = false, keep_predictions = false, list = false;
};

absl::StatusOr<ExitCode> ListBenchmarks(Session& session) {
  if (session.options.json) {
    Json kinds = Json::array();
    for (const BenchmarkKind& kind : BenchmarkKinds()) {
      kinds.push_back({{"name", kind.name},
                       {"takes_path", kind.takes_path},
                       {"description", kind.description},
                       {"layout", kind.layout}});
    }
    return session.PrintJson({{"benchmarks", kinds}});
  }
  Table table({"NAME", "PAIRS AND FIGURE, FILES BELOW --benchmarks DIR"});
  for (const BenchmarkKind& kind : BenchmarkKinds()) {
    table.AddRow({kind.name + (kind.takes_path ? ":PATH" : ""), kind.description});
    table.AddRow({"", kind.layout});
  }
  table.Print(session.out());
  return kExitOk;
}

// Letters, digits, '.', '_' and '-' of a name; everything else becomes '_'.
std::string FileNameOf(std::string text) {
  for (char& c : text) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  }
  return text;
}

std::string StemOf(const std::string& benchmark, const RunIdentity& run) {
  return FileNameOf(run.variant) + "." + FileNameOf(run.trainer) +
         (run.seed ? fmt::format(".seed{}", *run.seed) : "") + "." + FileNameOf(benchmark);
}

// Files of one evaluation below the output folder.
struct Outputs {
  std::string scores, work;
  std::vector<std::string> pictures, notes;
};

absl::Status DrawPictures(const Benchmark& benchmark, const Evaluation& evaluation,
                          const std::string& stem, Outputs& outputs) {
  outputs.pictures.push_back(stem + ".png");
  RETURN_IF_ERROR(
      DrawPredictionSheet(benchmark, evaluation, outputs.work, outputs.pictures.back()));
  for (const std::string group : {"class", "material"}) {
    const auto errors = GroupErrors({evaluation}, group);
    if (!errors.ok()) continue;  // Only our own archives have them.
    const std::string name = stem + ".by_" + group;
    RETURN_IF_ERROR(WriteFile(name + ".csv", GroupErrorsCsv(*errors)));
    RETURN_IF_ERROR(DrawGroupErrors(
        *errors, "Error by " + group + ": " + evaluation.run.variant + " on " + benchmark.name,
        name + ".png"));
    outputs.pictures.insert(outputs.pictures.end(), {name + ".csv", name + ".png"});
  }
  return absl::OkStatus();
}

int64_t InvalidPixels(const Evaluation& evaluation) {
  int64_t invalid = 0;
  for (const Scores& scores : evaluation.images) invalid += scores.regions.at("all").invalid;
  return invalid;
}

Json EvaluationJson(const Evaluation& evaluation, const Outputs& outputs) {
  Json figures = Json::object();
  figures[MetricName(evaluation.headline)] = FigureOf(evaluation.headline, evaluation);
  for (const Metric& metric : evaluation.figures) {
    figures[MetricName(metric)] = FigureOf(metric, evaluation);
  }
  return {{"benchmark", evaluation.benchmark},
          {"metric", MetricName(evaluation.headline)},
          {"value", FigureOf(evaluation.headline, evaluation)},
          {"pairs", evaluation.images.size()},
          {"pairs_published", evaluation.pairs_published},
          {"invalid_pixels", InvalidPixels(evaluation)},
          {"figures", std::move(figures)},
          {"mimics", evaluation.mimics},
          {"seconds", evaluation.seconds},
          {"scores", outputs.scores},
          {"pictures", outputs.pictures},
          {"notes", outputs.notes}};
}

void PrintEvaluation(const Evaluation& evaluation, const Outputs& outputs, Session& session) {
  std::ostream& out = *session.out().stream;
  const auto figure = [&](const Metric& metric) {
    return MetricName(metric) + " " + FormatNumber(FigureOf(metric, evaluation));
  };
  out << session.out().Paint(Tone::kBold, evaluation.benchmark) << ": "
      << figure(evaluation.headline);
  for (const Metric& metric : evaluation.figures) {
    if (std::isfinite(FigureOf(metric, evaluation))) out << ", " << figure(metric);
  }
  out << " (" << Plural(static_cast<int64_t>(evaluation.images.size()), "pair") << ", "
      << FormatDuration(evaluation.seconds) << ")\n  " << outputs.scores << "\n";
  for (const std::string& picture : outputs.pictures) out << "  " << picture << "\n";
  if (outputs.notes.size() > kMostNotes) {
    session.PrintNote(evaluation.benchmark + ": " +
                      Plural(static_cast<int64_t>(outputs.notes.size() - kMostNotes), "more note") +
                      " on its pairs (--json prints all)");
  }
  if (const int64_t invalid = InvalidPixels(evaluation); invalid > 0) {
    session.PrintNote(FormatCount(invalid) +
                      " pixels have no valid prediction; they count as wrong");
  }
  const auto pairs = static_cast<int>(evaluation.images.size());
  if (evaluation.pairs_published > 0 && pairs != evaluation.pairs_published) {
    session.PrintNote(evaluation.benchmark + ": " + Plural(pairs, "pair") + ", the whole set has " +
                      FormatCount(evaluation.pairs_published) +
                      "; not comparable with published figures");
  }
}

// Two benchmarks of one name would share their files. Errors: kInvalidArgument naming both.
absl::Status CheckFilesDiffer(const EvaluateCommandOptions& options,
                              const std::vector<Benchmark>& benchmarks, const RunIdentity& run) {
  std::map<std::string, std::string> given_by_stem;
  for (size_t i = 0; i < benchmarks.size(); ++i) {
    const std::string stem = StemOf(benchmarks[i].name, run);
    const auto [first, is_new] = given_by_stem.try_emplace(stem, options.benchmarks[i]);
    if (is_new) continue;
    return InvalidArgument(
        "--on {} and --on {} would both write {}.jsonl: give one another name, NAME=KIND:PATH",
        first->second, options.benchmarks[i], stem);
  }
  return absl::OkStatus();
}

// Opens all benchmarks before the first prediction, so that a missing file is found at once.
absl::StatusOr<std::vector<Benchmark>> OpenAll(const EvaluateCommandOptions& options) {
  std::vector<Benchmark> benchmarks;
  for (const std::string& what : options.benchmarks) {
    ASSIGN_OR_RETURN(Benchmark benchmark, OpenBenchmark(what, options.benchmarks_dir));
    benchmarks.push_back(Thinned(std::move(benchmark), options.pairs));
  }
  return benchmarks;
}

absl::StatusOr<ChosenPredictor> Choose(const EvaluateCommandOptions& options) {
  ASSIGN_OR_RETURN(ChosenPredictor chosen, ChoosePredictor(options.predictor));
  if (!options.variant.empty()) chosen.run.variant = options.variant;
  if (!options.trainer.empty()) chosen.run.trainer = options.trainer;
  if (options.seed) chosen.run.seed = options.seed;
  return chosen;
}

// Scores one benchmark and leaves its files; returns what --json says of it.
absl::StatusOr<Json> EvaluateOne(const EvaluateCommandOptions& options,
                                 const ChosenPredictor& chosen, const Benchmark& benchmark,
                                 const CancelToken& cancel, Session& session) {
  const std::string stem = options.out + "/" + StemOf(benchmark.name, chosen.run);
  Outputs outputs{.scores = stem + ".jsonl", .work = stem + ".predictions"};
  const auto note = [&](const std::string& text) {
    if (session.err().interactive) *session.err().stream << "\r\033[K";
    if (outputs.notes.size() < kMostNotes) session.PrintNote(benchmark.name + ": " + text);
    outputs.notes.push_back(text);
  };
  const auto progress = [&](std::string_view stage, int done, int total) {
    if (!session.err().interactive) return;
    *session.err().stream << "\r\033[K" << benchmark.name << ": " << stage << " " << done << " of "
                          << total << (done < total ? "" : "\r\033[K") << std::flush;
  };
  ASSIGN_OR_RETURN(const Evaluation evaluation, Evaluate(*chosen.predictor, benchmark,
                                                         {.run = chosen.run,
                                                          .work_dir = outputs.work,
                                                          .keep_predictions = true,
                                                          .cancel = cancel,
                                                          .clock = session.environment.clock,
                                                          .note = note,
                                                          .progress = progress}));
  RETURN_IF_ERROR(WriteEvaluation(outputs.scores, evaluation));
  if (options.pictures) RETURN_IF_ERROR(DrawPictures(benchmark, evaluation, stem, outputs));
  std::error_code error;
  if (!options.keep_predictions) fs::remove_all(outputs.work, error);
  if (!session.options.json) PrintEvaluation(evaluation, outputs, session);
  return EvaluationJson(evaluation, outputs);
}

absl::StatusOr<ExitCode> RunEvaluate(const EvaluateCommandOptions& options, Session& session) {
  if (options.list) return ListBenchmarks(session);
  if (options.out.empty()) return InvalidArgument("--out is required");
  ASSIGN_OR_RETURN(const ChosenPredictor chosen, Choose(options));
  ASSIGN_OR_RETURN(const std::vector<Benchmark> benchmarks, OpenAll(options));
  RETURN_IF_ERROR(CheckFilesDiffer(options, benchmarks, chosen.run));
  RETURN_IF_ERROR(MakeFolders(options.out));
  const CancellableScope cancellable;
  Json all = Json::array();
  for (const Benchmark& benchmark : benchmarks) {
    ASSIGN_OR_RETURN(Json one,
                     EvaluateOne(options, chosen, benchmark, cancellable.token(), session));
    all.push_back(std::move(one));
  }
  if (session.options.json) {
    session.PrintJson({{"variant", chosen.run.variant},
                       {"trainer", chosen.run.trainer},
                       {"seed", chosen.run.seed ? Json(*chosen.run.seed) : Json()},
                       {"evaluations", all}});
  }
  return kExitOk;
}

void AddPredictorOptions(CLI::App* command, PredictorChoice& choice) {
  AddOption(command, "--trainer-program", "FILE", choice.trainer_program,
            "Predicts from a checkpoint (default: `trainer` beside this program, or "
            "$PARALLAX_TRAINER)");
  command
      ->add_option("--pair-s", choice.pair_s,
                   "Time limit of a pair for checkpoints and commands (default 120)")
      ->check(CLI::Range(0.1, 1e6));
}

}  // namespace

void RegisterEvaluate(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "evaluate", "Score predictions on benchmarks of real or generated pairs",
      "PREDICTOR is `network` (comes with Parallax unless $PARALLAX_NETWORK names another),\n"
      "`sgbm` (OpenCV's matcher, the classical baseline), a checkpoint of the built-in trainer,\n"
      "or a folder of predictions <pair>.pfm, .npy, .exr or .png (16 bits, x256). With --command\n"
      "any program predicts: {list} becomes a file of lines `left right output.pfm`.\n"
      "One score file a benchmark; `parallax table` makes tables of them. Pixels without a valid\n"
      "prediction count as wrong, a pair without a prediction is an error.\n"
      "\n"
      "Examples:\n"
      "  parallax evaluate --list                    list the benchmarks and their files\n"
      "  parallax evaluate network --out scores      on the real pair that comes with Parallax\n"
      "  parallax evaluate default-1.pt --variant default --seed 1 --out scores \\\n"
      "      --benchmarks ~/stereo --on middlebury2014-H --on eth3d --on kitti2015\n"
      "  parallax evaluate --command 'python predict.py {list}' --variant mine --out scores \\\n"
      "      --on heldout=archive:out/heldout --on list:pairs.txt --pictures\n");
  auto options = std::make_shared<EvaluateCommandOptions>();
  command->add_option("PREDICTOR", options->predictor.what,
                      "network, sgbm, a checkpoint, or a folder");
  AddOption(command, "--command", "CMD", options->predictor.command,
            "A command with {list}, run by /bin/sh, that writes each output as PFM");
  AddOption(command, "--on", "BENCHMARK", options->benchmarks,
            "A benchmark: a name of --list, list:FILE, folder:DIR or archive:DIR, with an "
            "optional name= in front; may be repeated (default: shipped)");
  AddOption(command, "--benchmarks", "DIR", options->benchmarks_dir,
            "The folder with the downloaded benchmarks (default: $PARALLAX_BENCHMARKS)")
      ->envname("PARALLAX_BENCHMARKS");
  AddOption(command, "-o,--out", "DIR2", options->out, "The folder of score files");
  AddOption(command, "--variant", "NAME", options->variant,
            "Name of its training set (default: the checkpoint's file or folder)");
  AddOption(command, "--trainer", "NAME", options->trainer, "Name of its trainer");
  command->add_option(
      "--seed", options->seed,
      "Seed of its training (default: that of the checkpoint's train.json, else 0; none for "
      "what isn't trained)");
  command
      ->add_option("--pairs", options->pairs,
                   "Number of pairs of each benchmark, spread evenly (default: all)")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--looks", options->predictor.looks,
                   "2: predict twice, reduced and enlarged (default); 1: once, small pairs in a "
                   "fifth of the time")
      ->check(CLI::Range(1, 2));
  command->add_flag(
      "--pictures", options->pictures,
      "Draw predictions of the best and worst pairs, and errors by class and material");
  command->add_flag("--keep-predictions", options->keep_predictions,
                    "Leave the predicted disparities in DIR2");
  command->add_flag("--list", options->list, "List the benchmarks and their files");
  AddPredictorOptions(command, options->predictor);
  registry.AddJsonOption(command);
  registry.SetAction(command,
                     [options](Session& session) { return RunEvaluate(*options, session); });
}

}  // namespace parallax::client
