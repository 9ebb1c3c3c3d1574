#include "coordinator/stream/stream_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

namespace parallax {
namespace {

v1::StudySpec Stream(int64_t chunk_pairs, int rigs, const std::vector<std::string>& variants) {
  v1::StudySpec study;
  study.set_name("drive");
  study.set_seed(7);
  study.set_rigs_per_scene(rigs);
  study.mutable_stream()->set_chunk_pairs(chunk_pairs);
  for (const std::string& name : variants) study.add_variants()->set_name(name);
  return study;
}

void AddShare(v1::StudySpec& study, const std::string& variant, double weight, int64_t from = 0,
              int64_t until = 0) {
  v1::StreamShare& share = *study.mutable_stream()->add_mix();
  share.set_variant(variant);
  share.set_weight(weight);
  share.set_from_pair(from);
  if (until > 0) share.set_until_pair(until);
}

TEST(StreamOrderTest, AChunkHasAllItsPairsInWholeScenesButOne) {
  const v1::StudySpec study = Stream(70, 20, {"a", "b", "c"});
  for (int64_t chunk = 0; chunk < 200; ++chunk) {
    const std::vector<int64_t> pairs = PairsOfChunk(study, chunk);
    EXPECT_EQ(std::accumulate(pairs.begin(), pairs.end(), int64_t{0}), 70) << chunk;
    int partial = 0;
    for (const int64_t n : pairs) {
      EXPECT_GE(n, 0);
      partial += n % 20 != 0;
    }
    EXPECT_EQ(partial, 1) << chunk;
  }
}

TEST(StreamOrderTest, SharesAreThoseOfTheMix) {
  v1::StudySpec study = Stream(100, 20, {"a", "b", "c", "d"});
  AddShare(study, "a", 1);
  AddShare(study, "b", 6);
  AddShare(study, "c", 3);
  std::vector<int64_t> sums(4, 0);
  for (int64_t chunk = 0; chunk < 1000; ++chunk) {
    const std::vector<int64_t> pairs = PairsOfChunk(study, chunk);
    const double expected[] = {10, 60, 30, 0};
    for (size_t v = 0; v < 4; ++v) {
      sums[v] += pairs[v];
      EXPECT_LE(std::abs(static_cast<double>(pairs[v]) - expected[v]), 20) << chunk;
    }
  }
  EXPECT_NEAR(static_cast<double>(sums[0]), 10'000, 200);
  EXPECT_NEAR(static_cast<double>(sums[1]), 60'000, 200);
  EXPECT_NEAR(static_cast<double>(sums[2]), 30'000, 200);
  EXPECT_EQ(sums[3], 0);
}

TEST(StreamOrderTest, WithoutAMixAllVariantsHaveEqualParts) {
  const v1::StudySpec study = Stream(60, 20, {"a", "b", "c"});
  for (int64_t chunk = 0; chunk < 50; ++chunk) {
    EXPECT_THAT(PairsOfChunk(study, chunk), testing::ElementsAre(20, 20, 20)) << chunk;
  }
}

TEST(StreamOrderTest, ACurriculumChangesTheSharesAtItsPair) {
  v1::StudySpec study = Stream(40, 10, {"easy", "hard"});
  AddShare(study, "easy", 1, 0, 100);
  AddShare(study, "hard", 1, 100);
  EXPECT_THAT(PairsOfChunk(study, 0), testing::ElementsAre(40, 0));
  EXPECT_THAT(PairsOfChunk(study, 1), testing::ElementsAre(40, 0));
  const std::vector<int64_t> change = PairsOfChunk(study, 2);  // Half of it is before pair 100.
  EXPECT_EQ(change[0] + change[1], 40);
  EXPECT_EQ(change[0], 20);
  EXPECT_THAT(PairsOfChunk(study, 3), testing::ElementsAre(0, 40));
}

TEST(StreamOrderTest, ChunksHaveSeedsOfTheirOwn) {
  const v1::StudySpec study = Stream(60, 20, {"a", "b", "c"});
  std::set<uint64_t> seeds;
  for (int64_t chunk = 0; chunk < 100; ++chunk) {
    const v1::StudySpec made = ChunkStudy(study, chunk);
    EXPECT_EQ(made.name(), "drive-" + std::to_string(chunk));
    EXPECT_FALSE(made.has_stream());
    for (const v1::VariantSpec& variant : made.variants()) seeds.insert(variant.seed());
  }
  EXPECT_EQ(seeds.size(), 300u);
  v1::StudySpec other = study;
  other.set_seed(8);
  EXPECT_EQ(seeds.count(ChunkStudy(other, 0).variants(0).seed()), 0u);
  EXPECT_EQ(ChunkStudy(study, 5).SerializeAsString(), ChunkStudy(study, 5).SerializeAsString());
}

TEST(StreamOrderTest, AChunkTellsAllButItsEnd) {
  v1::StudySpec study = Stream(60, 20, {"a"});
  EXPECT_FALSE(ChunkStudy(study, 0).has_notify());
  study.mutable_notify()->set_url("http://host/");
  EXPECT_THAT(ChunkStudy(study, 0).notify().on(),
              testing::ElementsAre("failed", "stalled", "waits"));
  study.mutable_notify()->add_on("done");
  study.mutable_notify()->add_on("waits");
  EXPECT_THAT(ChunkStudy(study, 0).notify().on(), testing::ElementsAre("waits"));
}

TEST(StreamOrderTest, ARoundIsAPermutationOfItsOwn) {
  const v1::StudySpec study = Stream(60, 20, {"a"});
  const std::vector<uint32_t> first = OrderOfRound(study, 0, 60);
  EXPECT_EQ(std::set<uint32_t>(first.begin(), first.end()).size(), 60u);
  EXPECT_EQ(first, OrderOfRound(study, 0, 60));
  EXPECT_NE(first, OrderOfRound(study, 1, 60));
}

TEST(StreamOrderTest, WithUsesARoundHasTheChunksBefore) {
  v1::StudySpec study = Stream(60, 20, {"a"});
  EXPECT_EQ(ChunksOfRound(study, 3), std::pair(int64_t{3}, int64_t{3}));
  study.mutable_stream()->set_uses(3);
  EXPECT_EQ(ChunksOfRound(study, 0), std::pair(int64_t{0}, int64_t{0}));
  EXPECT_EQ(ChunksOfRound(study, 5), std::pair(int64_t{3}, int64_t{5}));
}

TEST(StreamOrderTest, APositionIsPackedInOrder) {
  const StreamPosition position{.round = 5, .place = 7};
  EXPECT_EQ(position.Packed(), (uint64_t{5} << 32) + 7);
  EXPECT_EQ(StreamPosition::Of(position.Packed()).round, 5);
  EXPECT_EQ(StreamPosition::Of(position.Packed()).place, 7u);
  EXPECT_LT((StreamPosition{4, 4'000'000'000u}).Packed(), (StreamPosition{5, 0}).Packed());
}

}  // namespace
}  // namespace parallax
