#include "common/base/edit_distance.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(EditDistance, CountsTheLettersThatMustChange) {
  const struct {
    const char* a;
    const char* b;
    size_t distance;
  } cases[] = {
      {"", "", 0},          {"chair", "chair", 0},  {"", "chair", 5},      {"chair", "", 5},
      {"chair", "char", 1}, {"chair", "chairs", 1}, {"chair", "choir", 1}, {"kitten", "sitting", 3},
      {"sofa", "Sofa", 1},  {"ab", "ba", 2},        {"flaw", "lawn", 2},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(EditDistance(c.a, c.b), c.distance) << c.a << " " << c.b;
    EXPECT_EQ(EditDistance(c.b, c.a), c.distance) << c.b << " " << c.a;
  }
}

TEST(EditDistance, CaseCountsOnlyWhereAsked) {
  EXPECT_EQ(EditDistance("TVStand", "tvstand"), 3u);
  EXPECT_EQ(EditDistance("TVStand", "tvstand", true), 0u);
  EXPECT_EQ(EditDistance("TVStamd", "tvstand", true), 1u);
  EXPECT_EQ(EditDistance("a[", "A{", true), 1u);  // 32 apart, but no letters.
}

}  // namespace
}  // namespace parallax
