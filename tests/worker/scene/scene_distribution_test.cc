// The short form of tests/check/distributions.
#include <gtest/gtest.h>

#include "tests/check/distributions/dataset_distributions.h"

namespace parallax {
namespace {

TEST(Distributions, DryScenesDrawWhatTheirConfigsSay) {
  for (const DistributionRow& row : CheckDistributions(60, 1000)) {
    EXPECT_GE(row.samples, 30) << row.quantity;
    EXPECT_GE(row.p, 1e-4) << row.quantity << ": mean " << row.mean << ", configured "
                           << row.configured << " with mean " << row.expected_mean;
  }
}

}  // namespace
}  // namespace parallax
