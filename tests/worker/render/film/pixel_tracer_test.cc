#include "worker/render/film/pixel_tracer.h"

#include <gtest/gtest.h>

#include "tests/worker/render/radiance.h"

namespace parallax {
namespace {

TEST(PixelTracer, EightSamplesHaveTheSamplersOfEachAlone) {
  for (const bool together : {true, false}) {
    const PixelSampling sampling{0x1234567, 8, together};
    for (uint32_t round = 0; round < 50; ++round) {
      Bits8 x, y, sample, seeds, numbers;
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        x[lane] = 37 * round + lane;
        y[lane] = 1000 - 11 * round;
        sample[lane] = (lane + round) % 8;
      }
      sampling.Samplers(x, y, sample, &seeds, &numbers);
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        const Sampler alone = together
                                  ? Sampler::OfImage(0x1234567, x[lane], y[lane], 3, sample[lane])
                                  : Sampler(0x1234567, x[lane], y[lane], sample[lane]);
        EXPECT_EQ(seeds[lane], alone.seed());
        EXPECT_EQ(numbers[lane], alone.sample());
      }
    }
  }
}

// More samples than are traced at once, and pixels that straddle two such lots.
TEST(PixelTracer, PixelsAreMeansOfTheirOwnPaths) {
  const test::TestScene room = test::MakeBoxRoom();
  const test::Built built = Build(room);
  const auto stereo =
      StereoCamera::FromRig(test::MakeRig({1, 1, 1.4}, {1, 0.4, -0.2}, 24, 16, 20, 0.1));
  ASSERT_TRUE(stereo.ok());
  const PinholeCamera& camera = stereo->eyes[0];
  const CameraRays rays(camera);
  const PathOptions options;
  for (const int samples : {1, 5, 300}) {
    const PixelSampling sampling{77, samples, false};
    std::vector<PixelAt> pixels;
    for (int i = 0; i < 21; ++i) pixels.push_back({i % 24, (7 * i) % 16});
    Film film(camera);
    PixelTracer tracer(*built.scene, built.lights, options, camera, sampling);
    tracer.Trace(pixels, {}, &film);
    PathTracer alone(*built.scene, built.lights, options);
    double light = 0;
    for (const PixelAt& at : pixels) {
      Vec3f sum = Vec3f::Zero();
      for (int s = 0; s < samples; ++s) {
        Sampler sampler(77, static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y),
                        static_cast<uint32_t>(s));
        const Vec2f jitter = sampler.Pair();
        const Ray ray = rays.Through(static_cast<float>(at.x) + jitter.x(),
                                     static_cast<float>(at.y) + jitter.y());
        sum += alone.Trace(ray, sampler).radiance;
      }
      for (int c = 0; c < 3; ++c) {
        const float wanted = sum[c] / static_cast<float>(samples);
        // Packets and single rays may part at an edge.
        ASSERT_NEAR(film.color(at.x, at.y, c), wanted, 0.02f * wanted + 1e-5f) << samples;
        light += wanted;
      }
    }
    EXPECT_GT(light, 0);
  }
}

TEST(PixelTracer, WhatIsCancelledIsLeftAsItIs) {
  const test::Built built = Build(test::MakeBoxRoom());
  const auto stereo =
      StereoCamera::FromRig(test::MakeRig({1, 1, 1.4}, {1, 0.4, -0.2}, 24, 16, 20, 0.1));
  Film film(stereo->eyes[0]);
  PixelTracer tracer(*built.scene, built.lights, {}, stereo->eyes[0], {77, 4, true});
  const CancelToken cancel;
  cancel.Cancel();
  const std::vector<PixelAt> pixels = {{3, 4}};
  EXPECT_EQ(tracer.Trace(pixels, cancel, &film), 0u);
  EXPECT_EQ(film.color(3, 4, 0), 0);
  EXPECT_GT(tracer.Trace(pixels, {}, &film), 0u);
}

}  // namespace
}  // namespace parallax
