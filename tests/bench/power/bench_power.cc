// How small a difference a way of training and scoring tells for its core-hours, from a pilot run
// of it. Prints one JSON line: for each measure the variances between seeds, between units of
// pictures and of what is left, the seeds that the core-hours buy, and the least difference that is
// significant with them in 80 of 100 repetitions. Measures have different units: `told` is the
// median over the known differences of the pilot (the ladder of ladder.yaml) of difference over
// least difference, and compares measures and ways of training.
//
//   bench_power out/ladder --benchmark real --rows 13 --core-hours 16 --made-core-hours 1
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "tests/bench/program_main.h"
#include "worker/evaluate/score_table.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string dir, benchmark = "real";
  int rows = 13;
  double core_hours = 16, made_core_hours = 0;
  // Time of one training and its scores; 0: train.json and the scores have it.
  double seed_core_s = 0;
  TableOptions table;
};

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The core-seconds of the trainings below `dir`, by their cards.
std::vector<double> TrainingSeconds(const std::string& dir) {
  std::vector<double> all;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(dir, error)) {
    if (entry.path().filename() != "train.json") continue;
    const Json card = Json::parse(ReadFile(entry.path()).value_or(""), nullptr, false);
    if (!card.is_object() || !card.contains("result")) continue;
    all.push_back(card["result"].value("wall_s", 0.0) * card["settings"].value("threads", 1));
  }
  return all;
}

struct Costs {
  double train_s = 0, score_s = 0;
};

// Medians over the pilot's trainings and their scores on the benchmark. Scores say seconds of wall
// time: the pilot is one of `threads: 1`.
Costs CostsOf(const Arguments& arguments, const std::vector<Evaluation>& scores) {
  std::vector<double> score_s;
  for (const Evaluation& one : scores) {
    if (one.run.seed) score_s.push_back(one.seconds);
  }
  return {MedianOf(TrainingSeconds(arguments.dir)), MedianOf(score_s)};
}

Json ComparisonJson(const TableComparison& one, double least) {
  const Comparison& c = one.comparison;
  return {{"variant", one.variant},
          {"difference", c.difference.value},
          {"low", c.difference.low},
          {"high", c.difference.high},
          {"verdict", VerdictName(c.verdict)},
          {"variances", {c.spread.seeds, c.spread.images, c.spread.rest}},
          {"least_difference", c.least_difference.value_or(0)},
          {"least_difference_then", least}};
}

absl::StatusOr<Json> MeasureJson(const Measure& measure, std::vector<Evaluation> scores,
                                 const Arguments& arguments, int seeds) {
  for (Evaluation& one : scores) one.headline.measure = measure;
  ASSIGN_OR_RETURN(const ResultTable table, MakeTable(scores, arguments.table));
  Json json = {{"measure", MeasureName(measure)}, {"comparisons", Json::array()}};
  std::vector<double> least, told;
  for (const TableComparison& one : table.comparisons) {
    const std::optional<double> then = LeastDifference(
        one.comparison.spread, seeds, one.comparison.images, arguments.table.bootstrap.confidence);
    if (!then || !one.of_trainings || !one.comparison.least_difference) continue;
    json["units"] = one.comparison.images;
    json["comparisons"].push_back(ComparisonJson(one, *then));
    least.push_back(*then);
    told.push_back(std::abs(one.comparison.difference.value) / *then);
  }
  json["least_difference"] = MedianOf(least);
  json["told"] = MedianOf(told);
  return json;
}

absl::Status Measured(const Arguments& arguments) {
  ASSIGN_OR_RETURN(std::vector<Evaluation> scores, ReadEvaluations(arguments.dir));
  std::erase_if(scores, [&](const Evaluation& one) {
    return one.benchmark != arguments.benchmark || !one.run.seed;
  });
  if (scores.empty()) {
    return NotFound("{}: no trained network has scores on {}", arguments.dir, arguments.benchmark);
  }
  const Costs costs = CostsOf(arguments, scores);
  const double seed_s =
      arguments.seed_core_s > 0 ? arguments.seed_core_s : costs.train_s + costs.score_s;
  if (seed_s <= 0)
    return InvalidArgument("no train.json below {}: say --seed-core-s", arguments.dir);
  const double trained_s = 3600 * (arguments.core_hours - arguments.made_core_hours);
  const int seeds = static_cast<int>(trained_s / (arguments.rows * seed_s));
  if (seeds < 2)
    return InvalidArgument("{} core-hours buy less than two seeds", arguments.core_hours);
  Json json = {{"bench", "power"},
               {"dir", arguments.dir},
               {"benchmark", arguments.benchmark},
               {"train_core_s", costs.train_s},
               {"score_core_s", costs.score_s},
               {"core_hours", arguments.core_hours},
               {"rows", arguments.rows},
               {"seeds", seeds},
               {"measures", Json::array()}};
  for (const Measure& measure : {BadAt(1), BadAt(2), BadAt(3), kEpeMeasure, kLogMeasure}) {
    ASSIGN_OR_RETURN(Json one, MeasureJson(measure, scores, arguments, seeds));
    json["measures"].push_back(std::move(one));
  }
  std::printf("%s\n", json.dump().c_str());
  return absl::OkStatus();
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  Arguments a;
  CLI::App app("The least difference that a way of training tells for its core-hours");
  app.add_option("DIR", a.dir, "A finished study, or a folder of score files")->required();
  app.add_option("--benchmark", a.benchmark)->capture_default_str();
  app.add_option("--baseline", a.table.baseline, "The variant that others are compared with");
  app.add_option("--rows", a.rows, "Training sets of the study that is planned")
      ->capture_default_str();
  app.add_option("--core-hours", a.core_hours, "What that study may cost")->capture_default_str();
  app.add_option("--made-core-hours", a.made_core_hours, "Part of these for pairs")
      ->capture_default_str();
  app.add_option("--seed-core-s", a.seed_core_s, "Of one training and its scores");
  app.add_flag("--weigh-groups", a.table.weigh_groups, "Each set of pairs counts alike");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  return Measured(a);
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_power", parallax::Run, argc, argv);
}
