// The guides that paths give the denoiser; and that paths traced together don't affect each other.
#include "worker/render/paths/path_tracer.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
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

// Guides of a pixel that looks along `direction` from (0, 0, 1), added up as the renderer does.
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

SurfaceSample Silver() {
  SurfaceSample silver;
  silver.base_color = Vec3f::Constant(0.9f);
  silver.metallic = 1;
  silver.roughness = 0.02f;
  return silver;
}

TEST(PathTracer, GuidesShowWhatAMirrorShows) {
  TestScene test;
  test.AddMesh(MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test.AddMaterial(Silver()));
  const Vec3f red(0.8f, 0.1f, 0.1f);
  test.AddMesh(MakeQuad({2, -5, -5}, {0, 0, 10}, {0, 10, 0}), test.AddMaterial(DiffuseSample(red)));
  const Guides seen = Look(Build(test), {0.5f, 0, -1}, 4);
  EXPECT_LT((seen.albedo - 0.9f * red).norm(), 0.05f);
  EXPECT_LT((seen.normal - Vec3f(-1, 0, 0)).norm(), 0.05f);
}

// Guides end after one mirror: images of several mirrors are rare, and dark glass that mirrors
// itself made guides of noise.
TEST(PathTracer, GuidesFollowOneMirrorAndThenShowTheNext) {
  TestScene test;
  const uint32_t mirror = test.AddMaterial(Silver());
  test.AddMesh(MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), mirror);
  test.AddMesh(MakeQuad({2, -5, -5}, {0, 0, 10}, {0, 10, 0}), mirror);
  test.AddMesh(MakeQuad({-3, -9, -9}, {0, 18, 0}, {0, 0, 18}),
               test.AddMaterial(DiffuseSample(Vec3f(0.1f, 0.8f, 0.1f))));
  const Guides seen = Look(Build(test), {0.5f, 0, -1}, 4);
  EXPECT_LT((seen.albedo - Vec3f::Constant(0.81f)).norm(), 0.05f);
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

// Ground truth is the pane, whichever way a path takes at it.
TEST(PathTracer, TheDistanceIsThatOfAPaneThatPathsPass) {
  TestScene test;
  SurfaceSample pane;
  pane.base_color = Vec3f::Ones();
  pane.transmission = 1;
  pane.thin_walled = true;
  pane.roughness = 0;
  test.AddMesh(MakeQuad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}), test.AddMaterial(pane));
  test.AddMesh(MakeQuad({-9, -9, -5}, {9, 0, 0}, {0, 18, 0}),
               test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f))));
  const Built built = Build(test);
  PathTracer tracer(*built.scene, built.lights, {});
  for (const float x : {-0.5f, 0.5f}) {  // Before a floor, and before nothing.
    Ray ray;
    ray.origin = {0, 0, 1};
    ray.direction = Vec3f(x, 0, -1).normalized();
    for (uint32_t i = 0; i < 32; ++i) {
      Sampler sampler(3, 0, 0, i);
      EXPECT_NEAR(tracer.Trace(ray, sampler).distance, std::sqrt(1.25f), 1e-4f);
    }
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

// A room with a lamp, a pane, gilt, glass, velvet and marble in it, and a sky above.
TestScene Showroom() {
  TestScene test;
  const auto add = [&](const Vec3f& corner, const Vec3f& u, const Vec3f& v, auto change) {
    SurfaceSample s;
    s.base_color = {0.7f, 0.5f, 0.3f};
    change(s);
    return test.AddMesh(MakeQuad(corner, u, v), test.AddMaterial(s));
  };
  const auto nothing = [](SurfaceSample&) {};
  add({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, nothing);
  add({-2, -2, 0}, {0, 0, 2}, {0, 4, 0}, [](SurfaceSample& s) { s.sheen = 1; });
  add({2, -2, 0}, {0, 4, 0}, {0, 0, 2}, [](SurfaceSample& s) { s.subsurface = 0.7f; });
  add({-2, 2, 0}, {4, 0, 0}, {0, 0, 2}, [](SurfaceSample& s) {
    s.metallic = 1;
    s.roughness = 0.3f;
  });
  add({-2, -2, 0}, {4, 0, 0}, {0, 0, 2}, [](SurfaceSample& s) {
    s.metallic = 1;
    s.roughness = 0;
  });
  add({-1, -1, 0.5f}, {2, 0, 0}, {0, 2, 0.3f}, [](SurfaceSample& s) {
    s.transmission = 1;
    s.thin_walled = true;
    s.roughness = 0;
  });
  add({-1, -1, 0.2f}, {2, 0, 0}, {0, 2, 0.1f}, [](SurfaceSample& s) {
    s.transmission = 0.8f;
    s.roughness = 0.4f;
  });
  add({-1, 0, 0.8f}, {0.7f, 0, 0.2f}, {0, 1, 0}, [](SurfaceSample& s) { s.opacity = 0.5f; });
  add({0.5f, 0, 1}, {0.7f, 0, 0.2f}, {0, 1, 0}, [](SurfaceSample& s) { s.clearcoat = 1; });
  test.AddMeshLight(add({-0.5f, -0.5f, 1.9f}, {0, 1, 0}, {1, 0, 0}, nothing), 60);
  test.AddPointLight({1, 1, 1.5}, 0.1, 30);
  test.AddPointLight({-1.5, 1, 1.5}, 0, 30);
  test.recipe.mutable_sky()->set_strength(1);
  return test;
}

// Each starts elsewhere: packets would round otherwise.
std::vector<Path> PathsInShowroom(uint32_t count) {
  Rng rng(SceneSeed{5}, "rays");
  std::vector<Path> paths;
  for (uint32_t i = 0; i < count; ++i) {
    Ray ray;
    ray.origin = {static_cast<float>(rng.Uniform(-1.9, 1.9)),
                  static_cast<float>(rng.Uniform(-1.9, 1.9)),
                  static_cast<float>(rng.Uniform(0.05, 1.8))};
    ray.direction = DirectionAt(static_cast<float>(rng.Uniform(-1, 1)),
                                static_cast<float>(rng.Uniform(0, 6.28)));
    paths.emplace_back(Sampler(9, i, 0, 0), ray);
  }
  return paths;
}

TEST(PathTracer, GuidesAloneAreThoseOfWholePathsForFewerRays) {
  const Built built = Build(Showroom());
  std::vector<Path> whole = PathsInShowroom(700), guides = whole;
  PathTracer(*built.scene, built.lights, PathOptions()).Trace(whole);
  PathOptions options;
  options.only_guides = true;
  PathTracer(*built.scene, built.lights, options).Trace(guides);
  uint32_t rays = 0, wanted = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    ASSERT_EQ(guides[i].result.albedo, whole[i].result.albedo) << i;
    ASSERT_EQ(guides[i].result.normal, whole[i].result.normal) << i;
    ASSERT_EQ(guides[i].result.guide_weight, whole[i].result.guide_weight) << i;
    rays += guides[i].result.rays;
    wanted += whole[i].result.rays;
  }
  EXPECT_LT(2 * rays, wanted);
}

// Every other path is given its first hit, as the rasteriser does.
TEST(PathTracer, FirstHitsThatAreKnownAreNotTraced) {
  const Built built = Build(Showroom());
  PathOptions options;
  options.only_guides = true;
  std::vector<Path> paths = PathsInShowroom(700);
  PathTracer tracer(*built.scene, built.lights, options);
  tracer.Trace(paths);
  std::vector<PathStarts8> starts((paths.size() + kLanes - 1) / kLanes);
  for (size_t i = 0; i < paths.size(); ++i) {
    PathStarts8& start = starts[i / kLanes];
    const int lane = static_cast<int>(i % kLanes);
    start.rays.origin.Set(lane, paths[i].ray.origin);
    start.rays.direction.Set(lane, paths[i].ray.direction);
    start.spread[lane] = paths[i].ray.spread;
    start.seed[lane] = paths[i].sampler.seed();
    start.sample[lane] = paths[i].sampler.sample();
    if (i % 2 == 0) continue;
    RawHit hit;
    start.body[lane] = PathStarts8::kNothing;
    if (!built.scene->trees().Intersect(RayTrees::Tree::kFast, paths[i].ray, 0, &hit)) continue;
    start.body[lane] = static_cast<int32_t>(hit.placed);
    start.triangle[lane] = static_cast<int32_t>(hit.triangle);
  }
  std::vector<PathResult> results(paths.size());
  tracer.Trace(starts, results);
  int differ = 0;  // Rounding may lead a path another way.
  for (size_t i = 0; i < paths.size(); ++i) {
    const PathResult &seen = results[i], &wanted = paths[i].result;
    const bool alike = (seen.albedo - wanted.albedo).norm() < 1e-3f &&
                       (seen.normal - wanted.normal).norm() < 1e-3f &&
                       std::abs(seen.distance - wanted.distance) < 1e-4f &&
                       seen.rays + i % 2 == wanted.rays;
    differ += alike ? 0 : 1;
  }
  EXPECT_LE(differ, 7);
}

// Their number is no multiple of what goes together.
TEST(PathTracer, WhatAPathSeesDoesNotDependOnItsCompany) {
  const Built built = Build(Showroom());
  PathTracer tracer(*built.scene, built.lights, PathOptions());
  const std::vector<Path> paths = PathsInShowroom(700);
  std::vector<Path> together = paths;
  tracer.Trace(together);
  double light = 0;
  for (size_t i = 0; i < paths.size(); ++i) {
    const PathResult alone = tracer.Trace(paths[i].ray, paths[i].sampler);
    const PathResult& seen = together[i].result;
    ASSERT_EQ(seen.radiance, alone.radiance) << i;
    ASSERT_EQ(seen.albedo, alone.albedo) << i;
    ASSERT_EQ(seen.normal, alone.normal) << i;
    ASSERT_EQ(seen.guide_weight, alone.guide_weight) << i;
    ASSERT_EQ(seen.rays, alone.rays) << i;
    light += Luminance(seen.radiance);
  }
  EXPECT_GT(light, 0);
}

// Many at once, of which new ones join as others end, see what each sees alone.
TEST(PathTracer, NewPathsJoinWhereOthersHaveEnded) {
  const Built built = Build(Showroom());
  PathTracer tracer(*built.scene, built.lights, PathOptions());
  for (const size_t count : {1u, 7u, 256u, 261u, 3000u}) {
    const std::vector<Path> paths = PathsInShowroom(static_cast<uint32_t>(count));
    std::vector<PathStarts8> starts((count + kLanes - 1) / kLanes);
    for (size_t i = 0; i < count; ++i) {
      PathStarts8& start = starts[i / kLanes];
      const int lane = static_cast<int>(i % kLanes);
      start.rays.origin.Set(lane, paths[i].ray.origin);
      start.rays.direction.Set(lane, paths[i].ray.direction);
      start.spread[lane] = paths[i].ray.spread;
      start.seed[lane] = paths[i].sampler.seed();
      start.sample[lane] = paths[i].sampler.sample();
      start.dimension = paths[i].sampler.dimension();
    }
    std::vector<PathResult> results(count);
    tracer.Trace(starts, results);
    for (size_t i = 0; i < count; ++i) {
      const PathResult alone = tracer.Trace(paths[i].ray, paths[i].sampler);
      ASSERT_EQ(results[i].radiance, alone.radiance) << i << " of " << count;
      ASSERT_EQ(results[i].albedo, alone.albedo) << i << " of " << count;
      ASSERT_EQ(results[i].normal, alone.normal) << i << " of " << count;
      ASSERT_EQ(results[i].guide_weight, alone.guide_weight) << i << " of " << count;
      ASSERT_EQ(results[i].rays, alone.rays) << i << " of " << count;
    }
  }
}

}  // namespace
}  // namespace parallax
