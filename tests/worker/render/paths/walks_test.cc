#include "worker/render/paths/walks.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/base/rng.h"

namespace parallax {
namespace {

TEST(Walks, ThoseThatStayCloseUpInTheirOrder) {
  Rng rng(SceneSeed{1}, "who stays");
  struct Rows {
    Row<int32_t> number;
    Vec3Row place;
  };
  const auto rows = std::make_unique<Rows>();
  for (int round = 0; round < 400; ++round) {
    // None, few, many, all.
    const double chance = std::array{0.0, 0.1, 0.5, 0.97, 1.0}[static_cast<size_t>(round % 5)];
    const auto count = static_cast<size_t>(rng.UniformInt(0, kMostWalks));
    std::array<uint8_t, kMostBlocks> stays{};
    std::vector<int32_t> wanted;
    for (size_t walk = 0; walk < kMostWalks; ++walk) {
      const auto number = static_cast<int32_t>(1000 * round + static_cast<int>(walk));
      rows->number[walk] = number;
      rows->place.Set(walk, Vec3f(1, 2, 3) * static_cast<float>(number));
      if (walk >= count || rng.Uniform() >= chance) continue;
      stays[walk / kLanes] |= static_cast<uint8_t>(1u << walk % kLanes);
      wanted.push_back(number);
    }
    CompactRows(stays.data(), (count + kLanes - 1) / kLanes, rows.get());
    for (size_t k = 0; k < wanted.size(); ++k) {
      ASSERT_EQ(rows->number[k], wanted[k]) << "round " << round;
      ASSERT_EQ(rows->place[k], Vec3f(Vec3f(1, 2, 3) * static_cast<float>(wanted[k])));
    }
    for (size_t walk = (count + kLanes - 1) / kLanes * kLanes; walk < kMostWalks; ++walk) {
      ASSERT_EQ(rows->number[walk], 1000 * round + static_cast<int>(walk)) << "left alone";
    }
  }
}

TEST(Walks, RowsAreReadAndWrittenByEights) {
  Vec3Row row;
  for (size_t walk = 0; walk < kMostWalks; ++walk) {
    row.Set(walk, Vec3f(static_cast<float>(walk), 0.5f, -static_cast<float>(walk)));
  }
  EXPECT_EQ(row.At(3).Get(2), row[26]);
  Vec3x8 eight = row.At(5);
  row.PutFrom(13, eight);
  for (size_t k = 0; k < kLanes; ++k) EXPECT_EQ(row[13 + k], eight.Get(static_cast<int>(k)));
  EXPECT_EQ(row[12].x(), 12);
  EXPECT_EQ(row[21].x(), 21);
  row.Put(0, eight);
  EXPECT_EQ(row[7], eight.Get(7));
}

}  // namespace
}  // namespace parallax
