#include "worker/evaluate/score_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "worker/evaluate/benchmark.h"

namespace parallax {
namespace {

using RowKey = std::pair<std::string, std::string>;                // Variant, trainer.
using Runs = std::map<std::optional<int64_t>, const Evaluation*>;  // By seed.

bool HasSeeds(const Runs& runs) { return runs.begin()->first.has_value(); }

std::string Describe(const Evaluation& evaluation) {
  const RunIdentity& run = evaluation.run;
  return "variant " + run.variant + ", trainer " + run.trainer +
         (run.seed ? fmt::format(", seed {}", *run.seed) : "");
}

absl::Status Differ(const Evaluation& a, const Evaluation& b, const std::string& what) {
  return FailedPrecondition("{}: {} and {} can't be compared: {}", a.benchmark, Describe(a),
                            Describe(b), what);
}

int64_t PixelsIn(const Scores& scores, const std::string& region) {
  const auto found = scores.regions.find(region);
  return found == scores.regions.end() ? 0 : found->second.pixels;
}

// Whether both were measured on the same pairs against the same truth.
absl::Status CheckComparable(const Evaluation& a, const Evaluation& b) {
  if (!(a.headline == b.headline)) return Differ(a, b, "their metrics differ");
  if (a.images.size() != b.images.size()) {
    return Differ(a, b, fmt::format("{} pairs and {}", a.images.size(), b.images.size()));
  }
  for (size_t i = 0; i < a.images.size(); ++i) {
    const Scores &x = a.images[i], &y = b.images[i];
    if (x.pair != y.pair) return Differ(a, b, "pair " + x.pair + " and pair " + y.pair);
    for (const std::string region : {"all", "nocc"}) {
      if (PixelsIn(x, region) != PixelsIn(y, region)) {
        return Differ(a, b, "pair " + x.pair + " has other truth");
      }
    }
  }
  return absl::OkStatus();
}

// The images of a run that have the region; with a group, those of them that belong to it.
std::vector<const Scores*> ImagesOf(const Evaluation& evaluation, const std::string& region,
                                    const std::string* group = nullptr) {
  std::vector<const Scores*> images;
  for (const Scores& scores : evaluation.images) {
    if (PixelsIn(scores, region) == 0 || (group && scores.pair_group != *group)) continue;
    images.push_back(&scores);
  }
  return images;
}

// The figure's cells, one for each unit that intervals draw.
std::vector<Quotient> CellsOf(const Metric& metric, const std::vector<const Scores*>& images,
                              bool weigh_groups) {
  std::vector<std::string> groups;
  std::vector<Quotient> ones;
  std::map<std::string, double> weights;  // Denominators of groups.
  for (const Scores* scores : images) {
    const ErrorTally& tally = scores->regions.at(metric.region);
    ones.push_back(metric.pooled ? QuotientOf(metric.measure, tally)
                                 : Quotient{FigureOf(metric.measure, tally), 1});
    groups.push_back(scores->pair_group);
    weights[scores->pair_group] += ones.back().denominator;
  }
  const std::vector<int> units = UnitsOf(groups);
  std::vector<Quotient> cells;
  for (size_t i = 0; i < ones.size(); ++i) {
    const double whole = groups[i].empty() ? ones[i].denominator : weights.at(groups[i]);
    const double weight = weigh_groups ? 1 / whole : 1;
    cells.resize(std::max(cells.size(), static_cast<size_t>(units[i]) + 1));
    Quotient& cell = cells[static_cast<size_t>(units[i])];
    cell.numerator += weight * ones[i].numerator;
    cell.denominator += weight * ones[i].denominator;
  }
  return cells;
}

// With a group, over its pairs alone.
absl::StatusOr<TableFigure> MakeFigure(const Metric& metric, const Runs& runs,
                                       const TableOptions& options, const std::string* group) {
  FigureTable table;
  TableFigure figure{.metric = MetricName(metric)};
  for (const auto& [seed, run] : runs) {
    const std::vector<const Scores*> images = ImagesOf(*run, metric.region, group);
    figure.pairs = static_cast<int>(images.size());
    table.push_back(CellsOf(metric, images, options.weigh_groups));
  }
  if (figure.pairs == 0) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    figure.interval = {.value = kNone, .low = kNone, .high = kNone};
    return figure;
  }
  ASSIGN_OR_RETURN(figure.interval, BootstrapFigure(table, options.bootstrap));
  const bool percent =
      metric.measure.kind == Measure::Kind::kBad || metric.measure.kind == Measure::Kind::kD1;
  if (percent) figure.interval.high = std::min(figure.interval.high, 100.0);
  return figure;
}

// The metric by which verdicts are made.
Metric DecidingMetric(const Evaluation& evaluation, const TableOptions& options) {
  Metric metric = evaluation.headline;
  if (options.decide_by_log) metric.measure = kLogMeasure;
  return metric;
}

absl::StatusOr<TableFigures> MakeFigures(const Runs& runs, const TableOptions& options,
                                         const std::string* group) {
  const Evaluation& any = *runs.begin()->second;
  TableFigures figures;
  ASSIGN_OR_RETURN(figures.headline, MakeFigure(any.headline, runs, options, group));
  std::vector<Metric> others = any.figures;
  const Metric deciding = DecidingMetric(any, options);
  const bool is_shown =
      deciding == any.headline || std::find(others.begin(), others.end(), deciding) != others.end();
  if (!is_shown) others.push_back(deciding);
  for (const Metric& metric : others) {
    ASSIGN_OR_RETURN(TableFigure figure, MakeFigure(metric, runs, options, group));
    if (figure.pairs > 0) figures.others.push_back(std::move(figure));
  }
  return figures;
}

absl::StatusOr<TableCell> MakeCell(const Runs& runs, const TableOptions& options) {
  const Evaluation& any = *runs.begin()->second;
  TableCell cell;
  cell.seeds = HasSeeds(runs) ? static_cast<int>(runs.size()) : 0;
  cell.pairs_published = any.pairs_published;
  cell.mimics = any.mimics;
  ASSIGN_OR_RETURN(static_cast<TableFigures&>(cell), MakeFigures(runs, options, nullptr));
  for (const Scores& scores : any.images) {
    const std::string& group = scores.pair_group;
    if (group.empty() || cell.groups.contains(group)) continue;
    ASSIGN_OR_RETURN(cell.groups[group], MakeFigures(runs, options, &group));
  }
  return cell;
}

// Both rows' runs by the seeds that both have; a row without seeds stands beside each of the
// other's.
struct PairedRuns {
  std::vector<const Evaluation*> a, b;
};

PairedRuns PairBySeed(const Runs& a, const Runs& b) {
  PairedRuns paired;
  const Runs& seeds = HasSeeds(a) ? a : b;
  for (const auto& [seed, unused] : seeds) {
    const auto in_a = HasSeeds(a) ? a.find(seed) : a.begin();
    const auto in_b = HasSeeds(b) ? b.find(seed) : b.begin();
    if (in_a == a.end() || in_b == b.end()) continue;
    paired.a.push_back(in_a->second);
    paired.b.push_back(in_b->second);
  }
  return paired;
}

// One network looks once and another twice: their difference would be that of the looks.
absl::Status CheckLooks(const PairedRuns& paired) {
  for (size_t i = 0; i < paired.a.size(); ++i) {
    const RunIdentity &a = paired.a[i]->run, &b = paired.b[i]->run;
    if (a.trainer != b.trainer || (a.looks == 1) == (b.looks == 1)) continue;
    return Differ(*paired.a[i], *paired.b[i], "one has looked once at each pair, the other twice");
  }
  return absl::OkStatus();
}

FigureTable TableOf(const Metric& metric, const std::vector<const Evaluation*>& runs,
                    bool weigh_groups) {
  FigureTable table;
  for (const Evaluation* run : runs) {
    table.push_back(CellsOf(metric, ImagesOf(*run, metric.region), weigh_groups));
  }
  return table;
}

// Scores of older versions do not name the groups of their pairs: others of the same benchmark do.
std::vector<Evaluation> WithGroups(std::vector<Evaluation> evaluations) {
  std::map<std::pair<std::string, std::string>, std::string> groups;
  for (const Evaluation& one : evaluations) {
    for (const Scores& scores : one.images) {
      if (!scores.pair_group.empty()) groups[{one.benchmark, scores.pair}] = scores.pair_group;
    }
  }
  for (Evaluation& one : evaluations) {
    for (Scores& scores : one.images) {
      const auto found = groups.find({one.benchmark, scores.pair});
      if (found != groups.end()) scores.pair_group = found->second;
    }
  }
  return evaluations;
}

// All score files, sorted into rows and benchmarks.
class Collection {
 public:
  explicit Collection(const std::vector<Evaluation>& evaluations) {
    for (const Evaluation& one : evaluations) {
      runs_[{one.run.variant, one.run.trainer}][one.benchmark][one.run.seed] = &one;
    }
  }

  absl::Status Check() const {
    std::map<std::string, const Evaluation*> first;
    for (const auto& [key, benchmarks] : runs_) {
      for (const auto& [benchmark, runs] : benchmarks) {
        for (const auto& [seed, run] : runs) {
          const auto [place, is_new] = first.try_emplace(benchmark, run);
          if (!is_new) RETURN_IF_ERROR(CheckComparable(*place->second, *run));
        }
        if (runs.contains(std::nullopt) && runs.size() > 1) {
          return FailedPrecondition("{}: variant {}, trainer {} has scores with and without a seed",
                                    benchmark, key.first, key.second);
        }
      }
    }
    return absl::OkStatus();
  }

  // Columns in the order of BenchmarkKinds(), then by name.
  std::vector<std::string> Benchmarks() const {
    std::set<std::string> left;
    for (const auto& [key, benchmarks] : runs_) {
      for (const auto& [benchmark, runs] : benchmarks) left.insert(benchmark);
    }
    std::vector<std::string> names;
    for (const BenchmarkKind& kind : BenchmarkKinds()) {
      if (left.erase(kind.name) > 0) names.push_back(kind.name);
    }
    names.insert(names.end(), left.begin(), left.end());
    return names;
  }

  // Trained rows in the order wanted, then those without seeds.
  std::vector<RowKey> Rows(const std::vector<std::string>& order) const {
    std::vector<RowKey> keys;
    for (const auto& [key, benchmarks] : runs_) keys.push_back(key);
    const auto place = [&](const RowKey& key) {
      return std::pair(SeedsOf(key) == 0,
                       std::find(order.begin(), order.end(), key.first) - order.begin());
    };
    std::stable_sort(keys.begin(), keys.end(),
                     [&](const RowKey& a, const RowKey& b) { return place(a) < place(b); });
    return keys;
  }

  const std::map<std::string, Runs>& Of(const RowKey& key) const { return runs_.at(key); }
  bool Has(const RowKey& key) const { return runs_.contains(key); }

  int SeedsOf(const RowKey& key) const {
    std::set<int64_t> seeds;
    for (const auto& [benchmark, runs] : runs_.at(key)) {
      for (const auto& [seed, run] : runs) {
        if (seed) seeds.insert(*seed);
      }
    }
    return static_cast<int>(seeds.size());
  }

 private:
  std::map<RowKey, std::map<std::string, Runs>> runs_;
};

absl::StatusOr<std::string> ChooseBaseline(const std::vector<RowKey>& rows,
                                           const std::string& wanted) {
  std::set<std::string> variants;
  for (const RowKey& row : rows) variants.insert(row.first);
  if (wanted.empty()) {
    for (const char* usual : {"default", "baseline"}) {
      if (variants.contains(usual)) return std::string(usual);
    }
    return rows[0].first;
  }
  if (variants.contains(wanted)) return wanted;
  std::string known;
  for (const std::string& variant : variants) known += (known.empty() ? "" : ", ") + variant;
  return InvalidArgument("baseline '{}' is not among the variants: {}", wanted, known);
}

// The row that `key` is compared with, or itself.
RowKey BaselineOf(const Collection& collection, const std::vector<RowKey>& rows, const RowKey& key,
                  const std::string& baseline) {
  if (collection.Has({baseline, key.second})) return {baseline, key.second};
  for (const RowKey& row : rows) {
    if (row.first == baseline) return row;
  }
  return key;
}

absl::Status AddComparisons(const Collection& collection, const RowKey& key, const RowKey& base,
                            const TableOptions& options, ResultTable& table) {
  for (const std::string& benchmark : table.benchmarks) {
    const auto a = collection.Of(key).find(benchmark), b = collection.Of(base).find(benchmark);
    if (a == collection.Of(key).end() || b == collection.Of(base).end()) continue;
    const PairedRuns paired = PairBySeed(a->second, b->second);
    if (paired.a.empty()) {
      table.notes.push_back(benchmark + ": " + key.first + " and " + base.first +
                            " have no seed in common, so they are not compared.");
      continue;
    }
    RETURN_IF_ERROR(CheckLooks(paired));
    const Metric& metric = paired.a[0]->headline;
    const Metric deciding = DecidingMetric(*paired.a[0], options);
    const bool seeded_a = HasSeeds(a->second), seeded_b = HasSeeds(b->second);
    const auto compare = [&](const Metric& by) {
      return ComparePaired(TableOf(by, paired.a, options.weigh_groups),
                           TableOf(by, paired.b, options.weigh_groups), seeded_a || seeded_b,
                           options.bootstrap);
    };
    if (ImagesOf(*paired.a[0], metric.region).empty()) continue;
    ASSIGN_OR_RETURN(const Comparison shown, compare(metric));
    Comparison comparison = shown;
    if (!(deciding == metric)) {
      ASSIGN_OR_RETURN(comparison, compare(deciding));
    }
    table.comparisons.push_back(
        {.benchmark = benchmark,
         .metric = MetricName(metric),
         .variant = key.first,
         .trainer = key.second,
         .baseline = base.first,
         .baseline_trainer = base.second,
         .pairs = static_cast<int>(ImagesOf(*paired.a[0], metric.region).size()),
         .of_trainings = seeded_a && seeded_b,
         .difference = shown.difference,
         .decided_by = MetricName(deciding),
         .comparison = comparison});
  }
  return absl::OkStatus();
}

// Names the rows that have fewer seeds on a benchmark than elsewhere.
void AddSeedNotes(ResultTable& table) {
  for (const std::string& benchmark : table.benchmarks) {
    std::string rows;
    for (const TableRow& row : table.rows) {
      const auto cell = row.cells.find(benchmark);
      if (cell == row.cells.end() || cell->second.seeds >= row.seeds) continue;
      rows += fmt::format("{}{} ({} of {})", rows.empty() ? "" : ", ", row.variant,
                          cell->second.seeds, row.seeds);
    }
    if (!rows.empty()) {
      table.notes.push_back(benchmark + ": fewer seeds than on other benchmarks for rows " + rows +
                            ".");
    }
  }
}

// " of 8 sets" where intervals draw these.
std::string InGroups(const TableComparison& one) {
  if (one.comparison.images == one.pairs) return "";
  return fmt::format(" of {} sets", one.comparison.images);
}

// Says which differences between trainings each benchmark could have shown: those of its median
// comparison.
void AddPowerNotes(ResultTable& table) {
  for (const std::string& benchmark : table.benchmarks) {
    std::vector<const TableComparison*> all;
    for (const TableComparison& one : table.comparisons) {
      const bool has_power = one.of_trainings && one.comparison.least_difference;
      if (one.benchmark == benchmark && has_power) all.push_back(&one);
    }
    if (all.empty()) continue;
    std::stable_sort(all.begin(), all.end(),
                     [](const TableComparison* a, const TableComparison* b) {
                       return a->comparison.least_difference < b->comparison.least_difference;
                     });
    const TableComparison& middle = *all[(all.size() - 1) / 2];
    table.notes.push_back(fmt::format(
        "{}: with {} seeds and {} pairs{}, differences of {} from {:.2f} are significant 80 of 100 "
        "times.",
        benchmark, middle.comparison.seeds, middle.pairs, InGroups(middle), middle.decided_by,
        *middle.comparison.least_difference));
  }
}

// Returns the number of pairs that belong to no set.
int SinglePairsOf(const TableCell& cell) {
  int pairs = cell.headline.pairs;
  for (const auto& [group, figures] : cell.groups) pairs -= figures.headline.pairs;
  return pairs;
}

// "real: intervals draw its 8 sets (1 to 16 pairs each) and 2 single pairs, because pairs of one
// set are not independent."
std::string GroupsNote(const std::string& benchmark, const TableCell& cell, bool weigh_groups) {
  int fewest = cell.headline.pairs, most = 0;
  for (const auto& [group, figures] : cell.groups) {
    fewest = std::min(fewest, figures.headline.pairs);
    most = std::max(most, figures.headline.pairs);
  }
  const int singles = SinglePairsOf(cell), units = static_cast<int>(cell.groups.size()) + singles;
  std::string sets =
      fmt::format("{} sets ({} pairs each)", cell.groups.size(),
                  fewest == most ? std::to_string(most) : fmt::format("{} to {}", fewest, most));
  if (singles > 0) sets += fmt::format(" and {} single pair{}", singles, singles > 1 ? "s" : "");
  const bool few = units < kFewestGroups;
  return fmt::format(
      "{}: {}.{}", benchmark,
      few ? "intervals draw pairs, which are not independent: its " + sets + " are too few"
          : "intervals draw its " + sets + ", because pairs of one set are not independent",
      weigh_groups ? " Each set counts alike in the mean." : "");
}

void AddNotes(const TableOptions& options, ResultTable& table) {
  std::set<std::string> told;
  bool single_seed = false;
  for (const TableRow& row : table.rows) {
    for (const auto& [benchmark, cell] : row.cells) {
      single_seed = single_seed || cell.seeds == 1;
      if (cell.pairs_published > 0 && cell.headline.pairs != cell.pairs_published &&
          told.insert(benchmark).second) {
        table.notes.push_back(fmt::format(
            "{}: {} pairs, the whole set has {}: not comparable with published figures.", benchmark,
            cell.headline.pairs, cell.pairs_published));
      }
      // A set of one pair each is as good as no set.
      const bool shared =
          static_cast<int>(cell.groups.size()) < cell.headline.pairs - SinglePairsOf(cell);
      if (shared && told.insert(benchmark + "/groups").second) {
        table.notes.push_back(GroupsNote(benchmark, cell, options.weigh_groups));
      }
      if (cell.headline.pairs == 1 && told.insert(benchmark + "/one").second) {
        table.notes.push_back(benchmark + ": one pair; intervals say nothing of other pictures.");
      }
    }
  }
  if (options.decide_by_log) {
    table.notes.push_back(
        "Verdicts are by log, the mean of log2(error / 0.5 px) in octaves, which varies less "
        "between trainings than the figure shown.");
  }
  AddSeedNotes(table);
  AddPowerNotes(table);
  if (single_seed) {
    table.notes.push_back(
        "Rows with one seed: the spread between seeds is not known, so no difference is "
        "significant.");
  }
}

}  // namespace

absl::StatusOr<ResultTable> MakeTable(const std::vector<Evaluation>& scores,
                                      const TableOptions& options) {
  if (scores.empty()) return InvalidArgument("a table of no score files");
  const std::vector<Evaluation> evaluations = WithGroups(scores);
  const Collection collection(evaluations);
  RETURN_IF_ERROR(collection.Check());
  ResultTable table{.benchmarks = collection.Benchmarks()};
  const std::vector<RowKey> rows = collection.Rows(options.variant_order);
  ASSIGN_OR_RETURN(const std::string baseline, ChooseBaseline(rows, options.baseline));
  for (const RowKey& key : rows) {
    TableRow row{.variant = key.first, .trainer = key.second, .seeds = collection.SeedsOf(key)};
    for (const auto& [benchmark, runs] : collection.Of(key)) {
      ASSIGN_OR_RETURN(row.cells[benchmark], MakeCell(runs, options));
    }
    table.rows.push_back(std::move(row));
  }
  for (const RowKey& key : rows) {
    const RowKey base = BaselineOf(collection, rows, key, baseline);
    if (base == key) continue;
    RETURN_IF_ERROR(AddComparisons(collection, key, base, options, table));
  }
  AddNotes(options, table);
  return table;
}

}  // namespace parallax
