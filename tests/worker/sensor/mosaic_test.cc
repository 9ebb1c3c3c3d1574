#include "worker/sensor/mosaic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace parallax {
namespace {

TEST(Mosaic, PixelsSeeRedGreenBlueInTurn) {
  ImageF3 picture(4, 2);
  for (size_t i = 0; i < picture.values().size(); ++i) {
    picture.values()[i] = static_cast<float>(i % 3);
  }
  const ImageF mosaic = Mosaic(picture);
  const float expected[] = {0, 1, 0, 1, 1, 2, 1, 2};
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(mosaic.values()[i], expected[i]) << i;
}

TEST(Demosaic, GivesBackOneColourAtAnySize) {
  for (const auto& [width, height] : {std::pair(16, 9), {9, 16}, {5, 5}, {2, 2}, {1, 1}}) {
    ImageF3 picture(width, height);
    for (size_t i = 0; i < picture.values().size(); ++i) {
      picture.values()[i] = i % 3 == 0 ? 0.2f : i % 3 == 1 ? 0.5f : 0.9f;
    }
    const ImageF3 back = Demosaic(Mosaic(picture));
    // A single pixel has no neighbours of the other colours.
    for (size_t i = 0; width > 1 && i < picture.values().size(); ++i) {
      ASSERT_NEAR(back.values()[i], picture.values()[i], 1e-6f) << width << "x" << height;
    }
  }
}

// Its filters are exact for slopes that all colours share, away from the rim.
TEST(Demosaic, GivesBackGreySlopes) {
  ImageF3 picture(12, 12);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) {
      for (int c = 0; c < 3; ++c) picture(x, y, c) = 0.1f + 0.03f * static_cast<float>(x + 2 * y);
    }
  }
  const ImageF3 back = Demosaic(Mosaic(picture));
  for (int y = 2; y < 10; ++y) {
    for (int x = 2; x < 10; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(back(x, y, c), picture(x, y, c), 1e-5f);
    }
  }
}

// As in a real camera, neighbours of an edge in one colour get a wrong colour.
TEST(Demosaic, ColoursEdges) {
  ImageF3 picture(12, 12);
  for (int y = 0; y < 12; ++y) {
    for (int x = 6; x < 12; ++x) picture(x, y, 0) = 1;
  }
  const ImageF3 back = Demosaic(Mosaic(picture));
  float most = 0;
  for (int y = 2; y < 10; ++y) most = std::max(most, std::abs(back(6, y, 1)));
  EXPECT_GT(most, 0.05f);
}

}  // namespace
}  // namespace parallax
