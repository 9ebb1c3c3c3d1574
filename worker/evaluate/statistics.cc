#include "worker/evaluate/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "common/base/rng.h"

namespace parallax {
namespace {

// Parts of a figure below which a difference is rounding.
constexpr double kRounding = 1e-10;

// How often each unit was drawn.
std::vector<double> DrawWeights(size_t units, Rng& rng) {
  std::vector<double> weights(units, units == 1 ? 1.0 : 0.0);
  for (size_t i = 0; i + 1 < units; ++i) {
    weights[static_cast<size_t>(rng.UniformInt(0, static_cast<int>(units) - 1))] += 1;
  }
  return weights;
}

// NaN when the drawn images have no pixels.
double WeightedFigure(const FigureTable& table, const std::vector<double>& seeds,
                      const std::vector<double>& images) {
  double sum = 0, weight = 0;
  for (size_t s = 0; s < table.size(); ++s) {
    if (seeds[s] == 0) continue;
    Quotient total;
    for (size_t i = 0; i < images.size(); ++i) {
      total.numerator += images[i] * table[s][i].numerator;
      total.denominator += images[i] * table[s][i].denominator;
    }
    sum += seeds[s] * total.numerator / total.denominator;
    weight += seeds[s];
  }
  return sum / weight;
}

absl::Status CheckTable(const FigureTable& table) {
  if (table.empty() || table[0].empty()) {
    return InvalidArgument("statistics of no figures");
  }
  for (const auto& row : table) {
    if (row.size() != table[0].size()) {
      return InvalidArgument("statistics: seeds with different images");
    }
  }
  return absl::OkStatus();
}

// Each cell's share in the figure: cells whose mean is the figure, to first order in their spread.
// With denominators of 1 it is the cell itself.
std::vector<std::vector<double>> Linearised(const FigureTable& table) {
  std::vector<std::vector<double>> cells;
  for (const auto& row : table) {
    Quotient total;
    for (const Quotient& cell : row) {
      total.numerator += cell.numerator;
      total.denominator += cell.denominator;
    }
    const double figure = total.numerator / total.denominator;
    const double mean_denominator = total.denominator / static_cast<double>(row.size());
    std::vector<double>& out = cells.emplace_back();
    for (const Quotient& cell : row) {
      out.push_back(figure + (cell.numerator - figure * cell.denominator) / mean_denominator);
    }
  }
  return cells;
}

double MeanOf(const std::vector<double>& values) {
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  return mean;
}

double Variance(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double mean = MeanOf(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return squares / static_cast<double>(values.size() - 1);
}

struct Means {
  std::vector<double> seeds, images;
};

Means MeansOf(const std::vector<std::vector<double>>& cells) {
  Means means{.seeds = std::vector<double>(cells.size()),
              .images = std::vector<double>(cells[0].size())};
  for (size_t s = 0; s < cells.size(); ++s) {
    for (size_t i = 0; i < cells[s].size(); ++i) {
      means.seeds[s] += cells[s][i] / static_cast<double>(cells[s].size());
      means.images[i] += cells[s][i] / static_cast<double>(cells.size());
    }
  }
  return means;
}

DifferenceSpread SpreadOf(const std::vector<std::vector<double>>& cells) {
  const auto seeds = static_cast<double>(cells.size());
  const auto images = static_cast<double>(cells[0].size());
  const Means means = MeansOf(cells);
  double grand = 0, squares = 0;
  for (const double mean : means.seeds) grand += mean / seeds;
  for (size_t s = 0; s < cells.size(); ++s) {
    for (size_t i = 0; i < cells[s].size(); ++i) {
      const double left = cells[s][i] - means.seeds[s] - means.images[i] + grand;
      squares += left * left;
    }
  }
  DifferenceSpread out;
  out.rest = seeds > 1 && images > 1 ? squares / ((seeds - 1) * (images - 1)) : 0;
  out.seeds = std::max(0.0, Variance(means.seeds) - out.rest / images);
  out.images = std::max(0.0, Variance(means.images) - out.rest / seeds);
  return out;
}

// Returns DifferenceSpread::degrees_share: how many equal images are worth as much, over their
// number. Groups of 16 pairs and of one do not say as much of the spread between groups as two of
// equal size.   Source: Kish, "Survey sampling", 8.2.
double DegreesShare(const std::vector<Quotient>& images) {
  double sum = 0, squares = 0;
  for (const Quotient& image : images) {
    sum += image.denominator;
    squares += image.denominator * image.denominator;
  }
  return sum * sum / (static_cast<double>(images.size()) * squares);
}

// Satterthwaite's, of a sum of two estimated variances; infinite without any variance.
double DegreesOfFreedom(double seed_variance, double seeds, double image_variance,
                        double image_degrees) {
  double denominator = 0;
  if (seeds > 1) denominator += seed_variance * seed_variance / (seeds - 1);
  if (image_degrees > 0) denominator += image_variance * image_variance / image_degrees;
  const double sum = seed_variance + image_variance;
  return denominator > 0 ? sum * sum / denominator : std::numeric_limits<double>::infinity();
}

double QuantileFor(double confidence, double degrees) {
  constexpr double kAsGoodAsNormal = 1e6;
  return StudentQuantile(0.5 + confidence / 2, std::min(degrees, kAsGoodAsNormal));
}

// Half the length of the interval around a figure, from the replicates' spread.
double HalfLength(const std::vector<double>& replicates,
                  const std::vector<std::vector<double>>& cells, double degrees_share,
                  double confidence) {
  const Means means = MeansOf(cells);
  const auto seeds = static_cast<double>(cells.size());
  const auto images = static_cast<double>(cells[0].size());
  const double degrees =
      DegreesOfFreedom(Variance(means.seeds) / seeds, seeds, Variance(means.images) / images,
                       degrees_share * (images - 1));
  const double deviation = std::sqrt(Variance(replicates));
  // Equal figures differ by the rounding of their sums.
  if (deviation <= kRounding * std::abs(MeanOf(replicates))) return 0;
  return QuantileFor(confidence, degrees) * deviation;
}

// The distribution of a difference's mean, and half the length of its interval.
struct DifferenceOfMeans {
  double deviation = 0, degrees = 0, half = 0;
};

DifferenceOfMeans MeansWith(const DifferenceSpread& spread, int seeds, int images,
                            double confidence) {
  const double by_seeds = spread.seeds / seeds, by_images = spread.images / images;
  const double rest = spread.rest / (static_cast<double>(seeds) * images);
  const double image_degrees = spread.degrees_share * (images - 1);
  DifferenceOfMeans means{
      .deviation = std::sqrt(by_seeds + by_images + rest),
      .degrees = DegreesOfFreedom(by_seeds + rest, seeds, by_images + rest, image_degrees)};
  // Drawing both seeds and images counts what is left three times (Owen 2007).
  means.half = spread.widened * QuantileFor(confidence, means.degrees) *
               std::sqrt(by_seeds + by_images + 3 * rest);
  return means;
}

// The smallest number of seeds with which a difference of this size would leave 0 outside of its
// interval, other things equal.
std::optional<int> SeedsToTell(double difference, const DifferenceSpread& spread, int seeds,
                               int images, double confidence) {
  for (int wanted = seeds + 1; wanted <= kMostSeeds; ++wanted) {
    if (std::abs(difference) > MeansWith(spread, wanted, images, confidence).half) return wanted;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> LeastDifference(const DifferenceSpread& spread, int seeds, int images,
                                      double confidence) {
  if (seeds < 2 || images < 2) return std::nullopt;
  constexpr double kPower = 0.8;
  const DifferenceOfMeans means = MeansWith(spread, seeds, images, confidence);
  const double beyond = QuantileFor(2 * kPower - 1, means.degrees);  // On one side.
  return means.half + beyond * means.deviation;
}

std::vector<int> UnitsOf(const std::vector<std::string>& groups) {
  std::map<std::string, int> by_group;
  std::vector<int> units;
  int count = 0;
  for (const std::string& group : groups) {
    const bool known = !group.empty() && !by_group.try_emplace(group, count).second;
    units.push_back(known ? by_group.at(group) : count++);
  }
  if (count < kFewestGroups) std::iota(units.begin(), units.end(), 0);
  return units;
}

double MeanFigure(const FigureTable& table) {
  return WeightedFigure(table, std::vector<double>(table.size(), 1),
                        std::vector<double>(table[0].size(), 1));
}

absl::StatusOr<Interval> BootstrapFigure(const FigureTable& table,
                                         const BootstrapOptions& options) {
  RETURN_IF_ERROR(CheckTable(table));
  std::vector<double> replicates;
  Rng rng(SceneSeed{options.seed}, "evaluate/bootstrap");
  for (int r = 0; r < options.replicates; ++r) {
    const std::vector<double> seeds = DrawWeights(table.size(), rng);
    const double figure = WeightedFigure(table, seeds, DrawWeights(table[0].size(), rng));
    if (std::isfinite(figure)) replicates.push_back(figure);
  }
  const double value = MeanFigure(table);
  const double half =
      HalfLength(replicates, Linearised(table), DegreesShare(table[0]), options.confidence);
  // No figure is below 0: all are errors.
  return Interval{.value = value, .low = std::max(0.0, value - half), .high = value + half};
}

std::string VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kBetter:
      return "better";
    case Verdict::kWorse:
      return "worse";
    case Verdict::kNotSignificant:
      return "not significant";
  }
  return "";
}

absl::StatusOr<Comparison> ComparePaired(const FigureTable& a, const FigureTable& b, bool seeded,
                                         const BootstrapOptions& options) {
  RETURN_IF_ERROR(CheckTable(a));
  RETURN_IF_ERROR(CheckTable(b));
  if (a.size() != b.size() || a[0].size() != b[0].size()) {
    return InvalidArgument("statistics: rows with different seeds or images");
  }
  std::vector<double> replicates;
  Rng rng(SceneSeed{options.seed}, "evaluate/bootstrap");
  for (int r = 0; r < options.replicates; ++r) {
    const std::vector<double> seeds = DrawWeights(a.size(), rng);
    const std::vector<double> images = DrawWeights(a[0].size(), rng);
    const double difference = WeightedFigure(a, seeds, images) - WeightedFigure(b, seeds, images);
    if (std::isfinite(difference)) replicates.push_back(difference);
  }
  std::vector<std::vector<double>> cells = Linearised(a);
  const std::vector<std::vector<double>> others = Linearised(b);
  for (size_t s = 0; s < cells.size(); ++s) {
    for (size_t i = 0; i < cells[s].size(); ++i) cells[s][i] -= others[s][i];
  }
  const double value = MeanFigure(a) - MeanFigure(b);
  const double degrees_share = DegreesShare(a[0]);
  const double half = HalfLength(replicates, cells, degrees_share, options.confidence);
  Comparison comparison{.difference = {.value = value, .low = value - half, .high = value + half},
                        .seeds = static_cast<int>(a.size()),
                        .images = static_cast<int>(a[0].size()),
                        .seeds_spread_unknown = seeded && a.size() < 2,
                        .spread = SpreadOf(cells)};
  comparison.spread.degrees_share = degrees_share;
  const double model =
      MeansWith(comparison.spread, comparison.seeds, comparison.images, options.confidence).half;
  if (degrees_share < 0.99 && model > 0) comparison.spread.widened = half / model;
  if (seeded) {
    comparison.least_difference =
        LeastDifference(comparison.spread, comparison.seeds, comparison.images, options.confidence);
  }
  const bool differs = std::abs(value) > kRounding * std::abs(MeanFigure(b));
  const bool repeated = a.size() > 1 || a[0].size() > 1;
  const bool can_tell = differs && repeated && !comparison.seeds_spread_unknown;
  if (can_tell && comparison.difference.high < 0) {
    comparison.verdict = Verdict::kBetter;
  } else if (can_tell && comparison.difference.low > 0) {
    comparison.verdict = Verdict::kWorse;
  } else if (seeded && a.size() > 1 && differs) {
    const std::optional<int> wanted = SeedsToTell(value, comparison.spread, comparison.seeds,
                                                  comparison.images, options.confidence);
    if (wanted) comparison.more_seeds = *wanted - comparison.seeds;
  }
  return comparison;
}

}  // namespace parallax
