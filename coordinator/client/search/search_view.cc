#include "coordinator/client/search/search_view.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/base/names.h"
#include "coordinator/client/search/search_names.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/view/search_json.h"

namespace parallax::client {
namespace {

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

// " by log -0.12 [-0.20, -0.04]", in octaves; empty unless the verdict is by it.
std::string ByLogText(const v1::SearchScore& score) {
  if (!score.has_log_difference()) return "";
  const v1::SearchFigure& octaves = score.log_difference();
  return fmt::format(" by log {:+.2f} [{:+.2f}, {:+.2f}]", octaves.value(), octaves.low(),
                     octaves.high());
}

std::string DifferenceText(const v1::SearchScore& score) {
  const double points = score.difference().value();
  return fmt::format("{} points {} the default's [{:+.1f}, {:+.1f}]{}{}", Percent(std::abs(points)),
                     points <= 0 ? "below" : "above", score.difference().low(),
                     score.difference().high(), score.has_log_difference() ? "," : "",
                     ByLogText(score));
}

void AddTrials(const v1::SearchStatus& search, const Terminal& terminal,
               std::vector<std::string>& lines) {
  const v1::SearchSpec& spec = search.study().search();
  std::vector<Table::Column> columns = {"TRIAL"};
  const std::vector<std::string> names = ShortNames(spec);
  for (int i = 0; i < spec.space_size(); ++i) {
    columns.push_back({names[static_cast<size_t>(i)],
                       spec.space(i).choices().empty() ? Align::kRight : Align::kLeft});
  }
  columns.insert(columns.end(), {Right("RUNG"), Right("ERROR %"), Right("FROM DEFAULT"), "VERDICT",
                                 Right("CORE-S/PAIR"), "ENDED"});
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
                    is_default ? ""
                               : terminal.Paint(ToneOf(score->verdict()), score->verdict()) +
                                     ByLogText(*score),
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
  Table table({"SETTING", Right("SHARE"), "95 %"});
  for (const v1::SearchImportance& one : search.importances()) {
    const auto percent = [](double share) { return fmt::format("{:.0f} %", 100 * share); };
    const v1::SearchFigure& share = one.share();
    const std::string range = percent(share.low()) + " to " + percent(share.high());
    // Where chance may explain all that a setting does, the range says little.
    table.AddRow({one.path(), IsSignificant(one) ? percent(share.value()) : "-",
                  IsSignificant(one)   ? range
                  : share.high() < 0.9 ? "not significant, at most " + percent(share.high())
                                       : "not significant"});
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
    lines.push_back("Best: the default; no trial is better");
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

}  // namespace

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
  Table table(
      {"SEARCH", "STATE", Right("RUNG"), Right("CORE-HOURS"), Right("BEST"), "OUTCOME", "NEEDS"});
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

}  // namespace parallax::client
