// What a path tells the denoiser about what it saw.
#include "worker/render/path_tracer.h"

#include <gtest/gtest.h>

#include "tests/worker/render/radiance.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::DiffuseSample;
using test::MakeQuad;
using test::TestScene;

struct Guides {
  Vec3f albedo = Vec3f::Zero(), normal = Vec3f::Zero();
};

// Of a pixel that looks along -z from (0, 0, 1), as the renderer adds up its samples.
Guides Look(const Built& built, const Vec3f& direction, int samples) {
  Guides sum;
  float weights = 0;
  PathTracer tracer(*built.scene, built.lights, {});
  for (int i = 0; i < samples; ++i) {
    Ray ray;
    ray.origin = {0, 0, 1};
    ray.direction = direction.normalized();
    Sampler sampler(3, 0, 0, static_cast<uint32_t>(i));
    const PathResult path = tracer.Trace(ray, sampler);
    sum.albedo += path.guide_weight * path.albedo;
    sum.normal += path.guide_weight * path.normal;
    weights += path.guide_weight;
  }
  return {sum.albedo / weights, sum.normal / weights};
}

TEST(PathTracer, GuidesShowWhatAMirrorShows) {
  TestScene test;
  SurfaceSample silver;
  silver.base_color = Vec3f::Constant(0.9f);
  silver.metallic = 1;
  silver.roughness = 0.02f;
  test.AddMesh(MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test.AddMaterial(silver));
  const Vec3f red(0.8f, 0.1f, 0.1f);
  test.AddMesh(MakeQuad({2, -5, -5}, {0, 0, 10}, {0, 10, 0}), test.AddMaterial(DiffuseSample(red)));
  const Guides seen = Look(Build(test), {0.5f, 0, -1}, 4);
  EXPECT_LT((seen.albedo - 0.9f * red).norm(), 0.05f);
  EXPECT_LT((seen.normal - Vec3f(-1, 0, 0)).norm(), 0.05f);
}

TEST(PathTracer, GuidesLookThroughClearPanesWithoutNoise) {
  TestScene test;
  SurfaceSample pane;
  pane.base_color = Vec3f::Ones();
  pane.transmission = 1;
  pane.thin_walled = true;
  pane.roughness = 0;
  test.AddMesh(MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test.AddMaterial(pane));
  const Vec3f green(0.1f, 0.7f, 0.2f);
  test.AddMesh(MakeQuad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}),
               test.AddMaterial(DiffuseSample(green)));
  const Built built = Build(test);
  for (const int samples : {16, 64}) {
    const Guides seen = Look(built, {0.3f, 0.2f, -1}, samples);
    EXPECT_LT((seen.albedo - green).norm(), 0.02f);
    EXPECT_LT((seen.normal - Vec3f(0, 0, 1)).norm(), 0.02f);
  }
}

TEST(PathTracer, GuidesOfADarkPaneAreOfWhatItMirrorsWithoutNoise) {
  TestScene test;
  SurfaceSample pane;
  pane.base_color = {0.02f, 0.06f, 0.02f};
  pane.transmission = 1;
  pane.thin_walled = true;
  pane.roughness = 0;
  test.AddMesh(MakeQuad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}), test.AddMaterial(pane));
  const Vec3f green(0.1f, 0.7f, 0.2f), red(0.8f, 0.1f, 0.1f);
  test.AddMesh(MakeQuad({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}),
               test.AddMaterial(DiffuseSample(green)));
  test.AddMesh(MakeQuad({6, -9, 0.1f}, {0, 0, 9}, {0, 18, 0}),
               test.AddMaterial(DiffuseSample(red)));
  const Built built = Build(test);
  for (const int samples : {16, 64}) {
    const Guides seen = Look(built, {1, 0, -0.3f}, samples);
    EXPECT_LT((seen.normal - Vec3f(-1, 0, 0)).norm(), 0.02f);
    EXPECT_GT(seen.albedo.x(), 6 * seen.albedo.y());
  }
}

}  // namespace
}  // namespace parallax
