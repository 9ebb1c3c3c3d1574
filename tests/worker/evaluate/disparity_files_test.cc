#include "worker/evaluate/disparity_files.h"

#include <gmock/gmock.h>

#include <cstring>

#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/visibility.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

ImageF Ramp() {
  ImageF image(5, 3);
  for (size_t i = 0; i < image.pixels(); ++i) image.values()[i] = 1.25f + static_cast<float>(i);
  return image;
}

TEST(DisparityFiles, AllEncodingsReadAlike) {
  const TestTree tree;
  tree.Pfm("a.pfm", Ramp());
  tree.Npy("a.npy", Ramp());
  tree.Png16("a.png", Ramp());
  ASSERT_TRUE(WriteExrY(tree.Path("a.exr"), Ramp()).ok());
  for (const char* name : {"a.pfm", "a.npy", "a.png", "a.exr"}) {
    const auto read = ReadDisparity(tree.Path(name));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(*read, Ramp()) << name;
  }
  EXPECT_FALSE(ReadDisparity(tree.Path("a.txt")).ok());
}

TEST(DisparityFiles, TruthIsKnownWhereFinitePositiveAndBelowTheLimit) {
  const TestTree tree;
  tree.Pfm("a.pfm", Row({kInf, kNan, -kInf, -1, 0, 0.25f, 999, 1000, 5000}));
  const auto truth = ReadTruth(tree.Path("a.pfm"));
  ASSERT_TRUE(truth.ok()) << truth.status();
  EXPECT_EQ(*truth, Row({0, 0, 0, 0, 0, 0.25f, 999, 0, 0}));
  tree.Png16("a.png", Row({kNan, 3}));
  EXPECT_EQ(*ReadTruth(tree.Path("a.png")), Row({0, 3}));
  EXPECT_TRUE(std::isnan((*ReadDisparity(tree.Path("a.png")))(0, 0)));
}

TEST(DisparityFiles, BrokenArraysAreRefused) {
  const std::string good = EncodeNpy(Ramp());
  ASSERT_TRUE(DecodeNpy(good).ok());
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string bytes = good;
    bytes.replace(bytes.find(from), from.size(), to);
    return bytes;
  };
  const struct {
    std::string bytes;
    const char* wanted;
  } cases[] = {{"", "other bytes"},
               {"PNG or something else", "other bytes"},
               {good.substr(0, 40), "ends early"},
               {good.substr(0, good.size() - 1), "ends early"},
               {replaced("<f4", "<i4"), "type"},
               {replaced("<f4", ">f4"), "type"},
               {replaced("False", "True "), "Fortran"},
               {replaced("(3, 5)", "(3, )5"), "shape"},
               {replaced("(3, 5)", "(0, 5)"), "shape"}};
  for (const auto& c : cases) {
    const auto read = DecodeNpy(c.bytes);
    EXPECT_THAT(std::string(read.status().message()), HasSubstr(c.wanted)) << c.bytes.substr(0, 80);
  }
}

TEST(DisparityFiles, DoublesReadAsFloats) {
  std::string bytes = EncodeNpy(Row({1.5f}));
  bytes.replace(bytes.find("<f4"), 3, "<f8");
  bytes.resize(bytes.size() - 4);
  const double value = 2.75;
  bytes.append(reinterpret_cast<const char*>(&value), 8);
  const auto read = DecodeNpy(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, Row({2.75f}));
}

TEST(DisparityFiles, PngHoldsSteps256thAndMarksMissing) {
  const TestTree tree;
  const auto png = EncodeDisparityPng(Row({1.5f, kNan, -2, 0, 0.0001f, 300}));
  ASSERT_TRUE(png.ok());
  const auto back = DecodePngU16(*png);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->values(), (std::vector<uint16_t>{384, 0, 0, 0, 1, 65535}));
}

TEST(DisparityFiles, SubsamplingTakesEveryFourthPixelAndDividesByFour) {
  ImageF full(9, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 9; ++x) full(x, y) = static_cast<float>(100 * y + 4 * x);
  }
  const ImageF small = SubsampleDisparity(full, 4);
  ASSERT_EQ(small.width(), 3);
  ASSERT_EQ(small.height(), 2);
  EXPECT_EQ(small.values(), (std::vector<float>{0, 4, 8, 100, 104, 108}));
}

// ---- Visibility

TEST(Visibility, AgreesWithMiddleburysRule) {
  // Right view: x = 0..5 with disparities.
  const ImageF right = Row({2, 2, 5, 0, 3, 3});
  //                          x1:   -2  -1.5    0     1      2       4(unknown 3?)
  const ImageF left = Row({2, 2.5f, 2, 2, 2, 0});
  const ImageU8 mask = VisibilityMask(left, right);
  // 0: x1 = -2, outside. 1: -1.5 -> -2, outside. 2: x1 = 0, |2 - 2|. 3: x1 = 1. 4: x1 = 2, |2 - 5|.
  EXPECT_EQ(mask.values(), (std::vector<uint8_t>{128, 128, 255, 255, 128, 0}));
}

TEST(Visibility, RoundsHalvesAwayFromZeroAndToleratesExactlyThreshold) {
  // x1 of x = 3: 3 - 1.5 = 1.5 -> 2, where the right view has 2.5: |1.5 - 2.5| = 1, still visible.
  EXPECT_EQ(VisibilityMask(Row({0, 0, 0, 1.5f}), Row({9, 9, 2.5f, 9}))(3, 0), 255);
  EXPECT_EQ(VisibilityMask(Row({0, 0, 0, 1.5f}), Row({9, 9, 2.51f, 9}))(3, 0), 128);
  // The right view knows nothing there.
  EXPECT_EQ(VisibilityMask(Row({0, 0, 0, 1.5f}), Row({9, 9, 0, 9}))(3, 0), 128);
}

}  // namespace
}  // namespace parallax
