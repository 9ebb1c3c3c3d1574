#include "worker/terrain/terrain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

// Small rasters: a test need not wait for a whole landscape.
TerrainSpec SmallSpec(std::string_view landform, uint64_t seed) {
  TerrainSpec spec = *DrawLandform(landform, Rng(SceneSeed{seed}));
  spec.region_samples = 129;
  spec.site_samples = 129;
  spec.streams.steps = 12;
  spec.rain.droplets = 2000;
  spec.gravity.passes = 4;
  return spec;
}

TEST(Terrain, TheSameSpecGivesTheSameBitsAndAnotherSeedOthers) {
  const Terrain a = MakeTerrain(SmallSpec("mountains", 1)),
                b = MakeTerrain(SmallSpec("mountains", 1)),
                c = MakeTerrain(SmallSpec("mountains", 2));
  EXPECT_EQ(a.site().values, b.site().values);
  EXPECT_EQ(a.Height({3.5f, -20}, 0.02f), b.Height({3.5f, -20}, 0.02f));
  EXPECT_NE(a.site().values, c.site().values);
}

TEST(Terrain, HeightIsContinuousFromTheSiteToTheHorizon) {
  for (const char* landform : {"hills", "desert", "canyon", "cliff", "snowy mountains"}) {
    const Terrain terrain = MakeTerrain(SmallSpec(landform, 4));
    for (float x = 0; x < 12'000; x += 3.7f) {
      const float here = terrain.Height({x, 0.3f * x}, 2.0f);
      const float there = terrain.Height({x + 0.01f, 0.3f * x}, 2.0f);
      ASSERT_NEAR(here, there, 0.5f) << landform << " " << x;
    }
  }
}

TEST(Terrain, AFinerFootprintAddsDetailAndKeepsTheForm) {
  const Terrain terrain = MakeTerrain(SmallSpec("hills", 4));
  double difference = 0, steps = 0;
  for (float x = -200; x < 200; x += 1) {
    const float fine = terrain.Height({x, 17}, 0.02f), coarse = terrain.Height({x, 17}, 4.0f);
    difference = std::max(difference, std::fabs(static_cast<double>(fine - coarse)));
    steps += std::fabs(terrain.Height({x + 0.1f, 17}, 0.02f) - fine);
  }
  EXPECT_LT(difference, 2.0);
  EXPECT_GT(difference, 0.02);
  EXPECT_GT(steps, 0);
}

// Rock between the region's samples, beyond the site: without crags, far mountains look molten.
TEST(Terrain, FarRockHasCragsAndTheSiteKeepsItsErodedForm) {
  const auto rough = [](const Terrain& terrain, float least_m, float most_m) {
    double squares = 0;
    int count = 0;
    for (float x = -most_m; x <= most_m; x += 37) {
      for (float y = -most_m; y <= most_m; y += 37) {
        const Vec2f p(x, y);
        if (p.cwiseAbs().maxCoeff() < least_m || terrain.Steepness(p) < 0.8f) continue;
        const double finer = terrain.Height(p, 12) - terrain.Height(p, 300);
        squares += finer * finer;
        ++count;
      }
    }
    return count < 20 ? -1 : std::sqrt(squares / count);
  };
  TerrainSpec spec = *DrawLandform("mountains", Rng(SceneSeed{4}));
  spec.rain.droplets = 2000;
  const Terrain terrain = MakeTerrain(spec);
  EXPECT_EQ(rough(terrain, 0, 0.7f * 768), 0);
  const double far = rough(terrain, 768, 2500);
  EXPECT_GT(far, 1.5);
  EXPECT_LT(far, 15);
}

TEST(Terrain, TheEarthFallsAwayTowardsTheHorizon) {
  TerrainSpec flat;
  flat.region_samples = flat.site_samples = 33;
  flat.streams.steps = 0;
  flat.rain.droplets = 0;
  flat.roughness = 0;
  const Terrain terrain = MakeTerrain(flat);
  EXPECT_NEAR(terrain.Height({0, 0}, 1), 0, 1e-4);
  EXPECT_NEAR(terrain.Height({10'000, 0}, 1), -7.848, 0.01);  // r^2 / 2R
}

TEST(Terrain, MountainsAreSteeperThanHillsAndHillsThanPlains) {
  const auto mean_slope = [](std::string_view landform) {
    double sum = 0;
    for (uint64_t seed = 0; seed < 4; ++seed) {
      const Terrain terrain = MakeTerrain(SmallSpec(landform, seed));
      for (float x = -400; x <= 400; x += 50) {
        for (float y = -400; y <= 400; y += 50) sum += terrain.Steepness({x, y});
      }
    }
    return sum;
  };
  const double plain = mean_slope("plain"), hills = mean_slope("hills"),
               mountains = mean_slope("mountains");
  EXPECT_LT(2 * plain, mountains);
  EXPECT_LT(plain, hills);
  EXPECT_LT(hills, mountains);
}

TEST(Landforms, AnUnknownNameIsAnErrorThatListsTheKnownOnes) {
  const auto spec = DrawLandform("moon", Rng(SceneSeed{1}));
  ASSERT_FALSE(spec.ok());
  EXPECT_EQ(
      std::string(spec.status().message()),
      "there is no landform \"moon\": allowed are arctic, canyon, cave, cliff, coast, desert, "
      "hills, mountains, plain, river, snowy mountains");
}

}  // namespace
}  // namespace parallax
