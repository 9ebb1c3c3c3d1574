#include "common/base/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace parallax {
namespace {

// Source: Random123 1.14, tests/kat_vectors, lines "philox4x32 10".
TEST(Philox, MatchesPublishedVectors) {
  const struct {
    PhiloxCounter counter;
    PhiloxKey key;
    PhiloxCounter want;
  } cases[] = {
      {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
      {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
       {0xffffffff, 0xffffffff},
       {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
      {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
       {0xa4093822, 0x299f31d0},
       {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
  };
  for (const auto& c : cases) EXPECT_EQ(Philox4x32(c.counter, c.key), c.want);
}

TEST(Rng, ChildDoesNotDependOnWhatWasDrawn) {
  Rng fresh(SceneSeed{7}, "scene");
  Rng used = fresh;
  for (int i = 0; i < 100; ++i) used.Bits32();
  EXPECT_EQ(fresh.Child("floating", 3).Bits64(), used.Child("floating", 3).Bits64());
}

TEST(Rng, AddressesGiveDifferentStreams) {
  std::set<uint64_t> first_words;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    for (const char* path : {"", "scene", "scene/walls"}) {
      first_words.insert(Rng(SceneSeed{seed}, path).Bits64());
      first_words.insert(Rng(SceneSeed{seed}, path).Child("a").Bits64());
    }
  }
  EXPECT_EQ(first_words.size(), 60u);
}

TEST(Rng, DrawsHaveTheirMoments) {
  Rng rng(SceneSeed{1}, "moments");
  double sum = 0, normal_sum = 0, normal_squares = 0;
  int counts[3] = {};
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = rng.Uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    const double n = rng.Normal();
    normal_sum += n;
    normal_squares += n * n;
    ++counts[rng.UniformInt(-1, 1) + 1];
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 0.005);
  EXPECT_NEAR(normal_sum / kDraws, 0.0, 0.015);
  EXPECT_NEAR(normal_squares / kDraws, 1.0, 0.02);
  for (int count : counts) EXPECT_NEAR(count, kDraws / 3.0, 600);
}

}  // namespace
}  // namespace parallax
