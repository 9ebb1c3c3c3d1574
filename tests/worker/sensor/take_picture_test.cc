#include "worker/sensor/take_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "common/base/rng.h"
#include "worker/render/film/exposure.h"

namespace parallax {
namespace {

constexpr int kWidth = 96, kHeight = 64;
constexpr SensorAddress kLeft{SceneSeed{5}, 2, 0}, kRight{SceneSeed{5}, 2, 1};

// Smooth, with colours, from dark to brighter than white.
LinearView Scene() {
  LinearView view{ImageF3(kWidth, kHeight), ImageF(kWidth, kHeight, 3.0f)};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double wave = 1 + std::sin(0.1 * x + 0.07 * y * (c + 1));
        view.light(x, y, c) = static_cast<float>(0.02 + 0.3 * wave * wave);
      }
    }
  }
  return view;
}

double MeanSquare(const ImageRgb8& a, const ImageRgb8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.values().size(); ++i) {
    const double d = static_cast<double>(a.values()[i]) - static_cast<double>(b.values()[i]);
    sum += d * d;
  }
  return sum / static_cast<double>(a.values().size());
}

TEST(TakePicture, WithAllNumbersZeroIsTheRenderersOwn) {
  const auto picture = TakePicture({}, kLeft, Scene());
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(*picture, ToSrgb(Scene().light, 1));
}

TEST(TakePicture, DependsOnItsAddressAloneAndEachEyeHasItsOwnNoise) {
  SensorDraw draw;
  draw.white_e = 500;
  draw.read_noise_e = 4;
  draw.bayer = true;
  const ImageRgb8 left = *TakePicture(draw, kLeft, Scene());
  EXPECT_EQ(left, *TakePicture(draw, kLeft, Scene()));
  EXPECT_NE(left, *TakePicture(draw, kRight, Scene()));
  EXPECT_NE(left, *TakePicture(draw, {SceneSeed{6}, 2, 0}, Scene()));
  EXPECT_NE(left, *TakePicture(draw, {SceneSeed{5}, 3, 0}, Scene()));
}

TEST(TakePicture, ExposureAndWhiteBalanceAreEachEyesOwn) {
  SensorDraw draw;
  draw.exposure_ev = {0, 0.5};
  draw.red_ev = {0, -0.25};
  draw.blue_ev = {0, 0.125};
  LinearView brighter = Scene();
  const double gains[3] = {std::exp2(0.25), std::exp2(0.5), std::exp2(0.625)};
  for (size_t i = 0; i < brighter.light.values().size(); ++i) {
    brighter.light.values()[i] *= static_cast<float>(gains[i % 3]);
  }
  EXPECT_EQ(*TakePicture(draw, kLeft, Scene()), ToSrgb(Scene().light, 1));
  const ImageRgb8 expected = ToSrgb(brighter.light, 1), seen = *TakePicture(draw, kRight, Scene());
  for (size_t i = 0; i < seen.values().size(); ++i) {
    ASSERT_LE(std::abs(int{seen.values()[i]} - int{expected.values()[i]}), 1) << i;
  }
}

TEST(TakePicture, JpegLosesMoreTheLowerItsQuality) {
  SensorDraw draw;
  const ImageRgb8 plain = *TakePicture(draw, kLeft, Scene());
  draw.jpeg_quality = 95;
  const double good = MeanSquare(*TakePicture(draw, kLeft, Scene()), plain);
  draw.jpeg_quality = 20;
  const double bad = MeanSquare(*TakePicture(draw, kLeft, Scene()), plain);
  EXPECT_GT(good, 0);
  EXPECT_GT(bad, 1.5 * good);
  EXPECT_LT(bad, 100) << "still the same picture";
}

TEST(TakePicture, SaysWhatDefocusLacks) {
  SensorDraw draw;
  draw.defocus_px = 2;
  LinearView view = Scene();
  view.depth_m = ImageF();
  const auto status = TakePicture(draw, kLeft, view).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("0 x 0, wanted 96 x 64"));
  EXPECT_EQ(TakePicture({}, kLeft, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
