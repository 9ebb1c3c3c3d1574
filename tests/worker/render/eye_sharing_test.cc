// What the eyes of a rig lend each other.
#include "worker/render/eye_sharing.h"

#include <gtest/gtest.h>

#include "tests/worker/render/radiance.h"
#include "worker/render/camera_rays.h"
#include "worker/render/profiles.h"
#include "worker/render/renderer.h"

namespace parallax {
namespace {

constexpr double kShift_px_m = 20;  // Focal length times baseline: ten pixels at two metres.
constexpr int kWidth = 16;

EyeSample Sample(float x_px, float depth_m, uint32_t surface, float radiance, float albedo) {
  EyeSample sample;
  sample.x_px = x_px;
  sample.depth_m = depth_m;
  sample.surface = surface;
  sample.radiance.fill(Eigen::half(radiance));
  sample.albedo.fill(Eigen::half(albedo));
  return sample;
}

// One row of one eye, two samples a pixel, dark unless put there.
struct Eye {
  EyeSamples samples{kWidth, 1, 2};
  ImageF3 color{kWidth, 1}, albedo{kWidth, 1};

  void Put(int x, const EyeSample& first, const EyeSample& second) {
    samples.At(x, 0)[0] = first;
    samples.At(x, 0)[1] = second;
    for (int c = 0; c < 3; ++c) {
      const auto at = static_cast<size_t>(c);
      color(x, 0, c) =
          (static_cast<float>(first.radiance[at]) + static_cast<float>(second.radiance[at])) / 2;
      albedo(x, 0, c) =
          (static_cast<float>(first.albedo[at]) + static_cast<float>(second.albedo[at])) / 2;
    }
  }
  void Borrow(const Eye& other, double shift_px_m) {
    BorrowSamples(samples, other.samples, shift_px_m, &color, &albedo);
  }
};

TEST(EyeSharing, APieceThatBothSeeHasTheMeanOfAllSamples) {
  Eye left, right;
  left.Put(12, Sample(12.2f, 2, 7, 1, 0.25f), Sample(12.7f, 2, 7, 3, 0.25f));
  right.Put(2, Sample(2.1f, 2, 7, 6, 0.5f), Sample(2.9f, 2, 7, 10, 0.5f));
  Eye left_alone = left;
  left.Borrow(right, kShift_px_m);
  right.Borrow(left_alone, -kShift_px_m);
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(left.color(12, 0, c), 5);
    EXPECT_FLOAT_EQ(right.color(2, 0, c), 5);
    EXPECT_FLOAT_EQ(left.albedo(12, 0, c), 0.375f);
    EXPECT_FLOAT_EQ(right.albedo(2, 0, c), 0.375f);
  }
  EXPECT_EQ(left.color(2, 0), 0);  // Nothing lands where the other eye has it.
}

TEST(EyeSharing, OnlyTheSameSurfaceAtTheSameDepthIsShared) {
  const auto borrowed = [](const EyeSample& lent) {
    Eye left, right;
    left.Put(12, Sample(12.2f, 2, 7, 1, 0.5f), Sample(12.7f, 2, 7, 1, 0.5f));
    right.Put(2, lent, EyeSample());
    left.Borrow(right, kShift_px_m);
    return left.color(12, 0);
  };
  EXPECT_FLOAT_EQ(borrowed(Sample(2.5f, 2, 7, 4, 0.5f)), 2);
  EXPECT_FLOAT_EQ(borrowed(Sample(2.5f, 2, 8, 4, 0.5f)), 1);      // Another surface.
  EXPECT_FLOAT_EQ(borrowed(Sample(3.2f, 2.15f, 7, 4, 0.5f)), 1);  // The same, behind itself.
  EXPECT_FLOAT_EQ(borrowed(Sample(2.5f, 0, 7, 4, 0.5f)), 1);      // Not to be lent.
  EXPECT_FLOAT_EQ(borrowed(Sample(2.5f, 0.1f, 7, 4, 0.5f)), 1);   // Out of the picture.
}

TEST(EyeSharing, WhatIsNotToBeLentDoesNotBorrow) {
  Eye left, right;
  left.Put(12, Sample(12.2f, 0, 7, 1, 0.5f), Sample(12.7f, 0, 7, 1, 0.5f));
  right.Put(2, Sample(2.5f, 2, 7, 4, 0.5f), Sample(2.6f, 2, 7, 4, 0.5f));
  left.Borrow(right, kShift_px_m);
  EXPECT_FLOAT_EQ(left.color(12, 0), 1);
}

TEST(EyeSharing, AnEdgeStaysWhereItIs) {
  Eye left, right;
  left.Put(12, Sample(12.2f, 2, 7, 1, 0.5f), Sample(12.7f, 4, 9, 0, 0.5f));
  // Many of the near surface, none of the far one: it still covers half of the pixel.
  for (int x = 2; x < 4; ++x) {
    const auto at = static_cast<float>(x);
    right.Put(x, Sample(at + 0.05f, 2, 7, 3, 0.5f), Sample(at + 0.1f, 2, 7, 3, 0.5f));
  }
  left.Borrow(right, kShift_px_m);
  EXPECT_FLOAT_EQ(left.color(12, 0), (1 + 2 * 3) / 3.0f / 2);
}

// What the tracer says of the first surface that a pixel shows.
PathResult Seen(const SurfaceSample& surface, bool has_floor = true) {
  test::TestScene scene;
  if (has_floor) {
    scene.AddMesh(test::MakeQuad({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), scene.AddMaterial(surface));
  }
  scene.AddPointLight({0, 0, 3}, 0.1, 50);
  const test::Built built = test::Build(scene);
  Ray ray;
  ray.origin = {0.5f, 0, 2};
  ray.direction = -Vec3f::UnitZ();
  return PathTracer(*built.scene, built.lights, {}).Trace(ray, Sampler(1, 2, 3, 4));
}

TEST(EyeSharing, PlainSurfacesAreNamedGlossyOnesAreNot) {
  const SurfaceSample plain = test::DiffuseSample(Vec3f::Constant(0.5f));
  EXPECT_FLOAT_EQ(Seen(plain).plain_distance, 2);
  SurfaceSample mirror = plain;
  mirror.metallic = 1;
  mirror.roughness = 0;
  EXPECT_EQ(Seen(mirror).plain_distance, 0);
  SurfaceSample glass = plain;
  glass.transmission = 1;
  glass.roughness = 0;
  EXPECT_EQ(Seen(glass).plain_distance, 0);
  SurfaceSample lacquer = test::DiffuseSample(Vec3f::Constant(0.05f));
  lacquer.specular = 1;
  lacquer.roughness = 0.1f;
  EXPECT_EQ(Seen(lacquer).plain_distance, 0);
  EXPECT_EQ(Seen(plain, false).plain_distance, 0);
}

bool SharesEyes(const char* profile, v1::RenderConfig::Denoise denoise, int samples) {
  v1::RenderConfig config;
  config.set_profile(profile);
  config.set_denoise(denoise);
  config.set_samples_per_pixel(samples);
  return ResolveProfile(config)->shares_eyes;
}

TEST(EyeSharing, IsForFewSamplesBeforeADenoiser) {
  const auto usual = v1::RenderConfig::DENOISE_UNSPECIFIED;
  EXPECT_TRUE(SharesEyes("preview", usual, 0));
  EXPECT_TRUE(SharesEyes("default", usual, 0));
  EXPECT_FALSE(SharesEyes("default", v1::RenderConfig::DENOISE_OFF, 0));
  EXPECT_FALSE(SharesEyes("default", usual, 1024));
  EXPECT_FALSE(SharesEyes("high", usual, 0));
  EXPECT_FALSE(SharesEyes("reference", v1::RenderConfig::DENOISE_ON, 4));
}

}  // namespace
}  // namespace parallax
