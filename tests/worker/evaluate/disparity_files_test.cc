#include "worker/evaluate/disparity_files.h"

#include <gmock/gmock.h>

#include <cmath>
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
               {good + "x", "bytes follow its last value"},
               {replaced("<f4", "<c8"), "type"},
               {replaced("<f4", "<i4"), "scale: N"},
               {replaced("(3, 5)", "(3, )5"), "shape"},
               {replaced("(3, 5)", "(15,) "), "shape"},
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

// An array of 2 x 3 whose header is NumPy's, with these bytes of values.
std::string NpyOf(const std::string& type, const std::string& order, const std::string& shape,
                  const std::string& values) {
  const std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header +
         values;
}

TEST(DisparityFiles, ArraysOfOtherTypesOrdersAndShapesAreRead) {
  using std::string_literals::operator""s;
  ImageF wanted(3, 2);
  wanted.values() = {1, 1.5f, 2, 3, 4, 0.25f};
  const std::string halves = "\x00\x3c\x00\x3e\x00\x40\x00\x42\x00\x44\x00\x34"s;
  const std::string big = "\x3f\x80\0\0\x3f\xc0\0\0\x40\0\0\0\x40\x40\0\0\x40\x80\0\0\x3e\x80\0\0"s;
  const std::string by_columns = "\x00\x3c\x00\x42\x00\x3e\x00\x44\x00\x40\x00\x34"s;
  const std::string cases[] = {
      NpyOf("<f2", "False", "(2, 3)", halves), NpyOf("<f2", "False", "(2, 3, 1)", halves),
      NpyOf("<f2", "False", "(1, 2, 3)", halves), NpyOf(">f4", "False", "(2, 3)", big),
      NpyOf("<f2", "True", "(2, 3)", by_columns)};
  for (const std::string& bytes : cases) {
    const auto read = DecodeNpy(bytes);
    ASSERT_TRUE(read.ok()) << bytes.substr(10, 70) << read.status();
    EXPECT_EQ(*read, wanted) << bytes.substr(10, 70);
  }
  const auto special = DecodeNpy(NpyOf("<f2", "False", "(1, 3)", "\x00\x7c\x00\xfe\x01\x00"s));
  ASSERT_TRUE(special.ok()) << special.status();
  EXPECT_EQ((*special)(0, 0), kInf);
  EXPECT_TRUE(std::isnan((*special)(1, 0)));
  EXPECT_EQ((*special)(2, 0), std::ldexp(1.0f, -24));  // The smallest half.
  // Whole numbers say nothing of their scale.
  const std::string steps = NpyOf("<i2", "False", "(1, 3)", "\x10\x00\xf0\xff\x00\x00"s);
  const auto scaled = DecodeNpy(steps, 16);
  ASSERT_TRUE(scaled.ok()) << scaled.status();
  EXPECT_EQ((*scaled)(0, 0), 1);
  EXPECT_EQ((*scaled)(1, 0), -1);
  EXPECT_TRUE(std::isnan((*scaled)(2, 0)));
  EXPECT_FALSE(DecodeNpy(steps).ok());
}

TEST(DisparityFiles, PngsOf24And8BitsAreRead) {
  const TestTree tree;
  // 100.5 px as FoundationStereo's digits: 100500 = 1 * 65025 + 139 * 255 + 30.
  ImageRgb8 digits(2, 1);
  digits.values() = {1, 139, 30, 0, 0, 0};
  ASSERT_TRUE(WritePng(tree.Path("fsd.png"), digits).ok());
  const auto read = ReadDisparity(tree.Path("fsd.png"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_FLOAT_EQ((*read)(0, 0), 100.5f);
  EXPECT_TRUE(std::isnan((*read)(1, 0)));
  // Middlebury 2003: four grey levels a pixel, and once more as R G B.
  ASSERT_TRUE(WritePng(tree.Path("grey.png"), RowU8({40, 0, 255})).ok());
  ImageRgb8 thrice(3, 1);
  thrice.values() = {40, 40, 40, 0, 0, 0, 255, 255, 255};
  ASSERT_TRUE(WritePng(tree.Path("thrice.png"), thrice).ok());
  for (const char* name : {"grey.png", "thrice.png"}) {
    EXPECT_EQ(*ReadTruth(tree.Path(name), 4), Row({10, 0, 63.75f})) << name;
    EXPECT_THAT(std::string(ReadTruth(tree.Path(name)).status().message()),
                HasSubstr(std::string(name) + ": 8-bit grey levels, which do not say their scale"));
  }
  // A scale that is given counts for every encoding.
  tree.Png16("deep.png", Row({3, 5}), 64);
  EXPECT_EQ(*ReadTruth(tree.Path("deep.png"), 64), Row({3, 5}));
  tree.Pfm("steps.pfm", Row({300, 500}));
  EXPECT_EQ(*ReadTruth(tree.Path("steps.pfm"), 100), Row({3, 5}));
}

TEST(DisparityFiles, ColoursForPeopleAreNoDigits) {
  const TestTree tree;
  ImageRgb8 colours(2, 1);
  for (const auto& values :
       {std::vector<uint8_t>{0, 0, 128, 0, 255, 20}, std::vector<uint8_t>{0, 10, 255, 128, 0, 0}}) {
    colours.values() = values;
    ASSERT_TRUE(WritePng(tree.Path("jet.png"), colours).ok());
    EXPECT_THAT(std::string(ReadTruth(tree.Path("jet.png")).status().message()),
                HasSubstr("jet.png: 8-bit colours, no digits to the base 255"));
  }
}

TEST(DisparityFiles, MasksAreGreyInWhateverPng) {
  const TestTree tree;
  ImageRgb8 grey(3, 1), coloured(3, 1, 7);
  grey.values() = {0, 0, 0, 128, 128, 128, 255, 255, 255};
  coloured.values()[1] = 8;
  ASSERT_TRUE(WritePng(tree.Path("grey.png"), grey).ok());
  ASSERT_TRUE(WritePng(tree.Path("coloured.png"), coloured).ok());
  tree.Png16("deep.png", Row({1, 2, 3}));
  const auto mask = ReadMask(tree.Path("grey.png"));
  ASSERT_TRUE(mask.ok()) << mask.status();
  EXPECT_EQ(*mask, RowU8({0, 128, 255}));
  EXPECT_THAT(std::string(ReadMask(tree.Path("coloured.png")).status().message()),
              HasSubstr("coloured.png: a mask in colours"));
  EXPECT_THAT(std::string(ReadMask(tree.Path("deep.png")).status().message()),
              HasSubstr("deep.png: a mask is a PNG of at most 8 bits"));
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
