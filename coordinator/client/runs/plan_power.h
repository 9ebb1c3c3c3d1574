// Says before a study is paid for which differences between two variants are significant on each
// of its benchmarks. Reads files; thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/runs/plan.h"
#include "parallax/v1/study.pb.h"
#include "worker/evaluate/statistics.h"

namespace parallax::client {

// Looks at the study's own benchmarks that are on this machine: their number of pairs, no more than
// the study's max_pairs, and the size of their first picture, by name. Errors: those of
// OpenOwnBenchmark and of reading the picture.
absl::StatusOr<BenchmarkSizes> SizesOfOwnBenchmarks(const v1::StudySpec& study);

// How differences between trainings spread on a benchmark.
struct MeasuredSpread {
  DifferenceSpread spread;
  std::string metric;  // The figure that verdicts are by: "bad-2 all".
  int units = 0;       // Pairs, or groups of them, of the scores.
};
using MeasuredSpreads = std::map<std::string, MeasuredSpread>;  // By benchmark.

// Returns the mean spread of the differences between trainings that the scores in a dataset show.
// The study says with which reference they are compared, how means weigh pairs, and whether the log
// error decides; a search's figure is bad-2. Empty for a folder without scores of two seeds.
// Errors: those of reading scores and of MakeTable.
absl::StatusOr<MeasuredSpreads> ReadSpreads(const std::string& dir, const v1::StudySpec& study);

struct BenchmarkPower {
  std::string benchmark;
  int64_t pairs = 0;
  std::string metric;           // The scores' figure, or "bad-2" of the project's own spread.
  double least_difference = 0;  // In the metric's unit, in 80 of 100 repetitions at 95 %.
  bool measured_here = false;   // From the spreads given, not from the project's own.
};

// Returns what the study's number of seeds, or `seeds` if that is not 0, finds on each benchmark of
// at least two pairs; empty below two seeds.
std::vector<BenchmarkPower> PowerOf(const v1::StudySpec& study, const BenchmarkSizes& own,
                                    const MeasuredSpreads& spreads, int seeds = 0);

}  // namespace parallax::client
