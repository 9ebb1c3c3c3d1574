// Pixels brighter than the display: found, sampled more at edges, kept from the denoiser.
#include "worker/render/film/overexposed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/worker/render/render_frame.h"
#include "worker/render/film/exposure.h"

namespace parallax {
namespace {

using test::DiffuseSample;
using test::MakeConfig;
using test::MakeQuad;
using test::RenderFrame;
using test::TestScene;

void Fill(ImageF3* image, int x0, int y0, int x1, int y1, float value) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) std::fill_n(image->At(x, y), 3, value);
  }
}

TEST(Overexposed, IsWhatHasBrightNeighboursNotSinglePixels) {
  ImageF3 image(20, 10, 1.0f);
  Fill(&image, 4, 3, 9, 8, 50.0f);
  Fill(&image, 14, 4, 15, 5, 900.0f);  // A firefly.
  Fill(&image, 17, 7, 19, 8, 900.0f);  // Two.
  const ImageU8 over = Overexposed(image, 0.5f);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 20; ++x) {
      EXPECT_EQ(over(x, y), x >= 4 && x < 9 && y >= 3 && y < 8) << x << " " << y;
    }
  }
  EXPECT_EQ(Overexposed(image, 0.05f).values(), ImageU8(20, 10).values());  // 2.5 is on display.
}

TEST(Overexposed, EdgesAreThePixelsOnBothSides) {
  ImageU8 over(12, 9);
  for (int y = 3; y < 7; ++y) {
    for (int x = 0; x < 6; ++x) over(x, y) = 1;
  }
  std::set<std::pair<int, int>> edges;
  for (const PixelAt& at : EdgesOf(over)) edges.insert({at.x, at.y});
  std::set<std::pair<int, int>> wanted;
  for (int y = 2; y < 8; ++y) {
    for (int x = 0; x < 7; ++x) {
      if (!(y > 3 && y < 6 && x < 5)) wanted.insert({x, y});
    }
  }
  EXPECT_EQ(edges, wanted);
}

TEST(Overexposed, ExcessAndRestAreThePicture) {
  ImageF3 image(8, 8, 0.25f);
  Fill(&image, 2, 2, 6, 6, 64.0f);
  image(3, 3, 2) = 0.5f;  // One channel is not.
  const ImageF3 whole = image;
  const ImageF3 excess = TakeExcess(Overexposed(image, 1.0f), 1.0f, &image);
  for (size_t i = 0; i < whole.values().size(); ++i) {
    EXPECT_EQ(image.values()[i] + excess.values()[i], whole.values()[i]);
    EXPECT_LE(image.values()[i], 3.0f);
    EXPECT_EQ(excess.values()[i] > 0, whole.values()[i] > 3.0f);
  }
}

// A row of shining panels, a few centimetres apart, before a grey wall.
StereoFrame RenderPanels(const v1::RenderConfig& config) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.4f)));
  test.AddMesh(MakeQuad({-3, 2, -2}, {6, 0, 0}, {0, 0, 4}), grey);
  for (int i = 0; i < 4; ++i) {
    const float x = -0.6f + 0.3f * static_cast<float>(i);
    test.AddMeshLight(
        test.AddMesh(MakeQuad({x, 1.5f, -0.1f}, {0.28f, 0, 0.03f}, {0, 0, 0.2f}), grey), 40);
  }
  test.AddPointLight({0, -1, 1.5}, 0.05, 1000);
  return RenderFrame(test, config, test::MakeRig({0, -0.5, 0}, {0, 1, 0}, 192, 144, 180, 0.1));
}

TEST(Overexposed, GapsBetweenLampsStayDarkAndTheirEdgesSharp) {
  const StereoFrame reference = RenderPanels(MakeConfig(512, 6, false));
  v1::RenderConfig few;  // As many as a large picture gets.
  few.set_samples_per_pixel(4);
  const StereoFrame frame = RenderPanels(few);
  ASSERT_EQ(
      *std::max_element(reference.left.color.values().begin(), reference.left.color.values().end()),
      255);
  const ImageRgb8 levels = ToSrgb(frame.left.radiance, reference.exposure);
  EXPECT_LT(test::MeanSquare(levels, reference.left.color), 5.4 * 5.4);
}

}  // namespace
}  // namespace parallax
