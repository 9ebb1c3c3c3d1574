#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "worker/evaluate/score_table.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

std::string Fixed(double value) { return std::isnan(value) ? "-" : fmt::format("{:.2f}", value); }

bool HasSpread(const Interval& interval) { return interval.high > interval.low; }

// "9.53 [8.10, 10.96]"
std::string FigureText(const TableFigure& figure) {
  std::string text = Fixed(figure.interval.value);
  if (HasSpread(figure.interval)) {
    text += " [" + Fixed(figure.interval.low) + ", " + Fixed(figure.interval.high) + "]";
  }
  return text;
}

const TableComparison* FindComparison(const ResultTable& table, const TableRow& row,
                                      const std::string& benchmark) {
  for (const TableComparison& one : table.comparisons) {
    if (one.variant == row.variant && one.trainer == row.trainer && one.benchmark == benchmark) {
      return &one;
    }
  }
  return nullptr;
}

// "worse by 3.10 [1.20, 5.00]", "not significant; 4 more seeds would decide", and where another
// figure decides than the one shown, "worse by 0.21 [0.10, 0.32] log all; shown +3.10".
std::string VerdictText(const TableComparison& one) {
  const Comparison& comparison = one.comparison;
  const Interval& d = comparison.difference;
  if (comparison.verdict != Verdict::kNotSignificant) {
    const double sign = d.value < 0 ? -1 : 1;
    const double near = std::min(sign * d.low, sign * d.high);
    const double far = std::max(sign * d.low, sign * d.high);
    const std::string other =
        one.decided_by == one.metric
            ? ""
            : fmt::format(" {}; shown {:+.2f}", one.decided_by, one.difference.value);
    return VerdictName(comparison.verdict) + " by " + Fixed(sign * d.value) + " [" + Fixed(near) +
           ", " + Fixed(far) + "]" + other;
  }
  std::string text = VerdictName(comparison.verdict);
  if (comparison.seeds_spread_unknown) return text + " (one seed)";
  if (comparison.more_seeds) {
    return fmt::format("{}; {} more seed{} would decide", text, *comparison.more_seeds,
                       *comparison.more_seeds == 1 ? "" : "s");
  }
  return text;
}

std::string SeedsText(int seeds) { return seeds == 0 ? "-" : std::to_string(seeds); }

// A grid of cells whose first row is the heading.
using Grid = std::vector<std::vector<std::string>>;

std::vector<size_t> Widths(const Grid& grid) {
  std::vector<size_t> widths;
  for (const auto& row : grid) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  return widths;
}

std::string Aligned(const Grid& grid) {
  const std::vector<size_t> widths = Widths(grid);
  std::string text;
  for (const auto& row : grid) {
    std::string line = "  ";
    for (size_t c = 0; c < row.size(); ++c) {
      line += row[c] + std::string(widths[c] - row[c].size() + 2, ' ');
    }
    while (line.back() == ' ') line.pop_back();
    text += line + "\n";
  }
  return text;
}

// One benchmark: rows by variant, columns by figure.
Grid BenchmarkGrid(const ResultTable& table, const std::string& benchmark) {
  Grid grid = {{"variant", "trainer", "seeds"}};
  for (const TableRow& row : table.rows) {
    const auto cell = row.cells.find(benchmark);
    if (cell == row.cells.end()) continue;
    if (grid[0].size() == 3) {
      grid[0].push_back(cell->second.headline.metric);
      for (const TableFigure& figure : cell->second.others) grid[0].push_back(figure.metric);
      grid[0].push_back("against the baseline");
    }
    std::vector<std::string> line = {row.variant, row.trainer, SeedsText(cell->second.seeds),
                                     FigureText(cell->second.headline)};
    for (const TableFigure& figure : cell->second.others) line.push_back(FigureText(figure));
    const TableComparison* comparison = FindComparison(table, row, benchmark);
    line.push_back(comparison == nullptr ? "" : VerdictText(*comparison));
    grid.push_back(std::move(line));
  }
  return grid;
}

const TableCell& AnyCell(const ResultTable& table, const std::string& benchmark) {
  for (const TableRow& row : table.rows) {
    if (const auto cell = row.cells.find(benchmark); cell != row.cells.end()) return cell->second;
  }
  static const TableCell none;
  return none;
}

// The headline of each set of pairs, rows by variant; empty for more sets than columns are
// readable.
Grid GroupsGrid(const ResultTable& table, const std::string& benchmark) {
  constexpr size_t kMostColumns = 12;
  const TableCell& any = AnyCell(table, benchmark);
  if (any.groups.empty() || any.groups.size() > kMostColumns) return {};
  Grid grid = {{any.headline.metric + " by set (pairs)", "trainer"}};
  for (const auto& [group, figures] : any.groups) {
    grid[0].push_back(fmt::format("{} ({})", group, figures.headline.pairs));
  }
  for (const TableRow& row : table.rows) {
    const auto cell = row.cells.find(benchmark);
    if (cell == row.cells.end()) continue;
    std::vector<std::string>& line = grid.emplace_back();
    line = {row.variant, row.trainer};
    for (const auto& [group, figures] : cell->second.groups) {
      line.push_back(Fixed(figures.headline.interval.value));
    }
  }
  return grid;
}

std::string Pairs(const TableCell& cell) {
  return fmt::format("{}{}", cell.headline.pairs, cell.headline.pairs == 1 ? " pair" : " pairs");
}

std::string Text(const ResultTable& table) {
  std::string text;
  for (const std::string& benchmark : table.benchmarks) {
    const TableCell& any = AnyCell(table, benchmark);
    text += benchmark + " (" + Pairs(any) + "; as " + any.mimics + ")\n" +
            Aligned(BenchmarkGrid(table, benchmark)) + "\n";
    const Grid groups = GroupsGrid(table, benchmark);
    if (!groups.empty()) text += Aligned(groups) + "\n";
  }
  text +=
      "Lower is better; bad-t and d1 in percent, epe in pixels, log in octaves; [95 % interval].\n";
  for (const std::string& note : table.notes) text += "note: " + note + "\n";
  return text;
}

// All benchmarks beside each other: the headline of each.
Grid WideGrid(const ResultTable& table, const char* better, const char* worse) {
  Grid grid = {{"variant", "trainer", "seeds"}};
  for (const std::string& benchmark : table.benchmarks) {
    grid[0].push_back(benchmark + " " + AnyCell(table, benchmark).headline.metric);
  }
  for (const TableRow& row : table.rows) {
    std::vector<std::string> line = {row.variant, row.trainer, SeedsText(row.seeds)};
    for (const std::string& benchmark : table.benchmarks) {
      const auto cell = row.cells.find(benchmark);
      std::string text = cell == row.cells.end() ? "" : FigureText(cell->second.headline);
      if (const TableComparison* one = FindComparison(table, row, benchmark)) {
        if (one->comparison.verdict == Verdict::kBetter) text += better;
        if (one->comparison.verdict == Verdict::kWorse) text += worse;
      }
      line.push_back(std::move(text));
    }
    grid.push_back(std::move(line));
  }
  return grid;
}

std::string MarkdownGrid(const Grid& grid) {
  std::string text;
  for (size_t r = 0; r < grid.size(); ++r) {
    text += "|";
    for (const std::string& cell : grid[r]) text += " " + cell + " |";
    text += "\n";
    if (r > 0) continue;
    text += "|";
    for (size_t c = 0; c < grid[0].size(); ++c) text += c < 2 ? "---|" : "---:|";
    text += "\n";
  }
  return text;
}

std::string Markdown(const ResultTable& table) {
  std::string text = MarkdownGrid(WideGrid(table, " ✓", " ✗"));
  text +=
      "\nLower is better; bad-t and d1 in percent, epe in pixels, log in octaves; [95 % interval]. "
      "✓ better and ✗ "
      "worse than the baseline; without a mark: not significant.\n";
  for (const std::string& benchmark : table.benchmarks) {
    const TableCell& any = AnyCell(table, benchmark);
    text += "\n**" + benchmark + "** (" + Pairs(any) + "; as " + any.mimics + ")\n\n" +
            MarkdownGrid(BenchmarkGrid(table, benchmark));
    const Grid groups = GroupsGrid(table, benchmark);
    if (!groups.empty()) text += "\n" + MarkdownGrid(groups);
  }
  if (!table.notes.empty()) text += "\n";
  for (const std::string& note : table.notes) text += "- " + note + "\n";
  return text;
}

std::string LatexEscaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string("_%&#$").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// Formats a LaTeX table like the paper's: booktabs, a column a benchmark; raised signs mark
// differences from the baseline.
std::string Latex(const ResultTable& table) {
  const Grid grid = WideGrid(table, "$^{+}$", "$^{-}$");
  std::string text = fmt::format("\\begin{{tabular}}{{ll*{{{}}}{{r}}}}\n", grid[0].size() - 2);
  for (size_t r = 0; r < grid.size(); ++r) {
    if (r == 0) text += "\\toprule\n";
    for (size_t c = 0; c < grid[r].size(); ++c) {
      std::string cell = grid[r][c];
      const size_t mark = cell.find("$^{");
      const std::string tail = mark == std::string::npos ? "" : cell.substr(mark);
      text += (c > 0 ? " & " : "") + LatexEscaped(cell.substr(0, mark)) + tail;
    }
    text += " \\\\\n";
    if (r == 0) text += "\\midrule\n";
  }
  text += "\\bottomrule\n\\end{tabular}\n";
  text += "% + better, - worse than the baseline at 95 %; no mark: not significant\n";
  for (const std::string& note : table.notes) text += "% " + note + "\n";
  return text;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// A line a figure, so that spreadsheets and data frames can pivot it.
std::string Csv(const ResultTable& table) {
  std::string text =
      "variant,trainer,seeds,benchmark,metric,value,low,high,pairs,verdict,benchmark_seeds\n";
  const auto line = [&](const TableRow& row, const std::string& benchmark,
                        const TableFigure& figure) {
    const TableComparison* one = FindComparison(table, row, benchmark);
    const bool decides = one != nullptr && one->decided_by == figure.metric;
    text += fmt::format(
        "{},{},{},{},{},{:.6g},{:.6g},{:.6g},{},{},{}\n", CsvField(row.variant),
        CsvField(row.trainer), row.seeds, CsvField(benchmark), CsvField(figure.metric),
        figure.interval.value, figure.interval.low, figure.interval.high, figure.pairs,
        decides ? VerdictName(one->comparison.verdict) : "", row.cells.at(benchmark).seeds);
  };
  for (const TableRow& row : table.rows) {
    for (const auto& [benchmark, cell] : row.cells) {
      line(row, benchmark, cell.headline);
      for (const TableFigure& figure : cell.others) line(row, benchmark, figure);
    }
  }
  return text;
}

Json FigureJson(const TableFigure& figure) {
  return {{"metric", figure.metric},
          {"value", figure.interval.value},
          {"low", figure.interval.low},
          {"high", figure.interval.high},
          {"pairs", figure.pairs}};
}

void AddFigures(const TableFigures& figures, Json& json) {
  json.update(FigureJson(figures.headline));
  Json& others = json["others"] = Json::array();
  for (const TableFigure& figure : figures.others) others.push_back(FigureJson(figure));
}

Json ComparisonJson(const TableComparison& one) {
  const Comparison& c = one.comparison;
  return {{"benchmark", one.benchmark},
          {"metric", one.metric},
          {"variant", one.variant},
          {"trainer", one.trainer},
          {"baseline", one.baseline},
          {"baseline_trainer", one.baseline_trainer},
          {"difference", one.difference.value},
          {"low", one.difference.low},
          {"high", one.difference.high},
          {"verdict", VerdictName(c.verdict)},
          {"decided_by",
           {{"metric", one.decided_by},
            {"difference", c.difference.value},
            {"low", c.difference.low},
            {"high", c.difference.high}}},
          {"seeds", c.seeds},
          {"pairs", one.pairs},
          {"groups", c.images < one.pairs ? Json(c.images) : Json()},
          {"more_seeds", c.more_seeds ? Json(*c.more_seeds) : Json()},
          {"least_difference", c.least_difference ? Json(*c.least_difference) : Json()}};
}

std::string JsonText(const ResultTable& table) {
  Json rows = Json::array(), comparisons = Json::array();
  for (const TableRow& row : table.rows) {
    Json benchmarks = Json::object();
    for (const std::string& benchmark : table.benchmarks) {
      const auto cell = row.cells.find(benchmark);
      if (cell == row.cells.end()) continue;
      Json& json = benchmarks[benchmark];
      AddFigures(cell->second, json);
      json["seeds"] = cell->second.seeds;
      for (const auto& [group, figures] : cell->second.groups) {
        AddFigures(figures, json["groups"].emplace_back(Json{{"group", group}}));
      }
    }
    rows.push_back({{"variant", row.variant},
                    {"trainer", row.trainer},
                    {"seeds", row.seeds},
                    {"benchmarks", std::move(benchmarks)}});
  }
  for (const TableComparison& one : table.comparisons) comparisons.push_back(ComparisonJson(one));
  const Json json = {
      {"rows", std::move(rows)}, {"comparisons", std::move(comparisons)}, {"notes", table.notes}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

struct Format {
  const char* name;
  std::string (*write)(const ResultTable&);
};
constexpr Format kFormats[] = {
    {"text", Text}, {"markdown", Markdown}, {"latex", Latex}, {"csv", Csv}, {"json", JsonText}};

}  // namespace

const std::vector<std::string>& TableFormats() {
  static const auto& names = *new std::vector<std::string>([] {
    std::vector<std::string> all;
    for (const Format& format : kFormats) all.push_back(format.name);
    return all;
  }());
  return names;
}

absl::StatusOr<std::string> FormatTable(const ResultTable& table, const std::string& format) {
  std::string known;
  for (const Format& one : kFormats) {
    if (format == one.name) return one.write(table);
    known += (known.empty() ? "" : ", ") + std::string(one.name);
  }
  return InvalidArgument("there is no format '{}'; there are {}", format, known);
}

}  // namespace parallax
