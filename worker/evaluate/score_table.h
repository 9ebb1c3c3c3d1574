// Makes the table of a study from its score files: a row for each (variant, trainer), a figure with
// its interval for each benchmark, and whether each row differs significantly from the baseline.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/scores.h"
#include "worker/evaluate/statistics.h"

namespace parallax {

// One figure of a cell.
struct TableFigure {
  std::string metric;  // MetricName.
  // NaN when no image has the metric's region.
  Interval interval;  // Ends equal to the value: one seed and one image, so no spread is known.
  int pairs = 0;      // Images with the metric's region.
};

// Figures of the same pairs.
struct TableFigures {
  TableFigure headline;
  std::vector<TableFigure> others;  // The benchmark's further figures.
};

// A row's figures on one benchmark.
struct TableCell : TableFigures {
  // By group, where pairs come from several sets.
  std::map<std::string, TableFigures> groups;
  int seeds = 0;            // Seeds scored on this benchmark; at most those of the row.
  int pairs_published = 0;  // Size of the whole benchmark; 0 where that isn't fixed.
  std::string mimics;
};

// One (variant, trainer).
struct TableRow {
  std::string variant, trainer;
  // Seeds scored on any benchmark. 0: the predictor needs no training.
  int seeds = 0;
  std::map<std::string, TableCell> cells;  // By benchmark.
};

// A row against its baseline on one benchmark.
struct TableComparison {
  std::string benchmark, metric;  // The metric is the figure shown.
  std::string variant, trainer;
  std::string baseline, baseline_trainer;
  int pairs = 0;
  bool of_trainings = false;  // Both rows have seeds.
  Interval difference;        // Difference of the figure shown.
  std::string decided_by;     // The metric of `comparison`.
  Comparison comparison;      // Its images are groups of pairs, where intervals draw these.
};

// The whole table.
struct ResultTable {
  std::vector<std::string> benchmarks;  // Columns, in order.
  std::vector<TableRow> rows;
  std::vector<TableComparison> comparisons;  // Each row against its baseline.
  // One sentence each: incomplete benchmarks, missing and single seeds.
  std::vector<std::string> notes;
};

// The baseline and the order of rows.
struct TableOptions {
  // A variant; empty: "default", else "baseline", else the first row that has seeds. Rows of the
  // same trainer are compared with it; rows without seeds with the first baseline there is.
  std::string baseline;
  std::vector<std::string> variant_order;  // Others follow by name.
  bool weigh_groups = false;  // Each group of pairs counts alike, instead of each pair.
  // Verdicts are by the mean log error, which is shown as well, instead of by the headline.
  bool decide_by_log = false;
  BootstrapOptions bootstrap;
};

// Makes the table. Errors: kInvalidArgument for an unknown baseline, naming the variants;
// kFailedPrecondition if evaluations of one benchmark can't be compared: other pairs, other truth,
// another metric or number of looks, both named.
absl::StatusOr<ResultTable> MakeTable(const std::vector<Evaluation>& scores,
                                      const TableOptions& options);

// Returns the table as text in a format: "text", "markdown", "latex", "csv" or "json". Errors:
// kInvalidArgument for another format, listing these.
absl::StatusOr<std::string> FormatTable(const ResultTable& table, const std::string& format);
const std::vector<std::string>& TableFormats();

}  // namespace parallax
