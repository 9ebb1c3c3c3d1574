// Compares the draws of dry scenes (solved, not rendered) with the distributions of their configs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace parallax {

struct DistributionRow {
  std::string quantity;
  std::string configured;
  int64_t samples = 0;
  double mean = 0, expected_mean = 0;
  double statistic = 0;  // Kolmogorov-Smirnov's D.
  double p = 1;          // Chance of a D as large or larger; conservative for discrete quantities.
};

// Solves `scenes` rooms and as many keyframes of dense scenes. Rooms have few, small things in
// them, so that a scene takes milliseconds; the draws are those of any scene. `first_seed` + i is
// the seed of scene i.
std::vector<DistributionRow> CheckDistributions(int scenes, uint64_t first_seed);

}  // namespace parallax
