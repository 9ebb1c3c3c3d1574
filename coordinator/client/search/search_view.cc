#include "coordinator/client/search/search_view.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "common/base/names.h"
#include "common/config/config.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/search/rung_study.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

const v1::SearchScore* LastScore(const v1::SearchTrial& trial) {
  return trial.scores().empty() ? nullptr : &trial.scores(trial.scores_size() - 1);
}

std::string Percent(double value) { return fmt::format("{:.1f}", value); }

// "12.3 [11.0, 13.9]"; without the interval if there is none.
std::string FigureText(const v1::SearchFigure& figure, bool is_difference = false) {
  const auto text = [&](double value) {
    return is_difference ? fmt::format("{:+.1f}", value) : Percent(value);
  };
  if (figure.low() == figure.high()) return text(figure.value());
  return fmt::format("{} [{}, {}]", text(figure.value()), text(figure.low()), text(figure.high()));
}

Tone ToneOf(const std::string& verdict) {
  return verdict == "better" ? Tone::kGood : verdict == "worse" ? Tone::kBad : Tone::kPlain;
}

// "floating.count 12, materials.mode none"
std::string RecipeText(const v1::SearchTrial& trial, const v1::SearchSpec& search) {
  std::vector<std::string> words;
  for (const v1::SearchField& field : search.space()) {
    const std::string value = ValueText(trial, field);
    if (!value.empty()) words.push_back(field.path() + " " + value);
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string DifferenceText(const v1::SearchScore& score) {
  const double points = score.difference().value();
  return fmt::format("{} points {} the default's [{:+.1f}, {:+.1f}]", Percent(std::abs(points)),
                     points <= 0 ? "below" : "above", score.difference().low(),
                     score.difference().high());
}

void AddTrials(const v1::SearchStatus& search, const Terminal& terminal,
               std::vector<std::string>& lines) {
  const v1::SearchSpec& spec = search.study().search();
  std::vector<Table::Column> columns = {{"TRIAL"}};
  const std::vector<std::string> names = ShortNames(spec);
  for (int i = 0; i < spec.space_size(); ++i) {
    columns.push_back({names[static_cast<size_t>(i)],
                       spec.space(i).choices().empty() ? Align::kRight : Align::kLeft});
  }
  columns.insert(columns.end(), {{"RUNG", Align::kRight},
                                 {"ERROR %", Align::kRight},
                                 {"FROM DEFAULT", Align::kRight},
                                 {"VERDICT"},
                                 {"CORE-S/PAIR", Align::kRight},
                                 {"ENDED"}});
  Table table(std::move(columns));
  for (const v1::SearchTrial* trial : InOrder(search)) {
    std::vector<std::string> cells = {trial->number() == 0 ? "default"
                                                           : fmt::format("{}", trial->number())};
    for (const v1::SearchField& field : spec.space()) {
      const std::string value =
          trial->number() == 0 ? DefaultText(search, field.path()) : ValueText(*trial, field);
      cells.push_back(value.empty() ? "-" : value);
    }
    const v1::SearchScore* const score = LastScore(*trial);
    if (score == nullptr) {
      cells.insert(cells.end(), {"-", "-", "-", "", "-", trial->ended()});
    } else {
      const bool is_default = trial->number() == 0;
      cells.insert(cells.end(),
                   {fmt::format("{}", score->rung() + 1), FigureText(score->objective()),
                    is_default ? "-" : FigureText(score->difference(), true),
                    is_default ? "" : terminal.Paint(ToneOf(score->verdict()), score->verdict()),
                    FormatNumber(score->core_s_per_pair()), trial->ended()});
    }
    table.AddRow(std::move(cells));
  }
  for (std::string row : table.Lines(terminal, 2)) {
    row.resize(row.find_last_not_of(' ') + 1);
    lines.push_back(std::move(row));
  }
}

void AddImportances(const v1::SearchStatus& search, const Terminal& terminal,
                    std::vector<std::string>& lines) {
  if (search.importances().empty()) return;
  lines.push_back("Settings, by the share of the error's variance that they explain:");
  Table table({{"SETTING"}, {"SHARE", Align::kRight}, {"95 %"}});
  for (const v1::SearchImportance& one : search.importances()) {
    const auto percent = [](double share) { return fmt::format("{:.0f} %", 100 * share); };
    table.AddRow({one.path(), percent(one.share().value()),
                  percent(one.share().low()) + " to " + percent(one.share().high())});
  }
  const std::vector<std::string> rows = table.Lines(terminal, 2);
  lines.insert(lines.end(), rows.begin(), rows.end());
}

const v1::SearchTrial* BestTrial(const v1::SearchStatus& search) {
  for (const v1::SearchTrial& trial : search.trials()) {
    if (search.has_best() && trial.number() == search.best()) return &trial;
  }
  return nullptr;
}

void AddBest(const v1::SearchStatus& search, const Terminal& terminal,
             std::vector<std::string>& lines) {
  const v1::SearchTrial* const best = BestTrial(search);
  if (best == nullptr || best->scores().empty()) return;
  if (best->number() == 0) {
    lines.push_back("Best: the default; no trial's error is less");
  } else {
    lines.push_back(fmt::format("Best: trial {}: {}", best->number(),
                                RecipeText(*best, search.study().search())));
    lines.push_back("  its error is " + DifferenceText(*LastScore(*best)));
  }
  if (search.outcome().empty()) return;
  const std::string on = fmt::format("{}", fmt::join(ConfirmedBenchmarks(search.study()), ", "));
  const bool is_confirmed = search.outcome() == "confirmed";
  std::string line = terminal.Paint(is_confirmed ? Tone::kGood : Tone::kWarning,
                                    is_confirmed ? "Confirmed" : "Not confirmed");
  if (search.has_confirmation()) {
    line += " with fresh scenes and trainings on " + on + ": its error is " +
            DifferenceText(search.confirmation());
  }
  lines.push_back(line);
}

Json FigureJson(const v1::SearchFigure& figure) {
  return {{"value", figure.value()}, {"low", figure.low()}, {"high", figure.high()}};
}

Json ScoreJson(const v1::SearchScore& score) {
  return {{"rung", score.rung()},
          {"objective", FigureJson(score.objective())},
          {"difference", FigureJson(score.difference())},
          {"verdict", score.verdict()},
          {"core_s_per_pair", score.core_s_per_pair()}};
}

}  // namespace

namespace {

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

std::string ValueText(const v1::SearchTrial& trial, const v1::SearchField& field) {
  for (const v1::SearchValue& value : trial.values()) {
    if (value.path() != field.path()) continue;
    const bool is_real = field.choices().empty() && !field.integer();
    return is_real ? FormatNumber(std::strtod(value.yaml().c_str(), nullptr)) : value.yaml();
  }
  return "";
}

std::vector<std::string> ShortNames(const v1::SearchSpec& search) {
  std::vector<std::string> names;
  for (const v1::SearchField& field : search.space()) {
    const std::string& path = field.path();
    size_t begin = path.rfind('.');
    const auto is_another = [&](const std::string& suffix) {
      return std::any_of(search.space().begin(), search.space().end(),
                         [&](const v1::SearchField& other) {
                           return other.path() != path && ("." + other.path()).ends_with(suffix);
                         });
    };
    while (begin != std::string::npos && is_another(path.substr(begin))) {
      begin = begin == 0 ? std::string::npos : path.rfind('.', begin - 1);
    }
    names.push_back(begin == std::string::npos ? path : path.substr(begin + 1));
  }
  return names;
}

std::vector<const v1::SearchTrial*> InOrder(const v1::SearchStatus& search) {
  std::vector<const v1::SearchTrial*> order;
  for (const v1::SearchTrial& trial : search.trials()) order.push_back(&trial);
  const auto key = [](const v1::SearchTrial* trial) {
    const v1::SearchScore* const score = LastScore(*trial);
    return std::tuple(trial->number() != 0, -trial->scores_size(),
                      score == nullptr ? 0 : score->objective().value());
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return key(a) < key(b); });
  return order;
}

std::string SearchProgress(const v1::SearchStatus& search) {
  int64_t left = 0;
  for (const v1::SearchTrial& trial : search.trials()) {
    left += trial.number() != 0 && trial.ended().empty() ? 1 : 0;
  }
  std::string text = search.state();
  if (search.state() == "running" || search.state() == "failed") {
    text += fmt::format(", rung {} of {}", search.rung() + 1, search.rungs());
    if (left > 0) {
      text += fmt::format(" with {} of {}", left, Plural(search.trials_size() - 1, "trial"));
    }
  }
  return text + ", " + FormatNumber(search.core_hours()) + " core-hours";
}

std::vector<std::string> SearchLines(const v1::SearchStatus& search, const Terminal& terminal) {
  std::vector<std::string> lines = {terminal.Paint(Tone::kBold, search.name()) + ": " +
                                    SearchProgress(search)};
  if (!search.waits_for().empty()) lines.push_back("  " + search.waits_for());
  const bool is_scored =
      std::any_of(search.trials().begin(), search.trials().end(),
                  [](const v1::SearchTrial& trial) { return !trial.scores().empty(); });
  if (!is_scored) {
    lines.push_back(fmt::format(
        "  no trial has a score yet{}",
        search.studies().empty() || !search.needs().empty()
            ? ""
            : fmt::format("; `parallax watch {}` shows the work of rung {}",
                          search.studies(search.studies_size() - 1), search.rung() + 1)));
  }
  if (!search.trials().empty()) AddTrials(search, terminal, lines);
  AddImportances(search, terminal, lines);
  AddBest(search, terminal, lines);
  return lines;
}

namespace {
constexpr size_t kShownOfNeeds = 80;  // `parallax search NAME` shows all of it.
}  // namespace

void PrintSearches(const v1::ListSearchesReply& reply, const Terminal& out) {
  if (reply.searches().empty()) {
    *out.stream << "no search was begun; `parallax search FILE` begins one\n";
    return;
  }
  Table table({{"SEARCH"},
               {"STATE"},
               {"RUNG", Align::kRight},
               {"CORE-HOURS", Align::kRight},
               {"BEST", Align::kRight},
               {"OUTCOME"},
               {"NEEDS"}});
  for (const v1::SearchStatus& search : reply.searches()) {
    table.AddRow({search.name(), search.state(),
                  fmt::format("{}/{}", search.rung() + 1, search.rungs()),
                  FormatNumber(search.core_hours()),
                  !search.has_best()   ? "-"
                  : search.best() == 0 ? "default"
                                       : fmt::format("trial {}", search.best()),
                  search.outcome(), CutText(FirstLine(search.needs()), kShownOfNeeds)});
  }
  table.Print(out);
}

Json SearchJson(const v1::SearchStatus& search) {
  Json json = {{"name", search.name()},
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
               {"studies", search.studies()},
               {"trials", Json::array()},
               {"importances", Json::array()}};
  if (search.has_best()) json["best"] = search.best();
  if (search.has_confirmation()) json["confirmation"] = ScoreJson(search.confirmation());
  for (const v1::SearchTrial& trial : search.trials()) {
    Json one = {{"number", trial.number()},
                {"values", Json::object()},
                {"scores", Json::array()},
                {"ended", trial.ended()}};
    for (const v1::SearchValue& value : trial.values()) one["values"][value.path()] = value.yaml();
    for (const v1::SearchScore& score : trial.scores()) one["scores"].push_back(ScoreJson(score));
    json["trials"].push_back(std::move(one));
  }
  for (const v1::SearchImportance& one : search.importances()) {
    json["importances"].push_back({{"path", one.path()}, {"share", FigureJson(one.share())}});
  }
  return json;
}

}  // namespace parallax::client
