// Confidence intervals of figures and of differences between two predictors, by a bootstrap over
// seeds of training and over images, with differences paired by both.
//
// Model. A figure is measured for S seeds on the same I images. Seeds and images are both drawn
// from larger populations and cross each other: every seed sees every image, so an image that is
// hard is hard for all seeds. A replicate draws S - 1 of the seeds and I - 1 of the images, with
// replacement, and takes each drawn image under each drawn seed; drawing one fewer makes the
// replicates' variance an unbiased estimate for few units. The interval is the figure -+ Student's
// t times the replicates' standard deviation; its degrees of freedom weigh those of seeds and of
// images by their shares of the variance (Satterthwaite), those of images in proportion to the
// effective number of them where they weigh differently (Kish). Without that, three seeds give
// intervals less than half as long as they must be. With one seed nothing is known of the spread
// between seeds, and the interval is that of the images alone. Source: Owen, "The pigeonhole
// bootstrap", Annals of Applied Statistics 2007; Rao and Wu, "Resampling inference with complex
// survey data", JASA 1988.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/metrics.h"

namespace parallax {

// Figures of one row: table[seed][image], each image as numerator / denominator. With denominators
// of 1 the figure is the mean over images; with counts of pixels it is that of the pool.
using FigureTable = std::vector<std::vector<Quotient>>;

// With fewer groups of pairs, intervals draw pairs: so few say nothing of the spread between
// groups.
inline constexpr int kFewestGroups = 5;

// Returns for each pair the unit that intervals draw it with, numbered from 0 in order: its group,
// or a unit of its own where `groups` has an empty string or less than kFewestGroups units. Pairs
// of one set share cameras, scenes and the way their truth was made, so that they say less of other
// pictures than as many independent ones.
std::vector<int> UnitsOf(const std::vector<std::string>& groups);

// Number of replicates, confidence level and seed of the bootstrap.
struct BootstrapOptions {
  int replicates = 2000;  // More make an interval's ends steadier, in proportion to its root.
  double confidence = 0.95;
  uint64_t seed = 1;  // The same gives the same intervals.
};

// A figure with the ends of its confidence interval.
struct Interval {
  double value = 0;
  double low = 0, high = 0;
};

// Returns the mean figure over the seeds; the figure of a seed is the quotient of its sums over
// images.
double MeanFigure(const FigureTable& table);

// Returns the figure with its confidence interval. Errors: kInvalidArgument if the table is empty
// or its rows differ in length.
absl::StatusOr<Interval> BootstrapFigure(const FigureTable& table, const BootstrapOptions& options);

enum class Verdict { kBetter, kWorse, kNotSignificant };
std::string VerdictName(Verdict verdict);  // "better", "worse", "not significant"

// Variances of a paired difference, by source: of the mean of S seeds and I images,
// seeds / S + images / I + rest / (S I).   Source: two-way analysis of variance with random effects
// and one observation a cell.
struct DifferenceSpread {
  double seeds = 0, images = 0, rest = 0;
  // Degrees of freedom of the images' spread over I - 1: less than 1 where their weights differ.
  double degrees_share = 1;
  // Length of intervals over that of the model above: where the images' weights differ, a replicate
  // may lack those that weigh most.
  double widened = 1;
};

// Returns the least difference that is significant in 80 of 100 repetitions of a comparison with
// these numbers of seeds and images; nothing for fewer than two of either, whose spread is unknown.
// Source: Cohen, "Statistical power analysis for the behavioral sciences", 2nd ed., 2.
std::optional<double> LeastDifference(const DifferenceSpread& spread, int seeds, int images,
                                      double confidence);

// The difference of two rows.
struct Comparison {
  Interval difference;  // Interval of a - b; below 0: a is better, because all figures are errors.
  Verdict verdict = Verdict::kNotSignificant;
  int seeds = 0, images = 0;
  // Whether S is 1 although the figures depend on a seed: nothing can be told then.
  bool seeds_spread_unknown = false;
  // For kNotSignificant: seeds to add until a difference of this size would be significant, if at
  // most kMostSeeds; absent when more seeds alone would not do, or their spread is unknown.
  std::optional<int> more_seeds;
  DifferenceSpread spread;
  std::optional<double> least_difference;  // LeastDifference of this comparison.
};

inline constexpr int kMostSeeds = 1000;

// Compares two predictors. `a` and `b` have the same seeds and images, in the same order. `seeded`
// says whether either depends on a seed; if not (two classical methods, or files), the images alone
// decide. Errors: those of BootstrapFigure; kInvalidArgument if the tables differ in shape.
absl::StatusOr<Comparison> ComparePaired(const FigureTable& a, const FigureTable& b, bool seeded,
                                         const BootstrapOptions& options);

// Returns the value that Student's t with `degrees` > 0 (not necessarily whole) exceeds with
// probability 1 - `probability`, for probabilities in [0.5, 1).
double StudentQuantile(double probability, double degrees);

}  // namespace parallax
