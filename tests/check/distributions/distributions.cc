// distributions [SCENES] [FIRST_SEED]: a table of what 10,000 dry scenes draw against what their
// configs say, by Kolmogorov and Smirnov, and one JSON line. Exit status 1 when a p is below 1e-4.
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/check/distributions/dataset_distributions.h"

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 10000;
  const uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  bool fine = true;
  nlohmann::ordered_json json = {
      {"bench", "distributions"}, {"scenes", scenes}, {"first_seed", seed}};
  std::printf("%-42s %-52s %9s %10s %10s %8s %7s\n", "quantity", "configured", "samples", "mean",
              "expected", "D", "p");
  for (const auto& row : parallax::CheckDistributions(scenes, seed)) {
    std::printf("%-42s %-52s %9lld %10.4f %10.4f %8.5f %7.4f\n", row.quantity.c_str(),
                row.configured.c_str(), static_cast<long long>(row.samples), row.mean,
                row.expected_mean, row.statistic, row.p);
    json["p"][row.quantity] = row.p;
    fine = fine && row.p >= 1e-4;
  }
  std::printf("%s\n", json.dump().c_str());
  return fine ? 0 : 1;
}
