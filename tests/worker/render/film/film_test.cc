// How a pixel's samples add up; and that the denoiser's guides are free of noise at edges.
#include "worker/render/film/film.h"

#include <gtest/gtest.h>

#include "tests/worker/render/render_frame.h"
#include "worker/render/film/exposure.h"

namespace parallax {
namespace {

using test::DiffuseSample;
using test::MakeConfig;
using test::MakeQuad;
using test::RenderFrame;
using test::TestScene;

PathResult Sample(float color, float albedo, const Vec3f& normal, float weight = 1) {
  PathResult path;
  path.radiance = Vec3f::Constant(color);
  path.albedo = Vec3f::Constant(albedo);
  path.normal = normal;
  path.guide_weight = weight;
  return path;
}

PixelSum Sum(std::initializer_list<PathResult> paths) {
  PixelSum sum;
  for (const PathResult& path : paths) sum.Add(path);
  return sum;
}

TEST(Film, MoreGuidesAreWeighedWithThoseThatAPixelHas) {
  Film film({.width_px = 3, .height_px = 2});
  const Vec3f up = Vec3f::UnitZ(), side = Vec3f::UnitX();
  film.Develop({1, 1}, Sum({Sample(2, 0.4f, up), Sample(6, 0.8f, side, 0.5f)}), 2);
  EXPECT_EQ(film.color(1, 1, 0), 4);
  EXPECT_NEAR(film.albedo(1, 1, 2), (0.4f + 0.5f * 0.8f) / 1.5f, 1e-6);
  film.AddGuides({1, 1}, Sum({Sample(9, 0.2f, side), Sample(9, 0.2f, side)}));
  EXPECT_EQ(film.color(1, 1, 0), 4);
  EXPECT_NEAR(film.albedo(1, 1, 2), (0.4f + 0.5f * 0.8f + 2 * 0.2f) / 3.5f, 1e-6);
  EXPECT_NEAR(film.normal(1, 1, 0), 2.5f / 3.5f, 1e-6);
  EXPECT_NEAR(film.normal(1, 1, 2), 1 / 3.5f, 1e-6);
  film.Develop({1, 1}, Sum({Sample(1, 0.5f, up)}), 1);  // Anew.
  EXPECT_EQ(film.color(1, 1, 0), 1);
  EXPECT_EQ(film.albedo(1, 1, 0), 0.5f);
}

TEST(Film, PixelsAreMixedWhereColoursOrNormalsDiffer) {
  Film film({.width_px = 5, .height_px = 1});
  const Vec3f up = Vec3f::UnitZ(), side = Vec3f::UnitX();
  const PathResult plain = Sample(1, 0.5f, up);
  film.Develop({0, 0}, Sum({plain, plain, plain, Sample(900, 0.5f, up)}), 4);  // Light only.
  film.Develop({1, 0}, Sum({plain, plain, plain, Sample(1, 0.5f, side)}), 4);
  film.Develop({2, 0}, Sum({plain, plain, plain, Sample(1, 0.95f, up)}), 4);
  film.Develop({3, 0}, Sum({plain, plain, plain, Sample(1, 0.53f, up)}), 4);
  film.Develop({4, 0}, Sum({plain, plain, plain, Sample(1, 0.5f, side, 1e-3f)}), 4);
  const std::vector<PixelAt> mixed = film.MixedPixels();
  ASSERT_EQ(mixed.size(), 2u);
  EXPECT_EQ(mixed[0].x, 1);
  EXPECT_EQ(mixed[1].x, 2);
}

// A wall behind slanted laths a few pixels wide, all evenly lit.
StereoFrame RenderLaths(const v1::RenderConfig& config) {
  TestScene test;
  const uint32_t dark = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.1f)));
  const uint32_t pale = test.AddMaterial(DiffuseSample(Vec3f(0.8f, 0.6f, 0.4f)));
  test.AddMesh(MakeQuad({-3, 2, -2}, {6, 0, 0}, {0, 0, 4}), dark);
  for (int i = 0; i < 60; ++i) {
    const float x = -1.8f + 0.06f * static_cast<float>(i);
    test.AddMesh(MakeQuad({x, 1.9f, -1.2f}, {0.03f, 0, 0}, {0.2f, 0, 2.4f}), pale);
  }
  test.AddPointLight({0, -2, 1}, 0.05, 1000);
  return RenderFrame(test, config, test::MakeRig({0, -0.5, 0}, {0, 1, 0}, 192, 144, 180, 0.1));
}

TEST(Film, EdgesOfFinePatternsComeOutAsTheyAre) {
  const StereoFrame reference = RenderLaths(MakeConfig(256, 6, false));
  v1::RenderConfig few;  // As many as a large picture gets.
  few.set_samples_per_pixel(4);
  const StereoFrame frame = RenderLaths(few);
  const ImageRgb8 levels = ToSrgb(frame.left.radiance, reference.exposure);
  EXPECT_LT(test::MeanSquare(levels, reference.left.color), 7.5 * 7.5);
}

}  // namespace
}  // namespace parallax
