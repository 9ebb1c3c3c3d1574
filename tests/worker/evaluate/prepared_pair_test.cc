#include "worker/evaluate/prepared_pair.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>

#include "common/image/picture_pair.h"
#include "tests/worker/evaluate/test_tree.h"

namespace parallax {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kWidth = 160, kHeight = 60, kDisparity_px = 13;

uint8_t Texture(int x, int y) {
  const double v = std::sin(0.37 * x) + std::sin(0.23 * y + 0.11 * x) + std::sin(0.013 * x * y);
  return static_cast<uint8_t>(127 + 40 * v);
}

// The view of an eye that stands `shift_px` to the right.
ImageRgb8 View(int shift_px) {
  ImageRgb8 image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = Texture(x + shift_px, y);
    }
  }
  return image;
}

BenchmarkPair PairOf(const TestTree& tree, const ImageRgb8& left, const ImageRgb8& right,
                     const ImageF& truth_px) {
  EXPECT_TRUE(WritePng(tree.Path("l.png"), left).ok());
  EXPECT_TRUE(WritePng(tree.Path("r.png"), right).ok());
  return {.name = "pair7",
          .left = tree.Path("l.png"),
          .right = tree.Path("r.png"),
          .read_truth = [truth_px]() -> absl::StatusOr<PairTruth> {
            return PairTruth{.disparity_px = truth_px};
          }};
}

absl::StatusOr<PreparedPair> Checked(const ImageRgb8& left, const ImageRgb8& right,
                                     const ImageF& truth_px) {
  const TestTree tree;
  return PreparePair(PairOf(tree, left, right, truth_px), tree.dir() + "/stem",
                     PairCheck::kPicturesAndTruth);
}

TEST(PreparedPair, SwappedEyesAreNoted) {
  const ImageF truth_px(kWidth, kHeight, float{kDisparity_px});
  const auto right = Checked(View(0), View(kDisparity_px), truth_px);
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_TRUE(right->notes.empty()) << right->notes[0];
  const auto swapped = Checked(View(kDisparity_px), View(0), truth_px);
  ASSERT_TRUE(swapped.ok()) << swapped.status();
  ASSERT_EQ(swapped->notes.size(), 1u);
  EXPECT_THAT(swapped->notes[0], HasSubstr("pair pair7: its pictures look swapped"));
  const auto same = Checked(View(0), View(0), truth_px);
  ASSERT_TRUE(same.ok()) << same.status();
  EXPECT_THAT(same->notes, ElementsAre("pair pair7: its two pictures are the same"));
  // Truth that fits neither way says nothing of the eyes.
  const auto other = Checked(View(0), View(29), truth_px);
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_TRUE(other->notes.empty()) << other->notes[0];
}

TEST(PreparedPair, TruthOfAnotherScaleIsNoted) {
  for (const int steps : {16, 64, 100, 512}) {
    const ImageF read_px(kWidth, kHeight, kDisparity_px * static_cast<float>(steps) / 256.0f);
    const auto pair = Checked(View(0), View(kDisparity_px), read_px);
    ASSERT_TRUE(pair.ok()) << pair.status();
    EXPECT_THAT(pair->notes, Contains(AllOf(HasSubstr("its truth looks wrongly scaled"),
                                            HasSubstr(fmt::format("`scale: {}`", steps)))))
        << steps;
  }
  // Pictures that match nowhere say nothing of the scale.
  const auto other = Checked(View(0), View(29), ImageF(kWidth, kHeight, 9.0f));
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_TRUE(other->notes.empty()) << other->notes[0];
}

TEST(PreparedPair, DisparitiesNearZeroAreNoted) {
  const auto pair = Checked(View(0), View(29), ImageF(kWidth, kHeight, 1.5f));
  ASSERT_TRUE(pair.ok()) << pair.status();
  ASSERT_EQ(pair->notes.size(), 1u);
  EXPECT_THAT(pair->notes[0], HasSubstr("its largest disparity is 1.5 px, less than 1 % of the "
                                        "width of 160 px: a wrong scale?"));
}

TEST(PreparedPair, PicturesAndTruthOfTwoSizesAreRefusedBeforeAnythingIsPredicted) {
  EXPECT_THAT(std::string(Checked(View(0), View(0), ImageF(kWidth, 2, 9.0f)).status().message()),
              HasSubstr("pair pair7: truth of 160x2 for pictures of 160x60"));
  EXPECT_THAT(
      std::string(
          Checked(View(0), ImageRgb8(3, 2), ImageF(kWidth, kHeight, 9.0f)).status().message()),
      HasSubstr("r.png: 3x2, but "));
}

TEST(PreparedPair, OnlyFilesOfFewBitsAreWrittenAnew) {
  const TestTree tree;
  const BenchmarkPair plain = PairOf(tree, View(0), View(3), {});
  const auto as_it_is = PreparePair(plain, tree.dir() + "/stem", PairCheck::kNothing);
  ASSERT_TRUE(as_it_is.ok()) << as_it_is.status();
  EXPECT_EQ(as_it_is->left, plain.left);
  BenchmarkPair deep = plain;
  for (std::string* path : {&deep.left, &deep.right}) {
    *path = tree.Path(path == &deep.left ? "l16.png" : "r16.png");
    ImageU16 image(kWidth, kHeight);
    for (size_t i = 0; i < image.pixels(); ++i) {
      const int x = static_cast<int>(i) % kWidth, y = static_cast<int>(i) / kWidth;
      image.values()[i] = static_cast<uint16_t>(Texture(x, y) * 16);
    }
    ASSERT_TRUE(WritePng(*path, image).ok());
  }
  const auto prepared = PreparePair(deep, tree.dir() + "/stem", PairCheck::kNothing);
  ASSERT_TRUE(prepared.ok()) << prepared.status();
  EXPECT_EQ(prepared->left, tree.dir() + "/stem_left.png");
  EXPECT_EQ(prepared->notes.size(), 2u);
  const auto left = ReadPngRgb8(prepared->left);
  ASSERT_TRUE(left.ok()) << left.status();
  int brightest = 0;
  for (const uint8_t value : left->values()) brightest = std::max<int>(brightest, value);
  EXPECT_EQ(brightest, 255);
}

}  // namespace
}  // namespace parallax
