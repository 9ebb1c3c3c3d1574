#include "coordinator/view/search_json.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/config/config.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/view/json_list.h"

namespace parallax {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson FigureJson(const v1::SearchFigure& figure) {
  return {{"value", figure.value()}, {"low", figure.low()}, {"high", figure.high()}};
}

OrderedJson ScoreJson(const v1::SearchScore& score) {
  OrderedJson json = {{"rung", score.rung()},
                      {"objective", FigureJson(score.objective())},
                      {"difference", FigureJson(score.difference())},
                      {"log_difference", nullptr},
                      {"verdict", score.verdict()},
                      {"core_s_per_pair", score.core_s_per_pair()}};
  if (score.has_log_difference()) json["log_difference"] = FigureJson(score.log_difference());
  return json;
}

OrderedJson FieldJson(const v1::SearchStatus& search, const v1::SearchField& field) {
  OrderedJson json = {{"path", field.path()}, {"default", DefaultText(search, field.path())}};
  if (field.choices().empty()) {
    json.update({{"low", field.low()}, {"high", field.high()}, {"log", field.log()}});
  } else {
    json["choices"] = field.choices();
  }
  return json;
}

// "{uniform: [0.5, 1]}" as "0.5..1"; other texts as they are.
std::string ShortRange(const std::string& text) {
  for (const char* kind : {"{uniform: [", "{uniform_int: ["}) {
    if (!text.starts_with(kind)) continue;
    std::string range = text.substr(std::string_view(kind).size());
    range.resize(range.find(']'));
    return range.replace(range.find(", "), 2, "..");
  }
  return text;
}

}  // namespace

const v1::SearchScore* LastScore(const v1::SearchTrial& trial) {
  return trial.scores().empty() ? nullptr : &trial.scores(trial.scores_size() - 1);
}

std::map<std::string, int> TrialStates(const v1::SearchStatus& search) {
  std::map<std::string, int> states = {{"dropped", 0}, {"failed", 0}, {"open", 0}};
  for (const v1::SearchTrial& trial : search.trials()) {
    if (trial.number() == 0) continue;
    // A trial that failed has no score of the rung on which it ended.
    const bool has_failed =
        trial.ended().starts_with(fmt::format("rung {}:", trial.scores_size() + 1));
    ++states[trial.ended().empty() ? "open" : has_failed ? "failed" : "dropped"];
  }
  return states;
}

bool IsSignificant(const v1::SearchImportance& importance) { return importance.share().low() > 0; }

std::string DefaultText(const v1::SearchStatus& search, const std::string& path) {
  if (search.study().variants().empty()) return "-";
  std::istringstream text(MessageToYaml(DefaultOf(search.study()).config()));
  // Goes down the groups of the text: each is a key with more indent than the one around it.
  std::string wanted = path, indent;
  for (std::string line; std::getline(text, line);) {
    const size_t end = std::min(wanted.find('.'), wanted.size());
    if (!line.starts_with(indent + wanted.substr(0, end) + ":")) continue;
    if (end < wanted.size()) {
      wanted.erase(0, end + 1);
      indent += "  ";
      continue;
    }
    const size_t value = indent.size() + end + 2;
    return value < line.size() ? ShortRange(line.substr(value)) : "-";
  }
  return "-";
}

OrderedJson SearchLineJson(const v1::SearchStatus& search) {
  OrderedJson json = {{"name", search.name()},
                      {"user", search.user()},
                      {"state", search.state()},
                      {"opened_unix_s", search.opened_unix_s()},
                      {"rung", search.rung()},
                      {"rungs", search.rungs()},
                      {"core_hours", search.core_hours()},
                      {"needs", search.needs()},
                      {"waits_for", search.waits_for()},
                      {"best", nullptr},
                      {"outcome", search.outcome()},
                      {"confirmation", nullptr},
                      {"studies", search.studies()}};
  if (search.has_best()) json["best"] = search.best();
  if (search.has_confirmation()) json["confirmation"] = ScoreJson(search.confirmation());
  if (!search.has_study()) return json;
  const double most = search.study().search().core_hours();
  json["core_hours_most"] = most > 0 ? OrderedJson(most) : OrderedJson(nullptr);
  json["trial_states"] = TrialStates(search);
  json["best_score"] = nullptr;
  for (const v1::SearchTrial& trial : search.trials()) {
    if (!search.has_best() || trial.number() != search.best() || trial.scores().empty()) continue;
    json["best_score"] = ScoreJson(*LastScore(trial));
  }
  return json;
}

OrderedJson SearchJson(const v1::SearchStatus& search) {
  OrderedJson json = SearchLineJson(search);
  const auto field_json = [&](const v1::SearchField& field) { return FieldJson(search, field); };
  json["space"] = JsonList(search.study().search().space(), field_json);
  json["trials"] = OrderedJson::array();
  json["importances"] = OrderedJson::array();
  for (const v1::SearchTrial& trial : search.trials()) {
    OrderedJson one = {{"number", trial.number()},
                       {"values", OrderedJson::object()},
                       {"scores", JsonList(trial.scores(), ScoreJson)},
                       {"ended", trial.ended()}};
    for (const v1::SearchValue& value : trial.values()) one["values"][value.path()] = value.yaml();
    json["trials"].push_back(std::move(one));
  }
  for (const v1::SearchImportance& one : search.importances()) {
    json["importances"].push_back({{"path", one.path()},
                                   {"share", FigureJson(one.share())},
                                   {"significant", IsSignificant(one)}});
  }
  return json;
}

}  // namespace parallax
