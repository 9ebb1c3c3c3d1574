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

// Looks at the study's own benchmarks that are on this machine: their number of pairs and the size
// of their first picture, by name. Errors: those of OpenOwnBenchmark and of reading the picture.
absl::StatusOr<BenchmarkSizes> SizesOfOwnBenchmarks(const v1::StudySpec& study);

// Returns the mean spread of the differences that the scores in a dataset show, by benchmark, where
// means weigh pairs as the study says; empty for a folder without scores of two seeds. Errors:
// those of reading scores and of MakeTable.
absl::StatusOr<std::map<std::string, DifferenceSpread>> ReadSpreads(const std::string& dir,
                                                                    const v1::StudySpec& study);

struct BenchmarkPower {
  std::string benchmark;
  int64_t pairs = 0;
  double least_difference = 0;  // In points of bad-2, in 80 of 100 repetitions at 95 %.
  bool measured_here = false;   // From the spreads given, not from the project's own.
};

// Returns what the study's number of seeds, or `seeds` if that is not 0, finds on each benchmark of
// at least two pairs; empty below two seeds.
std::vector<BenchmarkPower> PowerOf(const v1::StudySpec& study, const BenchmarkSizes& own,
                                    const std::map<std::string, DifferenceSpread>& spreads,
                                    int seeds = 0);

}  // namespace parallax::client
