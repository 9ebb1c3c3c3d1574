#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "coordinator/http/api_json.h"

namespace parallax {
namespace {

// One row of the table: a training set, or a baseline, on a benchmark.
using RowKey = std::tuple<std::string, std::string, std::string>;  // Benchmark, set, predictor.

RowKey KeyOf(const JobKind::Score& score) { return {score.benchmark, score.set, score.predictor}; }

struct Spread {
  double mean = 0, deviation = 0;  // The sample's; 0 for one value.
};

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  if (values.size() < 2) return spread;
  double sum = 0;
  for (const double value : values) sum += (value - spread.mean) * (value - spread.mean);
  spread.deviation = std::sqrt(sum / static_cast<double>(values.size() - 1));
  return spread;
}

Json RowJson(const RowKey& key, const std::vector<const StudyScore*>& of_row) {
  std::vector<double> values;
  Json seeds = Json::array();
  for (const StudyScore* one : of_row) {
    values.push_back(one->score.value);
    seeds.push_back({{"seed", one->score.seed ? Json(std::to_string(*one->score.seed)) : Json()},
                     {"value", one->score.value},
                     {"job", one->job_id}});
  }
  const Spread spread = SpreadOf(values);
  return {{"benchmark", std::get<0>(key)},        {"set", std::get<1>(key)},
          {"predictor", std::get<2>(key)},        {"metric", of_row.front()->score.metric},
          {"pairs", of_row.front()->score.pairs}, {"mean", spread.mean},
          {"deviation", spread.deviation},        {"seeds", seeds}};
}

Json CurvesJson(const std::vector<StudyScore>& scores) {
  std::map<RowKey, std::map<double, std::vector<double>>> curves;  // By share of the training.
  for (const StudyScore& one : scores) {
    if (one.score.checkpoints < 2) continue;
    const double share =
        static_cast<double>(one.score.checkpoint) / static_cast<double>(one.score.checkpoints);
    curves[KeyOf(one.score)][share].push_back(one.score.value);
  }
  Json json = Json::array();
  for (const auto& [key, points] : curves) {
    Json line = {{"benchmark", std::get<0>(key)},
                 {"set", std::get<1>(key)},
                 {"predictor", std::get<2>(key)},
                 {"points", Json::array()}};
    for (const auto& [share, values] : points) {
      line["points"].push_back({{"share", share}, {"value", SpreadOf(values).mean}});
    }
    json.push_back(std::move(line));
  }
  return json;
}

}  // namespace

Json ScoresJson(const std::vector<StudyScore>& scores) {
  std::map<RowKey, std::vector<const StudyScore*>> rows;
  for (const StudyScore& one : scores) {
    if (one.score.checkpoint == one.score.checkpoints) rows[KeyOf(one.score)].push_back(&one);
  }
  std::vector<Json> sorted;
  for (const auto& [key, of_row] : rows) sorted.push_back(RowJson(key, of_row));
  std::stable_sort(sorted.begin(), sorted.end(), [](const Json& a, const Json& b) {
    return std::pair(a["benchmark"].get<std::string>(), a["mean"].get<double>()) <
           std::pair(b["benchmark"].get<std::string>(), b["mean"].get<double>());
  });
  return {{"rows", sorted}, {"curves", CurvesJson(scores)}};
}

}  // namespace parallax
