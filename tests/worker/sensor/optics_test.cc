#include "worker/sensor/optics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace parallax {
namespace {

constexpr int kSide = 65, kMiddle = 32;

ImageF3 Spark() {
  ImageF3 picture(kSide, kSide);
  for (int c = 0; c < 3; ++c) picture(kMiddle, kMiddle, c) = 1;
  return picture;
}

double Total(const ImageF3& picture, int channel = 1) {
  double sum = 0;
  for (size_t i = 0; i < picture.pixels(); ++i) {
    sum += double{picture.values()[3 * i + static_cast<size_t>(channel)]};
  }
  return sum;
}

// Mean square distance from the middle along x.
double SecondMoment(const ImageF3& picture) {
  double sum = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      sum += double{picture(x, y, 1)} * (x - kMiddle) * (x - kMiddle);
    }
  }
  return sum / Total(picture);
}

TEST(SpreadPoints, HasTheConfiguredWidthAndKeepsTheLight) {
  for (const double sigma : {0.35, 0.5, 1.0, 2.5}) {
    ImageF3 picture = Spark();
    SpreadPoints(sigma, picture);
    EXPECT_NEAR(Total(picture), 1, 1e-4) << sigma;
    EXPECT_NEAR(std::sqrt(SecondMoment(picture)), sigma, 0.002 * sigma) << sigma;
  }
  ImageF3 same = Spark();
  SpreadPoints(0, same);
  EXPECT_EQ(same, Spark());
}

TEST(CircleOfConfusion, FollowsTheThinLens) {
  EXPECT_DOUBLE_EQ(CircleOfConfusion(4, 2, 2), 0);
  EXPECT_DOUBLE_EQ(CircleOfConfusion(4, 2, 0), 4) << "sky";
  EXPECT_DOUBLE_EQ(CircleOfConfusion(4, 2, 4), 2);
  EXPECT_DOUBLE_EQ(CircleOfConfusion(4, 2, 1), 4) << "nearer than the focus";
  EXPECT_NEAR(CircleOfConfusion(4, 2, 1e9), 4, 1e-6);
}

TEST(Defocus, SpreadsOverTheCircleOfItsDepth) {
  // A disk of diameter d has the second moment d^2 / 16 along a line.
  for (const double diameter : {3.0, 6.0, 13.0}) {
    ImageF3 picture = Spark();
    Defocus(diameter, 2, ImageF(kSide, kSide, 0.0f), picture);
    EXPECT_NEAR(Total(picture), 1, 1e-3) << diameter;
    EXPECT_NEAR(4 * std::sqrt(SecondMoment(picture)), diameter, 0.12 * diameter + 0.3) << diameter;
  }
  ImageF3 sharp = Spark();
  Defocus(8, 2, ImageF(kSide, kSide, 2.0f), sharp);
  for (size_t i = 0; i < sharp.values().size(); ++i) {
    EXPECT_NEAR(sharp.values()[i], Spark().values()[i], 1e-6f);
  }
}

TEST(Vignette, TakesItsShareFromTheCorners) {
  ImageF3 picture(200, 100, 1.0f);
  Vignette(0.4, picture);
  EXPECT_NEAR(picture(0, 0), 0.6, 0.01);
  EXPECT_NEAR(picture(199, 99, 2), 0.6, 0.01);
  EXPECT_NEAR(picture(100, 50), 1, 1e-3);
  EXPECT_LT(picture(0, 50), picture(50, 50));
}

}  // namespace
}  // namespace parallax
