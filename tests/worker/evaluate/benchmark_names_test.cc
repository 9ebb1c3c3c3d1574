// The names that studies are checked against are those of the benchmarks and predictors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/catalogue_names.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/predictors/predictor.h"

namespace parallax {
namespace {

TEST(CatalogueNames, ListEveryBenchmarkThatNeedsNoPath) {
  std::vector<std::string> names;
  for (const BenchmarkKind& kind : BenchmarkKinds()) {
    if (!kind.takes_path) names.push_back(kind.name);
  }
  EXPECT_THAT(BenchmarkNames(), testing::UnorderedElementsAreArray(names));
}

TEST(CatalogueNames, ListEveryPredictorThatNeedsNoTraining) {
  EXPECT_THAT(BaselineNames(), testing::ElementsAre(MakeSgbmPredictor()->name()));
}

}  // namespace
}  // namespace parallax
