#include "coordinator/study/rigs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using testing::ElementsAre;

TEST(Rigs, TextGoesRoundTrip) {
  const struct {
    std::vector<uint32_t> rigs;
    const char* text;
  } cases[] = {
      {{}, ""}, {{0}, "0"}, {{0, 1}, "0-1"}, {{0, 1, 2, 3, 7}, "0-3,7"}, {{2, 4, 6, 7}, "2,4,6-7"}};
  for (const auto& c : cases) {
    EXPECT_EQ(RigsText(c.rigs), c.text);
    const auto parsed = ParseRigs(c.text);
    ASSERT_TRUE(parsed.ok()) << c.text;
    EXPECT_EQ(*parsed, c.rigs) << c.text;
  }
}

TEST(Rigs, WhatRigsTextDoesNotWriteIsRefused) {
  for (const char* text : {"a", "1-", "-1", "1,", ",1", "3-1", "1-1", "2,1", "1,1", "0-3,3", "1 2",
                           "99999999999", "200000"}) {
    EXPECT_EQ(ParseRigs(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(Rigs, RangeCountsFromItsFirst) { EXPECT_THAT(RigRange(4, 3), ElementsAre(4, 5, 6)); }

}  // namespace
}  // namespace parallax
