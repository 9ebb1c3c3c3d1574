#include "coordinator/client/scores/score_trials.h"

#include <algorithm>
#include <map>
#include <optional>

#include "coordinator/client/scores/page_table.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/search/rung_study.h"
#include "worker/evaluate/statistics.h"

namespace parallax {
namespace {

using RunsBySeed = std::map<int64_t, const Evaluation*>;
using RunsOfTrial = std::map<std::string, RunsBySeed>;  // By benchmark.

absl::Status Lacks(const std::string& variant, const std::string& what) {
  return FailedPrecondition("{} can't be compared with the default: {}", variant, what);
}

// Returns the images' errors as cells whose quotient is the figure of the measure: each benchmark's
// weights sum up to 1. Images of one group are one cell; with `weigh_groups` each group has the
// same weight.
std::vector<Quotient> CellsOfRun(const Evaluation& run, const Measure& measure, bool weigh_groups) {
  std::vector<std::string> groups;
  std::vector<double> errors;
  std::map<std::string, double> sizes;
  for (const Scores& image : run.images) {
    const auto tally = image.regions.find(run.headline.region);
    if (tally == image.regions.end() || tally->second.pixels == 0) continue;
    groups.push_back(image.pair_group);
    errors.push_back(FigureOf(measure, tally->second));
    // An image without a group is one by itself.
    sizes[image.pair_group] = image.pair_group.empty() ? 1 : sizes[image.pair_group] + 1;
  }
  const auto share_of = [&](size_t i) { return weigh_groups ? 1 / sizes.at(groups[i]) : 1; };
  double whole = 0;
  for (size_t i = 0; i < errors.size(); ++i) whole += share_of(i);
  const std::vector<int> units = UnitsOf(groups);
  std::vector<Quotient> cells;
  for (size_t i = 0; i < errors.size(); ++i) {
    const double weight = share_of(i) / whole;
    cells.resize(std::max(cells.size(), static_cast<size_t>(units[i]) + 1));
    Quotient& cell = cells[static_cast<size_t>(units[i])];
    cell.numerator += weight * errors[i];
    cell.denominator += weight;
  }
  return cells;
}

bool SamePairs(const Evaluation& a, const Evaluation& b) {
  return a.headline == b.headline &&
         std::equal(a.images.begin(), a.images.end(), b.images.begin(), b.images.end(),
                    [](const Scores& x, const Scores& y) { return x.pair == y.pair; });
}

// Returns the trial's cells by seed, all benchmarks side by side.
absl::StatusOr<FigureTable> TableOfTrial(const std::string& variant, const RunsOfTrial& runs,
                                         const RunsOfTrial& reference, const ScoreQuery& query,
                                         const Measure& measure) {
  FigureTable table;
  for (const std::string& benchmark : query.benchmarks) {
    const auto own = runs.find(benchmark), others = reference.find(benchmark);
    if (own == runs.end() || others == reference.end()) {
      return Lacks(variant, "no scores on " + benchmark);
    }
    if (table.empty()) table.resize(others->second.size());
    if (own->second.size() != table.size()) {
      return Lacks(variant, "other numbers of seeds on " + benchmark);
    }
    auto row = table.begin();
    auto other = others->second.begin();
    for (const auto& [seed, run] : own->second) {
      if (seed != other->first || !SamePairs(*run, *other->second)) {
        return Lacks(variant, "other pairs or seeds on " + benchmark);
      }
      const std::vector<Quotient> cells = CellsOfRun(*run, measure, query.weigh_groups);
      row->insert(row->end(), cells.begin(), cells.end());
      ++row, ++other;
    }
  }
  if (table.empty() || table[0].empty()) return Lacks(variant, "no picture with truth");
  return table;
}

v1::SearchFigure FigureFrom(const Interval& interval, double points) {
  v1::SearchFigure figure;
  figure.set_value(interval.value + points);
  figure.set_low(interval.low + points);
  figure.set_high(interval.high + points);
  return figure;
}

// Returns the difference a - b with what is known of it. Few seeds tell nothing.
struct Told {
  v1::SearchFigure difference;
  std::optional<v1::SearchFigure> log_difference;  // In octaves, where the verdict is by it.
  Verdict verdict = Verdict::kNotSignificant;
};
absl::StatusOr<Told> Tell(const FigureTable& a, const FigureTable& b, double points) {
  ASSIGN_OR_RETURN(const Comparison comparison,
                   ComparePaired(a, b, /*seeded=*/true, BootstrapOptions()));
  Told told{.difference = FigureFrom(comparison.difference, points)};
  if (comparison.seeds_spread_unknown) return told;
  if (told.difference.high() < 0) told.verdict = Verdict::kBetter;
  if (told.difference.low() > 0) told.verdict = Verdict::kWorse;
  return told;
}

}  // namespace

absl::StatusOr<std::vector<TrialScore>> TrialScoresOf(const std::vector<Evaluation>& evaluations,
                                                      const ScoreQuery& query) {
  std::map<std::string, RunsOfTrial> runs;  // By variant.
  for (const Evaluation& one : evaluations) {
    if (one.run.seed && query.without.count(one.run.variant) == 0)
      runs[one.run.variant][one.benchmark][*one.run.seed] = &one;
  }
  const auto reference = runs.find(kDefaultTrial);
  if (reference == runs.end()) return InvalidArgument("the variant default has no scores");
  const auto points_of = [&](const std::string& variant) {
    const auto found = query.points.find(variant);
    return found == query.points.end() ? 0 : found->second;
  };
  std::map<std::string, FigureTable> tables, of_logs;  // The latter where they decide.
  std::vector<TrialScore> scores;
  for (const auto& [variant, of_variant] : runs) {
    const auto table_by = [&, &trial = variant, &trials_runs = of_variant](const Measure& measure) {
      return TableOfTrial(trial, trials_runs, reference->second, query, measure);
    };
    ASSIGN_OR_RETURN(tables[variant], table_by(BadAt(2)));
    if (query.decide_by_log) {
      ASSIGN_OR_RETURN(of_logs[variant], table_by(kLogMeasure));
    }
    TrialScore& score = scores.emplace_back();
    score.variant = variant;
    ASSIGN_OR_RETURN(const Interval objective,
                     BootstrapFigure(tables[variant], BootstrapOptions()));
    score.objective = FigureFrom(objective, points_of(variant));
  }
  const std::string best =
      std::min_element(scores.begin(), scores.end(), [](const TrialScore& a, const TrialScore& b) {
        return a.objective.value() < b.objective.value();
      })->variant;
  const auto compare = [&](const std::string& a, const std::string& b) -> absl::StatusOr<Told> {
    ASSIGN_OR_RETURN(Told told, Tell(tables[a], tables[b], points_of(a) - points_of(b)));
    if (!query.decide_by_log) return told;
    ASSIGN_OR_RETURN(const Told by_log, Tell(of_logs[a], of_logs[b], 0));
    told.log_difference = by_log.difference;
    told.verdict = by_log.verdict;
    return told;
  };
  for (TrialScore& score : scores) {
    ASSIGN_OR_RETURN(Told told, compare(score.variant, kDefaultTrial));
    score.difference = std::move(told.difference);
    score.log_difference = std::move(told.log_difference);
    score.verdict = VerdictName(told.verdict);
    if (score.variant == best) continue;
    ASSIGN_OR_RETURN(told, compare(score.variant, best));
    score.worse_than_best = told.verdict == Verdict::kWorse;
  }
  return scores;
}

absl::StatusOr<std::vector<TrialScore>> ScoreTrials(JobQueue& queue, const Store& store,
                                                    const ScoreQuery& query) {
  ASSIGN_OR_RETURN(const v1::StudyStatus study, queue.GetStudy(StudyId{query.study}));
  ASSIGN_OR_RETURN(const std::vector<Evaluation> evaluations, StudyScores(queue, store, study));
  return TrialScoresOf(evaluations, query);
}

}  // namespace parallax
