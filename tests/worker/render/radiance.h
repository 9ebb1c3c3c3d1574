// Radiance along one ray, with its error bar: what tests of light transport compare.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/render/test_scenes.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax::test {

struct Built {
  std::unique_ptr<RenderScene> scene;
  LightTable lights;
};

inline Built Build(const TestScene& test) {
  auto scene = RenderScene::Build(test.geometry, 0);
  EXPECT_TRUE(scene.ok()) << scene.status();
  auto lights = LightTable::Build(test.recipe, **scene);
  EXPECT_TRUE(lights.ok()) << lights.status();
  return {*std::move(scene), *std::move(lights)};
}

// The light that a point of a floor chooses, whatever else is asked at once; all lanes are alike.
struct Sought {
  LightReceivers8 receivers;
  LightChoices8 lights;
  LightReceiver at() const { return receivers.Get(0); }
};
inline Sought Seek(const LightTable& lights, const Vec3f& position, float choice = 0.5f) {
  const LightQueries8 queries{Vec3x8(position), Vec3x8(Vec3f::UnitZ()), Splat(choice), kLanes};
  Sought sought;
  std::vector<Float8> scratch;
  LightSampler(lights).Choose(queries, &scratch, &sought.receivers, &sought.lights);
  return sought;
}

struct Estimate {
  Vec3f mean = Vec3f::Zero();
  float error = 0;  // Standard error of the mean luminance.
};

// Radiance seen from `from` towards `to`.
inline Estimate Radiance(const Built& built, const Vec3f& from, const Vec3f& to, int samples,
                         int bounces, DirectLight direct = DirectLight::kBoth) {
  PathOptions options;
  options.max_bounces = bounces;
  options.direct = direct;
  Ray ray;
  ray.origin = from;
  ray.direction = (to - from).normalized();
  Vec3d sum = Vec3d::Zero();
  double squares = 0;
  PathTracer tracer(*built.scene, built.lights, options);
  for (int i = 0; i < samples; ++i) {
    Sampler sampler(77, static_cast<uint32_t>(i), 0, 0);  // Independent: honest error bars.
    const Vec3f radiance = tracer.Trace(ray, sampler).radiance;
    sum += radiance.cast<double>();
    squares += Square(Luminance(radiance));
  }
  Estimate estimate;
  estimate.mean = (sum / samples).cast<float>();
  const double mean = Luminance(estimate.mean);
  estimate.error =
      static_cast<float>(std::sqrt(std::max(0.0, squares / samples - mean * mean) / samples));
  return estimate;
}

}  // namespace parallax::test
