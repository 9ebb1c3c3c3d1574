#include "coordinator/search/sampler_talk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/names.h"
#include "common/config/search/search_values.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/study/keys.h"

namespace parallax {
namespace {

using SamplerJson = nlohmann::ordered_json;

constexpr int kMostDepth = 8;       // An answer has no more levels: writing each takes stack.
constexpr size_t kMostShown = 100;  // Bytes of a value in an error.

std::string Shown(const SamplerJson& json) { return Printable(json.dump().substr(0, kMostShown)); }

SamplerJson SpaceJson(const SearchSpace& space) {
  SamplerJson json = SamplerJson::array();
  for (const v1::SearchField& field : space) {
    SamplerJson one = {{"path", field.path()}};
    if (field.choices().empty()) {
      one["low"] = field.low();
      one["high"] = field.high();
      one["log"] = field.log();
      one["integer"] = field.integer();
    } else {
      one["choices"] = std::vector<std::string>(field.choices().begin(), field.choices().end());
    }
    for (const v1::SearchCondition& condition : field.when()) {
      one["when"].push_back({{"path", condition.path()},
                             {"values", std::vector<std::string>(condition.values().begin(),
                                                                 condition.values().end())}});
    }
    json.push_back(std::move(one));
  }
  return json;
}

SamplerJson ValuesJson(const SearchSpace& space, const SearchValues& values) {
  SamplerJson json = SamplerJson::object();
  for (const v1::SearchField& field : space) {
    const std::string* value = ValueOf(values, field.path());
    if (value == nullptr) continue;
    if (field.choices().empty()) {
      json[field.path()] = std::strtod(value->c_str(), nullptr);
    } else {
      json[field.path()] = *value;
    }
  }
  return json;
}

// Returns the text of a value of the field.
absl::StatusOr<std::string> ValueText(const v1::SearchField& field, const SamplerJson& json) {
  if (field.choices().empty()) {
    const double value = json.is_number() ? json.get<double>() : std::nan("");
    const bool fits = value >= field.low() && value <= field.high() &&
                      (!field.integer() || value == std::floor(value));
    if (fits) return SearchNumberText(field, value);
    return InvalidArgument("{} is {}, allowed is {} in [{}, {}]", field.path(), Shown(json),
                           field.integer() ? "a whole number" : "a number", field.low(),
                           field.high());
  }
  const std::string text = json.is_string() ? json.get<std::string>() : json.dump();
  if (std::count(field.choices().begin(), field.choices().end(), text) > 0) return text;
  return InvalidArgument("{} is {}, allowed are: {}", field.path(), Shown(json),
                         fmt::join(field.choices(), ", "));
}

absl::StatusOr<SearchValues> ValuesFrom(const SearchSpace& space, const SamplerJson& json) {
  if (!json.is_object()) return InvalidArgument("is {}, wanted {{PATH: VALUE}}", Shown(json));
  for (const auto& entry : json.items()) {
    const auto is_named = [&](const v1::SearchField& field) { return field.path() == entry.key(); };
    if (std::any_of(space.begin(), space.end(), is_named)) continue;
    return InvalidArgument("{} is no field of the space", Quoted(entry.key()));
  }
  SearchValues values;
  for (const v1::SearchField& field : space) {
    if (!IsVaried(field, values)) continue;
    if (!json.contains(field.path())) return InvalidArgument("{} is missing", field.path());
    v1::SearchValue& value = *values.Add();
    value.set_path(field.path());
    ASSIGN_OR_RETURN(*value.mutable_yaml(), ValueText(field, json[field.path()]));
  }
  return values;
}

}  // namespace

std::string AskText(const v1::SearchRecord& record, const std::vector<TrialScore>& scores,
                    const std::map<std::string, std::string>& failed, int count) {
  const SearchSpace& space = record.study().search().space();
  SamplerJson ask = {{"schema", "parallax-sampler-1"},
                     {"seed", record.study().seed() % (1u << 31)},
                     {"count", count},
                     {"space", SpaceJson(space)},
                     {"history", SamplerJson::array()}};
  for (const v1::SearchTrial& trial : record.trials()) {
    if (trial.number() == 0) continue;
    SamplerJson one = {{"number", trial.number()}, {"values", ValuesJson(space, trial.values())}};
    const std::string name = TrialName(trial.number());
    const auto why = failed.find(name);
    if (why != failed.end()) one["failed"] = why->second;
    for (const TrialScore& score : scores) {
      if (score.variant != name) continue;
      one["objective"] = score.objective.value();
      one["low"] = score.objective.low();
      one["high"] = score.objective.high();
      one["difference"] = score.difference.value();
    }
    ask["history"].push_back(std::move(one));
  }
  // Errors of jobs may hold any bytes.
  return ask.dump(1, ' ', false, SamplerJson::error_handler_t::replace) + "\n";
}

absl::StatusOr<std::vector<v1::SearchTrial>> AnsweredTrials(const v1::SearchRecord& record,
                                                            const std::string& answer, int count) {
  const v1::StudySpec& search = record.study();
  bool too_deep = false;
  const auto within_depth = [&](int depth, SamplerJson::parse_event_t, SamplerJson&) {
    too_deep = too_deep || depth > kMostDepth;
    return !too_deep;
  };
  const SamplerJson json = SamplerJson::parse(answer, within_depth, /*allow_exceptions=*/false);
  if (too_deep) {
    return InvalidArgument("the answer is nested more than {} levels deep", kMostDepth);
  }
  if (!json.is_object() || !json.contains("trials") || !json["trials"].is_array()) {
    return InvalidArgument("the answer is not {{\"trials\": [...]}}");
  }
  const v1::SceneConfig& base = DefaultOf(search).config();
  std::set<std::string> configs;
  for (const v1::SearchTrial& trial : record.trials()) {
    ASSIGN_OR_RETURN(const v1::SceneConfig config, WithSearchValues(base, trial.values()));
    configs.insert(DeterministicBytes(config));
  }
  std::vector<v1::SearchTrial> trials;
  for (size_t i = 0; i < json["trials"].size(); ++i) {
    if (static_cast<int>(trials.size()) == count) break;
    const std::string where = fmt::format("trial {} of the answer", i + 1);
    v1::SearchTrial trial;
    trial.set_number(record.trials_size() + static_cast<int>(trials.size()));
    absl::StatusOr<SearchValues> values = ValuesFrom(search.search().space(), json["trials"][i]);
    RETURN_IF_ERROR(WithContext(values.status(), where));
    *trial.mutable_values() = *std::move(values);
    RETURN_IF_ERROR(WithContext(CheckTrial(search, trial), where));
    ASSIGN_OR_RETURN(const v1::SceneConfig config, WithSearchValues(base, trial.values()));
    if (configs.insert(DeterministicBytes(config)).second) trials.push_back(std::move(trial));
  }
  return trials;
}

}  // namespace parallax
