// The radiance cache: closed forms, leaks, determinism, bounds, and pictures made with it.
#include "worker/render/paths/radiance_cache.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "common/base/rng.h"
#include "tests/worker/render/test_scenes.h"
#include "worker/render/paths/cache_fill.h"
#include "worker/render/renderer.h"
#include "worker/render/surface/sampling.h"
#include "worker/render/surface/shared_exponent.h"

namespace parallax {
namespace {

using test::BoxRoomRig;
using test::DiffuseSample;
using test::MakeBox;
using test::MakeBoxRoom;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::TestScene;

CacheQuestions8 Questions(std::span<const CachePlace> places, float widest_m) {
  CacheQuestions8 questions{};
  questions.asked = (1u << places.size()) - 1;
  questions.jitter_u = questions.jitter_v = Splat(0.5f);
  questions.widest_m = Splat(widest_m);
  for (int k = 0; k < static_cast<int>(places.size()); ++k) {
    const CachePlace& place = places[static_cast<size_t>(k)];
    questions.position.Set(k, place.position);
    questions.normal.Set(k, place.normal);
    questions.group[k] = static_cast<int32_t>(place.group);
    questions.coarse[k] = place.coarse;
    questions.slot[k] = place.slot;
  }
  return questions;
}

// Asks the cache for the radiance at `place`. False if it has none.
bool Answer(const RadianceCache& cache, const CachePlace& place, float widest_m, Vec3f* radiance) {
  uint64_t keys[kLanes];
  cache.Ask(Questions({&place, 1}, widest_m), keys);
  return cache.Answer(keys[0], place, radiance);
}

// A scene ready to trace, with a cache filled from its rigs.
struct Lit {
  std::unique_ptr<RenderScene> scene;
  LightTable lights;
  PathOptions options;
  std::vector<StereoCamera> cameras;
  RadianceCache cache;

  Lit(const TestScene& test, const CacheFill& fill, int max_bounces = 32) {
    scene = *RenderScene::Build(test.geometry, 0);
    lights = *LightTable::Build(test.recipe, *scene);
    options.max_bounces = max_bounces;
    for (const v1::Rig& rig : test.recipe.rigs()) cameras.push_back(*StereoCamera::FromRig(rig));
    cache = *FillRadianceCache(*scene, &lights, options, 7, cameras, fill, {});
  }

  // Mean radiance over the left picture of a rig, by `samples` paths.
  Vec3f Mean(size_t rig, int samples, const RadianceCache* use, double* rays = nullptr) {
    options.cache = use;
    const PinholeCamera& camera = cameras[rig].eyes[0];
    PathTracer tracer(*scene, lights, options);
    Vec3d sum = Vec3d::Zero();
    for (int i = 0; i < samples; ++i) {
      Sampler sampler(use ? 11 : 12, 0, 0, static_cast<uint32_t>(i));
      const Vec2f at = sampler.Pair();
      Ray ray;
      ray.origin = camera.origin.cast<float>();
      ray.direction = (camera.world_from_camera *
                       camera.DirectionAt(at.x() * camera.width_px, at.y() * camera.height_px))
                          .normalized()
                          .cast<float>();
      const PathResult path = tracer.Trace(ray, sampler);
      sum += path.radiance.cast<double>();
      if (rays) *rays += path.rays;
    }
    return (sum / samples).cast<float>();
  }
};

CacheFill SmallFill(int64_t paths, float cell_m) {
  CacheFill fill;
  fill.paths = paths;
  fill.cell_m = cell_m;
  return fill;
}

// A closed box of 2 m whose walls shine.
struct Furnace {
  double albedo = 0, power = 240;

  TestScene Scene() const {
    TestScene test;
    const uint32_t box =
        test.AddMesh(MakeBox({0, 0, 0}, {2, 2, 2}, true),
                     test.AddMaterial(DiffuseSample(Vec3f::Constant(static_cast<float>(albedo)))));
    test.AddMeshLight(box, power);
    *test.recipe.add_rigs() = MakeRig({1, 0.3, 1}, {0.1, 1, 0.05}, 64, 48, 30, 0.1);
    return test;
  }
  double Radiance() const { return power / (M_PI * 24) / (1 - albedo); }
};

TEST(RadianceCache, AShiningFurnaceHasTheRadianceOfItsClosedForm) {
  const Furnace furnace{0.6};
  Lit lit(furnace.Scene(), SmallFill(20000, 0.1f));
  ASSERT_GT(lit.cache.cells(), 500u);
  double rays = 0, rays_without = 0;
  const double wanted = furnace.Radiance();
  EXPECT_NEAR(lit.Mean(0, 8000, &lit.cache, &rays).x() / wanted, 1, 0.02);
  EXPECT_NEAR(lit.Mean(0, 8000, nullptr, &rays_without).x() / wanted, 1, 0.02);
  EXPECT_LT(rays, 0.8 * rays_without);  // It was asked.
}

// Paths that fill it go on for longer than those of pictures.
TEST(RadianceCache, KnowsLightThatWasScatteredOften) {
  const Furnace furnace{0.85};
  Lit lit(furnace.Scene(), SmallFill(20000, 0.1f), 3);
  EXPECT_NEAR(lit.Mean(0, 8000, &lit.cache).x() / furnace.Radiance(), 1, 0.03);
}

TEST(RadianceCache, GivesTheLightOfARoomThatPathsGive) {
  TestScene test = MakeBoxRoom();
  *test.recipe.add_rigs() = BoxRoomRig(64, 48);
  Lit lit(test, SmallFill(40000, 0.1f));
  double rays = 0, rays_without = 0;
  const Vec3f with = lit.Mean(0, 20000, &lit.cache, &rays);
  const Vec3f without = lit.Mean(0, 20000, nullptr, &rays_without);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(with[c] / without[c], 1, 0.03) << "channel " << c;
  EXPECT_LT(rays, 0.6 * rays_without);
}

// A cell where most light is too bright, as in a lamp's shade, keeps it; what is cut elsewhere,
// being rare, goes to all cells of the region as they are bright otherwise, and to none beyond.
TEST(RadianceCache, BrightPlacesKeepTheirLightAndRareLightIsSpread) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  const auto place = [](float x) { return CachePlace{{x, 0.5f, 0.5f}, Vec3f::UnitZ(), 3, 0}; };
  const float shade = 0.13f, shadow = 0.33f, struck = 0.53f, afar = 7.3f;
  std::vector<CacheBuilder::Batch> batches(1);
  const auto add = [&](float x, int count, float radiance, float excess) {
    for (int i = 0; i < count; ++i) {
      batches[0].Add({grid.KeyOf(place(x)), Vec3f::Constant(radiance), true,
                      Vec3f::Constant(excess),
                      CacheGrid::KeyOf(place(x), 12 * grid.WidthAt(place(x).position))});
    }
  };
  add(shade, 20, 1, 9);
  add(shadow, 60, 0.25f, 0);
  add(struck, 39, 1, 0);
  add(struck, 1, 1, 11);  // A fifth of what the region has.
  add(afar, 20, 1, 0);
  CacheBuilder builder(grid, 1000);
  builder.Add(batches);
  const RadianceCache cache = builder.Freeze(4);
  const auto seen = [&](float x) {
    Vec3f radiance = Vec3f::Zero();
    EXPECT_TRUE(Answer(cache, place(x), 1e3f, &radiance)) << x;
    return radiance.x();
  };
  EXPECT_FLOAT_EQ(seen(shade), 10);
  EXPECT_NEAR(seen(shadow), 0.3f, 0.3f / 256);
  EXPECT_NEAR(seen(struck), 1.2f, 1.2f / 256);
  EXPECT_FLOAT_EQ(seen(afar), 1);
}

// Fireflies among the paths that fill the cache.
TEST(RadianceCache, WhatIsMuchTooBrightCountsOnlySoMuch) {
  const auto cut = [](float radiance) {
    CacheRecord record;
    record.radiance = Vec3f::Constant(radiance);
    record.Cut(2);
    return record;
  };
  EXPECT_EQ(cut(2).radiance, Vec3f::Constant(2));
  EXPECT_TRUE(cut(2).excess.isZero());
  EXPECT_TRUE(cut(50).radiance.isApproxToConstant(2));
  EXPECT_TRUE(cut(50).excess.isApproxToConstant(48));
  EXPECT_TRUE(cut(1e6f).radiance.isApproxToConstant(2));
  EXPECT_TRUE(cut(1e6f).excess.isApproxToConstant(128));
}

// Two rooms with a wall of 1 cm between them, one lit, one closed and dark; a rig in each.
TestScene TwoRooms() {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.7f)));
  test.AddMesh(MakeBox({0, 0, 0}, {2, 2, 2}, true), grey);
  test.AddMesh(MakeBox({2.01f, 0, 0}, {4, 2, 2}, true), grey);
  test.AddPointLight({1, 1, 1.7}, 0.05, 200);
  *test.recipe.add_rigs() = MakeRig({0.3, 1, 1}, {1, 0.1, 0}, 64, 48, 30, 0.1);
  *test.recipe.add_rigs() = MakeRig({3.7, 1, 1}, {-1, 0.1, 0}, 64, 48, 30, 0.1);
  return test;
}

TEST(RadianceCache, NoLightLeaksThroughAThinWall) {
  Lit lit(TwoRooms(), SmallFill(20000, 0.1f));
  EXPECT_GT(lit.Mean(0, 2000, &lit.cache).x(), 1);
  EXPECT_EQ(lit.Mean(1, 2000, &lit.cache).x(), 0);
}

TEST(RadianceCache, TheTwoSidesOfASheetAreTwoCells) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  const CachePlace front{{0.5f, 0.5f, 0.5f}, Vec3f::UnitZ(), 3, 0};
  CachePlace back = front, other_object = front, other_slot = front, beside = front;
  back.normal = -back.normal;
  other_object.group = 4;
  other_slot.slot = 1;
  beside.position.x() += 0.1f;
  for (const CachePlace& place : {back, other_object, other_slot, beside}) {
    EXPECT_NE(grid.KeyOf(front), grid.KeyOf(place));
  }
  CachePlace near = front;
  near.normal = Vec3f(0.1f, 0.2f, 0.9f).normalized();
  EXPECT_EQ(grid.KeyOf(front), grid.KeyOf(near));
}

TEST(RadianceCache, CellsAmongLeavesAreWider) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  CachePlace leaf{{0.5f, 0.5f, 0.5f}, Vec3f::UnitZ(), 3, 0, 2.5f}, next = leaf;
  next.position.x() += 0.11f;
  EXPECT_EQ(grid.KeyOf(leaf), grid.KeyOf(next));
  leaf.coarse = next.coarse = 1;
  EXPECT_NE(grid.KeyOf(leaf), grid.KeyOf(next));
}

TEST(RadianceCache, CellsGrowWithTheDistanceFromTheRigs) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  EXPECT_EQ(grid.WidthAt({0.5f, 0.5f, 9}), 0.1f);
  EXPECT_EQ(grid.WidthAt({0.5f, 0.5f, 12}), 0.2f);
  EXPECT_EQ(grid.WidthAt({0.5f, 0.5f, 101}), 1.6f);
}

TEST(RadianceCache, EightQuestionsNameTheCellsOfEachAlone) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  std::vector<CacheBuilder::Batch> batches(1);
  batches[0].Add({grid.KeyOf(CachePlace{}), Vec3f::Ones(), true});
  CacheBuilder builder(grid, 1000);
  builder.Add(batches);
  const RadianceCache cache = builder.Freeze(1);
  Rng rng(SceneSeed{5}, "places");
  const auto draw = [&](double low, double high) {
    return static_cast<float>(rng.Uniform(low, high));
  };
  int far = 0, moved = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<CachePlace> places(static_cast<size_t>(1 + round % kLanes));
    for (CachePlace& place : places) {
      place.position = Vec3f(draw(-30, 30), draw(-30, 30), draw(-9, 9));
      place.normal = Vec3f(draw(-1, 1), draw(-1, 1), draw(-1, 1)).normalized();
      place.group = static_cast<uint32_t>(rng.UniformInt(0, 900));
      place.slot = static_cast<uint16_t>(rng.UniformInt(0, 9));
      place.coarse = rng.Bernoulli(0.4) ? 2.5f : 1.0f;
    }
    CacheQuestions8 questions = Questions(places, 0.3f);
    uint64_t keys[kLanes];
    cache.Ask(questions, keys);
    for (size_t k = 0; k < places.size(); ++k) {
      const bool near = grid.WidthOf(places[k]) <= 0.3f;
      EXPECT_EQ(keys[k], near ? grid.KeyOf(places[k]) : 0);
      far += near ? 0 : 1;
    }
    for (size_t k = places.size(); k < kLanes; ++k) EXPECT_EQ(keys[k], 0u);
    questions.jitter_u = Splat(0.9f);
    questions.jitter_v = Splat(0.2f);
    cache.Ask(questions, keys);
    for (size_t k = 0; k < places.size(); ++k) {
      const float width = grid.WidthOf(places[k]);
      const ShadingFrame frame(places[k].normal);
      CachePlace there = places[k];
      there.position += width * (0.4f * frame.x - 0.3f * frame.y);
      if (keys[k] == 0) continue;
      moved += keys[k] != grid.KeyOf(places[k]) ? 1 : 0;
      const uint64_t key = CacheGrid::KeyOf(there, width);
      EXPECT_EQ(keys[k], key) << "at " << there.position.transpose();
    }
  }
  EXPECT_GT(far, 50);
  EXPECT_GT(moved, 100);
}

TEST(RadianceCache, NarrowRaysAndUnknownPlacesAreNotAnswered) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  const CachePlace place{{0.5f, 0.5f, 0.5f}, Vec3f::UnitZ(), 3, 0};
  std::vector<CacheBuilder::Batch> batches(1);
  for (int i = 0; i < 4; ++i) batches[0].Add({grid.KeyOf(place), Vec3f(1, 2, 3), true});
  CacheBuilder builder(grid, 1000);
  builder.Add(batches);
  const RadianceCache cache = builder.Freeze(4);
  Vec3f radiance;
  ASSERT_TRUE(Answer(cache, place, 1.0f, &radiance));
  EXPECT_EQ(radiance, Vec3f(1, 2, 3));
  EXPECT_FALSE(Answer(cache, place, 0.05f, &radiance));
  CachePlace elsewhere = place;
  elsewhere.position.x() += 1;
  EXPECT_FALSE(Answer(cache, elsewhere, 1.0f, &radiance));
  EXPECT_EQ(builder.Freeze(5).cells(), 0u);  // Too few records.
  batches[0].Add({grid.KeyOf(place), Vec3f::Zero(), false});
  builder.Add(batches);
  EXPECT_EQ(builder.Freeze(4).cells(), 0u);  // One in nine found it glossy.
}

TEST(RadianceCache, HoldsNoMoreCellsThanItMay) {
  const CacheGrid grid(Box3f(Vec3f::Zero(), Vec3f::Ones()), 0.1f);
  CacheBuilder builder(grid, 6400);
  std::vector<CacheBuilder::Batch> batches(1);
  for (int i = 0; i < 100000; ++i) {
    const CachePlace place{
        {0.1f * static_cast<float>(i), 0, 0}, Vec3f::UnitZ(), static_cast<uint32_t>(i), 0};
    batches[0].Add({grid.KeyOf(place), Vec3f::Ones(), true});
  }
  builder.Add(batches);
  EXPECT_LE(builder.cells(), 6400u);
  EXPECT_GT(builder.cells(), 6000u);
  EXPECT_LT(builder.bytes(), 6400u * 32 * 5);
  EXPECT_LT(builder.Freeze(1).bytes(), 6400u * 16 * 4);
}

TEST(RadianceCache, PicturesDependNeitherOnThreadsNorOnTheOtherRigsOfTheJob) {
  TestScene test = MakeBoxRoom();
  v1::Rig rig = BoxRoomRig(80, 60);
  *test.recipe.add_rigs() = rig;
  rig = MakeRig({3.6, 0.4, 1.8}, {-0.6, 1, -0.2}, 80, 60, 50, 0.1);
  rig.set_index(1);
  *test.recipe.add_rigs() = rig;
  v1::RenderConfig config = MakeConfig(2, 4, false, "preview");
  std::vector<StereoFrame> frames;
  for (const auto& [threads, first] : {std::pair(1, 1), std::pair(3, 0), std::pair(2, 1)}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<size_t>(threads));
    auto renderer = *Renderer::Create(test.recipe, test.geometry, config);
    for (int i = first; i < 2; ++i) {
      auto frame = renderer->RenderRig(test.recipe.rigs(i), {}, {});
      ASSERT_TRUE(frame.ok()) << frame.status();
      if (i == 1) frames.push_back(*std::move(frame));
    }
  }
  for (size_t i = 1; i < frames.size(); ++i) {
    EXPECT_EQ(frames[0].left.color, frames[i].left.color);
    EXPECT_EQ(frames[0].right.color, frames[i].right.color);
  }
  config.set_cache(v1::RenderConfig::CACHE_OFF);
  auto without = *Renderer::Create(test.recipe, test.geometry, config);
  EXPECT_NE(frames[0].left.color, without->RenderRig(test.recipe.rigs(1), {}, {})->left.color);
}

TEST(RadianceCache, AFillIsCancelled) {
  TestScene test = MakeBoxRoom();
  *test.recipe.add_rigs() = BoxRoomRig(64, 48);
  const auto scene = *RenderScene::Build(test.geometry, 0);
  LightTable lights = *LightTable::Build(test.recipe, *scene);
  const CancelToken cancel;
  cancel.Cancel();
  const auto cache =
      FillRadianceCache(*scene, &lights, {}, 1, {*StereoCamera::FromRig(test.recipe.rigs(0))},
                        SmallFill(1 << 20, 0.1f), cancel);
  EXPECT_EQ(cache.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
TEST(SharedExponent, ErrsByAtMostA512thOfTheLargestChannel) {
  for (const float size : {1e-4f, 0.0371f, 0.9999f, 1.0f, 511.5f, 6e4f}) {
    for (const Vec3f& hue : {Vec3f(1, 1, 1), Vec3f(1, 0.5f, 0.001f), Vec3f(0.2f, 0, 1)}) {
      const Vec3f radiance = size * hue;
      const Vec3f kept = UnpackRadiance(PackRadiance(radiance));
      EXPECT_LE((kept - radiance).cwiseAbs().maxCoeff(), size / 512) << size;
    }
  }
}

TEST(SharedExponent, EndsAreClamped) {
  EXPECT_EQ(UnpackRadiance(PackRadiance(Vec3f::Zero())), Vec3f::Zero());
  EXPECT_EQ(UnpackRadiance(PackRadiance(Vec3f(-1, 0.5f, 0))), Vec3f(0, 0.5f, 0));
  EXPECT_EQ(UnpackRadiance(PackRadiance(Vec3f(1e9f, 65408, 0))), Vec3f(65408, 65408, 0));
  EXPECT_EQ(UnpackRadiance(PackRadiance(Vec3f::Constant(1e-12f))), Vec3f::Zero());
}

}  // namespace parallax
