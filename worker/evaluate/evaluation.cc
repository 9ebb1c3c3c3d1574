#include "worker/evaluate/evaluation.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "common/base/seconds.h"
#include "common/image/io.h"
#include "worker/evaluate/prepared_pair.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

std::string SizeText(int width, int height) { return fmt::format("{}x{}", width, height); }

absl::Status MakeFolder(const std::string& dir) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) return ErrnoError(error.value(), "make " + dir);
  return absl::OkStatus();
}

// Errors: kCancelled once the evaluation is to stop.
absl::Status CheckGoesOn(const Benchmark& benchmark, const EvaluateOptions& options) {
  if (!options.cancel.cancelled()) return absl::OkStatus();
  return Cancelled("{}: the evaluation was stopped", benchmark.name);
}

absl::StatusOr<std::vector<PredictionTask>> MakeTasks(const Benchmark& benchmark,
                                                      const std::string& work_dir,
                                                      const EvaluateOptions& options) {
  std::vector<PredictionTask> tasks;
  std::error_code error;
  for (const BenchmarkPair& pair : benchmark.pairs) {
    RETURN_IF_ERROR(CheckGoesOn(benchmark, options));
    PredictionTask task{.name = pair.name, .output = PredictionPath(work_dir, pair.name)};
    ASSIGN_OR_RETURN(
        const PreparedPair prepared,
        PreparePair(pair, work_dir + "/" + pair.name,
                    benchmark.own ? PairCheck::kPicturesAndTruth : PairCheck::kNothing));
    task.left = prepared.left;
    task.right = prepared.right;
    for (const std::string& note : prepared.notes) options.note(note);
    fs::remove(task.output, error);  // An old prediction may be another predictor's.
    tasks.push_back(std::move(task));
    if (pair.shrink == 1 && !benchmark.own) continue;
    options.progress(benchmark.own ? "check" : "shrink", static_cast<int>(tasks.size()),
                     static_cast<int>(benchmark.pairs.size()));
  }
  return tasks;
}

absl::Status CheckAllPredicted(const Predictor& predictor,
                               const std::vector<PredictionTask>& tasks) {
  std::error_code error;
  const auto missing = [&](const PredictionTask& task) { return !fs::exists(task.output, error); };
  const auto first = std::find_if(tasks.begin(), tasks.end(), missing);
  if (first == tasks.end()) return absl::OkStatus();
  const auto count = std::count_if(tasks.begin(), tasks.end(), missing);
  return NotFound("{}: left no prediction of pair {} ({}){}", predictor.name(), first->name,
                  first->output, count > 1 ? fmt::format(" and {} more", count - 1) : "");
}

Tallies TallyGroup(const ImageF& predicted_px, const ImageF& truth_px, const LabelMap& map) {
  std::map<uint16_t, ErrorTally> by_label;
  for (size_t i = 0; i < truth_px.pixels(); ++i) {
    const uint16_t label = map.labels.values()[i];
    if (label == 0 || !(truth_px.values()[i] > 0)) continue;
    by_label[label].Add(predicted_px.values()[i], truth_px.values()[i], truth_px.width());
  }
  Tallies tallies;
  for (const auto& [label, tally] : by_label) {
    const auto name = map.names.find(label);
    tallies[name == map.names.end() ? "unnamed" : name->second] += tally;
  }
  return tallies;
}

absl::StatusOr<std::vector<Scores>> ScoreAll(const Benchmark& benchmark,
                                             const std::vector<PredictionTask>& tasks,
                                             const EvaluateOptions& options) {
  std::vector<Scores> images;
  for (size_t i = 0; i < tasks.size(); ++i) {
    RETURN_IF_ERROR(CheckGoesOn(benchmark, options));
    const BenchmarkPair& pair = benchmark.pairs[i];
    ASSIGN_OR_RETURN(const PairTruth truth, pair.read_truth());
    ASSIGN_OR_RETURN(const ImageF predicted_px, ReadPfm(tasks[i].output));
    ASSIGN_OR_RETURN(Scores scores, ScorePair(pair.name, predicted_px, truth));
    scores.pair_group = pair.group;
    if (scores.regions["all"].pixels == 0) {
      return DataLoss("{}: pair {} has no pixel with truth", benchmark.name, pair.name);
    }
    images.push_back(std::move(scores));
    options.progress("score", static_cast<int>(i + 1), static_cast<int>(tasks.size()));
  }
  return images;
}

}  // namespace

std::string PredictionPath(const std::string& work_dir, const std::string& pair) {
  return fs::absolute(work_dir + "/" + pair + ".pfm").lexically_normal();
}

absl::StatusOr<Scores> ScorePair(const std::string& pair, const ImageF& predicted_px,
                                 const PairTruth& truth) {
  const ImageF& truth_px = truth.disparity_px;
  if (predicted_px.width() != truth_px.width() || predicted_px.height() != truth_px.height()) {
    return InvalidArgument("pair {}: a prediction of {} for truth of {}", pair,
                           SizeText(predicted_px.width(), predicted_px.height()),
                           SizeText(truth_px.width(), truth_px.height()));
  }
  Scores scores{.pair = pair, .width_px = truth_px.width(), .height_px = truth_px.height()};
  scores.regions["all"] = TallyErrors(predicted_px, truth_px, {});
  for (const auto& [name, region] : truth.regions) {
    scores.regions[name] = TallyErrors(predicted_px, truth_px, region);
  }
  for (const auto& [group, map] : truth.groups) {
    scores.groups[group] = TallyGroup(predicted_px, truth_px, map);
  }
  return scores;
}

Benchmark Thinned(Benchmark benchmark, int max_pairs) {
  const size_t all = benchmark.pairs.size(), wanted = static_cast<size_t>(std::max(max_pairs, 0));
  if (wanted == 0 || wanted >= all) return benchmark;
  std::vector<BenchmarkPair> kept;
  for (size_t i = 0; i < wanted; ++i) {
    kept.push_back(benchmark.pairs[wanted == 1 ? 0 : i * (all - 1) / (wanted - 1)]);
  }
  benchmark.pairs = std::move(kept);
  return benchmark;
}

absl::StatusOr<Evaluation> Evaluate(Predictor& predictor, const Benchmark& whole,
                                    const EvaluateOptions& options) {
  const Benchmark benchmark = Thinned(whole, options.max_pairs);
  const int total = static_cast<int>(benchmark.pairs.size());
  const std::string work_dir = fs::absolute(options.work_dir).lexically_normal();
  RETURN_IF_ERROR(MakeFolder(work_dir));
  ASSIGN_OR_RETURN(const std::vector<PredictionTask> tasks,
                   MakeTasks(benchmark, work_dir, options));

  const SteadyTime start = options.clock->Steady();
  PredictionContext context{
      .work_dir = work_dir,
      .cancel = options.cancel,
      .clock = options.clock,
      .progress = [&](int done) { options.progress("predict", done, total); }};
  RETURN_IF_ERROR(predictor.Predict(tasks, context));
  RETURN_IF_ERROR(CheckAllPredicted(predictor, tasks));

  Evaluation evaluation{.benchmark = benchmark.name,
                        .headline = benchmark.headline,
                        .figures = benchmark.figures,
                        .mimics = benchmark.mimics,
                        .pairs_published = benchmark.pairs_published,
                        .run = options.run,
                        .predictor = predictor.name()};
  evaluation.seconds = SecondsBetween(start, options.clock->Steady());
  ASSIGN_OR_RETURN(evaluation.images, ScoreAll(benchmark, tasks, options));
  std::error_code error;
  for (const PredictionTask& task : tasks) {
    if (!options.keep_predictions) fs::remove(task.output, error);
  }
  return evaluation;
}

}  // namespace parallax
