#include "worker/terrain/water.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/base/rng.h"
#include "worker/terrain/ground_mesh.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

TerrainSpec SpecOf(const char* landform, uint64_t seed) {
  TerrainSpec spec = *DrawLandform(landform, Rng(SceneSeed{seed}));
  spec.region_samples = spec.site_samples = 129;
  spec.streams.steps = 12;
  spec.rain.droplets = 2000;
  return spec;
}

const Terrain& Land(const std::string& landform) {
  static const Terrain* const river = new Terrain(MakeTerrain(SpecOf("river", 3)));
  static const Terrain* const coast = new Terrain(MakeTerrain(SpecOf("coast", 5)));
  return landform == "river" ? *river : *coast;
}

TEST(Water, KindsHaveNamesAndOthersAreAnError) {
  for (const WaterKind kind : {WaterKind::kRiver, WaterKind::kSea}) {
    EXPECT_EQ(*ParseWaterKind(WaterKindName(kind)), kind);
  }
  EXPECT_EQ(ParseWaterKind("lake").status().code(), absl::StatusCode::kInvalidArgument);
}

// Beside is where FromShore says that it is.
TEST(Water, PlacesBesideTheShoreAreAsFarFromItAsTheySay) {
  for (const char* landform : {"river", "coast"}) {
    const Water& water = *Land(landform).water();
    for (float along = -300; along <= 300; along += 37) {
      for (const float away : {2.0f, 8.0f, 20.0f}) {
        for (const float side : {1.0f, -1.0f}) {
          EXPECT_NEAR(water.FromShore(water.Beside(along, away, side)), away, 0.02f * away + 0.05f)
              << landform;
        }
      }
    }
  }
}

TEST(Water, ThereIsABedBelowItAndABankBesideIt) {
  for (const char* landform : {"river", "coast"}) {
    const Terrain& land = Land(landform);
    const Water& water = *land.water();
    const float half = water.spec().kind == WaterKind::kRiver ? 0.3f * water.spec().width_m : 20.0f;
    for (float along = -300; along <= 300; along += 23) {
      EXPECT_LT(land.AboveWater(water.Beside(along, -half, 1)), -0.05f) << landform;
      EXPECT_GT(land.AboveWater(water.Beside(along, 9, 1)), 0.15f) << landform;
    }
  }
}

// No water hangs in the air or ends before the ground rises, from the path to the horizon.
TEST(Water, ItsEdgeIsUnderTheLand) {
  for (const char* landform : {"river", "coast"}) {
    const Terrain& land = Land(landform);
    const Water& water = *land.water();
    for (float along = -6000; along <= 6000; along += 211) {
      for (const float side : {1.0f, -1.0f}) {
        const Vec2f p = water.Beside(along, 8.5f, side);
        EXPECT_GT(land.Height(p, 0.5f), water.Level(p)) << landform << " at " << along;
      }
    }
  }
}

TEST(Water, ARiverFallsAlongItsCourseAndASeaIsLevel) {
  const Water& river = *Land("river").water();
  const Water& sea = *Land("coast").water();
  const auto level = [](const Water& water, float along) {
    const Vec2f p = water.Beside(along, -2, 1);
    return water.Level(p) + p.squaredNorm() / (2 * kEarthRadius_m);
  };
  EXPECT_GT(river.spec().fall, 0);
  EXPECT_NEAR(level(river, 0) - level(river, 500), 500 * river.spec().fall, 1e-2f);
  EXPECT_NEAR(level(sea, 0), level(sea, 500), 1e-3f);
}

TEST(Water, WavesStayWithinTheirBoundAndShortOnesFade) {
  for (const char* landform : {"river", "coast"}) {
    const Water& water = *Land(landform).water();
    const float away = water.spec().kind == WaterKind::kRiver ? -2.0f : -250.0f;
    float least = 1e9f, most = -1e9f;
    for (int i = 0; i < 3000; ++i) {
      const Vec2f p = water.Beside(0.37f * static_cast<float>(i), away, 1);
      const float height = water.Waves(p, 0.01f);
      least = std::min(least, height);
      most = std::max(most, height);
      EXPECT_LT(std::fabs(height), water.most_wave_m()) << landform;
      EXPECT_NEAR(water.Waves(p, 400), 0, 1e-6f);
    }
    EXPECT_GT(most - least, 0.01f) << landform << ": waves";
  }
}

TEST(Water, StrongerWindRaisesHigherWavesAndLosesMoreSlope) {
  WaterSpec spec = Land("coast").water()->spec();
  float last_wave = 0, last_slope = 0;
  for (const float wind : {1.0f, 3.0f, 8.0f}) {
    spec.wind_mps = wind;
    const Water water(spec);
    EXPECT_GT(water.most_wave_m(), last_wave);
    EXPECT_GT(water.LostSlope({0, 0}, 50), last_slope);
    last_wave = water.most_wave_m();
    last_slope = water.LostSlope({0, 0}, 50);
  }
  // Cox and Munk's mean square slope at 8 m/s is 0.044.
  EXPECT_NEAR(last_slope, 0.044f, 0.02f);
}

TEST(Water, RipplesHaveTheSlopesOfTheirHeight) {
  for (const char* landform : {"river", "coast"}) {
    const Water& water = *Land(landform).water();
    const Vec2f p = water.Beside(31, -3, 1);
    constexpr float kStep = 1e-3f;
    const auto at = [&](float dx, float dy) {
      return water.Ripples(Dual8(Splat(p.x() + dx), Splat(1), Splat(0)),
                           Dual8(Splat(p.y() + dy), Splat(0), Splat(1)), Splat(3), Splat(0.01f));
    };
    const Dual8 middle = at(0, 0);
    const float dx = (at(kStep, 0).value[0] - at(-kStep, 0).value[0]) / (2 * kStep);
    const float dy = (at(0, kStep).value[0] - at(0, -kStep).value[0]) / (2 * kStep);
    EXPECT_NEAR(middle.dx[0], dx, 0.03f) << landform;
    EXPECT_NEAR(middle.dy[0], dy, 0.03f) << landform;
    EXPECT_GT(std::fabs(dx) + std::fabs(dy), 1e-3f);
  }
}

TEST(Water, ItsMeshLiesOnTheLevelAndReachesTheHorizon) {
  const Terrain& land = Land("coast");
  const Water& water = *land.water();
  GroundMeshOptions options;
  const Vec2f eye = water.Beside(0, 5, 1);
  options.views = {{.apex = eye, .heading_rad = water.spec().direction_rad}};
  options.most_triangles = 40'000;
  const GroundMesh mesh(WaterOf(land), options);
  ASSERT_TRUE(ValidateMesh(mesh.mesh()).ok());
  float farthest = 0, inland = -1e9f;
  for (const Vec3f& p : mesh.mesh().positions) {
    EXPECT_LT(std::fabs(p.z() - water.Level(p.head<2>())), water.most_wave_m());
    farthest = std::max(farthest, (p.head<2>() - eye).norm());
    if ((p.head<2>() - eye).norm() < 150) {
      inland = std::max(inland, water.FromShore(p.head<2>()));
    }
  }
  EXPECT_GT(farthest, 20'000);
  EXPECT_LT(inland, 120) << "no water under the whole land";
  EXPECT_LT(mesh.mesh().triangles.size(), 40'001u);
}

TEST(Water, GroundThatWaterHidesIsCoarse) {
  const Terrain& land = Land("coast");
  const MeshedSurface ground = GroundOf(land);
  EXPECT_GT(ground.coarser(land.water()->Beside(0, -40, 1), 2), 1);
  EXPECT_EQ(ground.coarser(land.water()->Beside(0, 10, 1), 2), 1);
  EXPECT_EQ(ground.coarser(land.water()->Beside(0, -0.5f, 1), 2), 1) << "the bed is seen there";
}

}  // namespace
}  // namespace parallax
