#include "worker/evaluate/scores.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "common/base/system/file.h"
#include "common/store/store.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr char kSchema[] = "parallax-scores-1";

Json TallyJson(const ErrorTally& tally) {
  Json bad = Json::object();
  for (size_t i = 0; i < kThresholdsPx.size(); ++i) {
    bad[MeasureName({.threshold = i}).substr(4)] = tally.bad[i];
  }
  return {{"pixels", tally.pixels},
          {"invalid", tally.invalid},
          {"abs_error_px", tally.abs_error_px},
          {"squared_error_px2", tally.squared_error_px2},
          {"bad", std::move(bad)},
          {"d1", tally.d1}};
}

ErrorTally TallyOf(const Json& json) {
  ErrorTally tally;
  json.at("pixels").get_to(tally.pixels);
  json.at("invalid").get_to(tally.invalid);
  json.at("abs_error_px").get_to(tally.abs_error_px);
  json.at("squared_error_px2").get_to(tally.squared_error_px2);
  for (size_t i = 0; i < kThresholdsPx.size(); ++i) {
    json.at("bad").at(MeasureName({.threshold = i}).substr(4)).get_to(tally.bad[i]);
  }
  json.at("d1").get_to(tally.d1);
  return tally;
}

Json TalliesJson(const Tallies& tallies) {
  Json json = Json::object();
  for (const auto& [name, tally] : tallies) json[name] = TallyJson(tally);
  return json;
}

Tallies TalliesOf(const Json& json) {
  Tallies tallies;
  for (const auto& [name, tally] : json.items()) tallies[name] = TallyOf(tally);
  return tallies;
}

Json HeaderJson(const Evaluation& evaluation) {
  Json figures = Json::array();
  for (const Metric& metric : evaluation.figures) figures.push_back(MetricName(metric));
  const RunIdentity& run = evaluation.run;
  Json json = {{"schema", kSchema},
               {"benchmark", evaluation.benchmark},
               {"metric", MetricName(evaluation.headline)},
               {"figures", std::move(figures)},
               {"mimics", evaluation.mimics},
               {"pairs", evaluation.images.size()},
               {"pairs_published", evaluation.pairs_published},
               {"variant", run.variant},
               {"trainer", run.trainer},
               {"seed", run.seed ? Json(*run.seed) : Json()},
               {"checkpoint", run.checkpoint},
               {"predictor", evaluation.predictor},
               {"seconds", evaluation.seconds}};
  if (run.looks > 0) json["looks"] = run.looks;
  return json;
}

Json ImageJson(const Scores& scores) {
  Json json = {{"pair", scores.pair},
               {"width_px", scores.width_px},
               {"height_px", scores.height_px},
               {"regions", TalliesJson(scores.regions)}};
  if (!scores.pair_group.empty()) json["pair_group"] = scores.pair_group;
  for (const auto& [group, tallies] : scores.groups) json["groups"][group] = TalliesJson(tallies);
  return json;
}

absl::Status ReadHeader(const Json& json, Evaluation& evaluation, size_t& pairs) {
  json.at("benchmark").get_to(evaluation.benchmark);
  ASSIGN_OR_RETURN(evaluation.headline, ParseMetric(json.at("metric").get<std::string>()));
  for (const Json& name : json.at("figures")) {
    ASSIGN_OR_RETURN(const Metric metric, ParseMetric(name.get<std::string>()));
    evaluation.figures.push_back(metric);
  }
  json.at("mimics").get_to(evaluation.mimics);
  json.at("pairs").get_to(pairs);
  json.at("pairs_published").get_to(evaluation.pairs_published);
  json.at("variant").get_to(evaluation.run.variant);
  json.at("trainer").get_to(evaluation.run.trainer);
  if (!json.at("seed").is_null()) evaluation.run.seed = json.at("seed").get<int64_t>();
  json.at("checkpoint").get_to(evaluation.run.checkpoint);
  evaluation.run.looks = json.value("looks", 0);
  json.at("predictor").get_to(evaluation.predictor);
  json.at("seconds").get_to(evaluation.seconds);
  return absl::OkStatus();
}

Scores ImageOf(const Json& json) {
  Scores scores;
  json.at("pair").get_to(scores.pair);
  json.at("width_px").get_to(scores.width_px);
  json.at("height_px").get_to(scores.height_px);
  scores.regions = TalliesOf(json.at("regions"));
  if (json.contains("pair_group")) json.at("pair_group").get_to(scores.pair_group);
  if (json.contains("groups")) {
    for (const auto& [group, tallies] : json.at("groups").items()) {
      scores.groups[group] = TalliesOf(tallies);
    }
  }
  return scores;
}

absl::Status BadLine(int line, const std::string& what) {
  return DataLoss("line {}: {}", line, what);
}

bool SameScores(const Evaluation& a, const Evaluation& b) {
  return std::equal(
      a.images.begin(), a.images.end(), b.images.begin(), b.images.end(),
      [](const Scores& x, const Scores& y) { return x.pair == y.pair && x.regions == y.regions; });
}

// Whether the file's first line is the head of a score file: a folder may hold other JSON lines.
bool IsScoreFile(std::string_view text) {
  const Json head = Json::parse(text.substr(0, text.find('\n')), nullptr, false);
  return head.is_object() && head.contains("schema") && head["schema"] == kSchema;
}

std::string DescribeRun(const Evaluation& evaluation) {
  return "variant " + evaluation.run.variant + ", trainer " + evaluation.run.trainer +
         (evaluation.run.seed ? fmt::format(", seed {}", *evaluation.run.seed) : "") + " on " +
         evaluation.benchmark;
}

}  // namespace

std::string EncodeEvaluation(const Evaluation& evaluation) {
  const auto line = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  };
  std::string text = line(HeaderJson(evaluation));
  for (const Scores& scores : evaluation.images) text += line(ImageJson(scores));
  return text;
}

absl::StatusOr<Evaluation> DecodeEvaluation(std::string_view text) {
  if (!IsScoreFile(text)) return BadLine(1, fmt::format("not a score file of {}", kSchema));
  std::istringstream in{std::string(text)};
  Evaluation evaluation;
  size_t pairs = 0;
  int number = 0;
  for (std::string row; std::getline(in, row);) {
    ++number;
    try {
      const Json json = Json::parse(row);
      if (number == 1) {
        const absl::Status read = ReadHeader(json, evaluation, pairs);
        if (!read.ok()) return BadLine(number, std::string(ToStd(read.message())));
      } else {
        evaluation.images.push_back(ImageOf(json));
      }
    } catch (const Json::exception& error) {
      return BadLine(number, error.what());
    }
  }
  if (evaluation.images.size() != pairs) {
    return BadLine(
        number, fmt::format("the file ends after {} of {} pairs", evaluation.images.size(), pairs));
  }
  return evaluation;
}

absl::Status WriteEvaluation(const std::string& path, const Evaluation& evaluation) {
  return WriteFileAtomically(path, EncodeEvaluation(evaluation));
}

absl::StatusOr<Evaluation> ReadEvaluation(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  absl::StatusOr<Evaluation> evaluation = DecodeEvaluation(text);
  if (!evaluation.ok()) return WithContext(evaluation.status(), path);
  return evaluation;
}

absl::StatusOr<std::vector<Evaluation>> ReadEvaluations(const std::string& dir) {
  std::error_code error;
  if (!fs::is_directory(dir, error)) {
    return NotFound("{}: no such folder", dir);
  }
  std::vector<std::string> paths;
  for (auto entry = fs::recursive_directory_iterator(dir, error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename();
    // A dataset's frames are many folders, and hold no scores; those of checkpoints before the last
    // are in curves.
    if (name == "frames" || name == "curves" || name[0] == '.') entry.disable_recursion_pending();
    if (name.ends_with(".jsonl")) paths.push_back(entry->path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Evaluation> all;
  using Key = std::tuple<std::string, std::string, std::string, std::optional<int64_t>>;
  std::map<Key, std::pair<size_t, std::string>> seen;
  for (const std::string& path : paths) {
    ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
    const bool begun = text.starts_with("{\"schema\":\"parallax-scores");  // It may be cut.
    if (!begun && !IsScoreFile(text)) continue;
    absl::StatusOr<Evaluation> one = DecodeEvaluation(text);
    if (!one.ok()) return WithContext(one.status(), path);
    const Key key{one->benchmark, one->run.variant, one->run.trainer, one->run.seed};
    const auto [place, is_new] = seen.try_emplace(key, all.size(), path);
    if (is_new) {
      all.push_back(*std::move(one));
    } else if (!SameScores(all[place->second.first], *one)) {
      return FailedPrecondition("{} and {} hold different scores of {}", path, place->second.second,
                                DescribeRun(*one));
    }
  }
  if (all.empty()) {
    return NotFound("{}: no score file (*.jsonl of `parallax evaluate`) in it", dir);
  }
  return all;
}

double FigureOf(const Metric& metric, const Evaluation& evaluation) {
  ErrorTally pool;
  double sum = 0;
  int images = 0;
  for (const Scores& scores : evaluation.images) {
    const auto found = scores.regions.find(metric.region);
    if (found == scores.regions.end() || found->second.pixels == 0) continue;
    pool += found->second;
    sum += FigureOf(metric.measure, found->second);
    ++images;
  }
  if (metric.pooled) return FigureOf(metric.measure, pool);
  return images > 0 ? sum / images : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace parallax
