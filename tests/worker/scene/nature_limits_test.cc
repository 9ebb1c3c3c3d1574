// Landscapes at the ends of their knobs: densities, numbers of walks, clearances, recipes of
// strangers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "common/math/stereo.h"
#include "tests/worker/scene/small_land.h"
#include "worker/scene/dress.h"
#include "worker/scene/types/nature/ground/expand.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/scene/types/nature/walk/arena.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using Rigs = google::protobuf::RepeatedPtrField<v1::Rig>;

// A biome's rules on its own landform, whose ground is not made.
v1::Terrain LimitedRules(const v1::Biome& biome, double density, const std::string& season,
                         uint64_t seed) {
  const Rng root(SceneSeed{seed}, "rules");
  v1::Terrain recipe;
  SetTerrainSpec(DrawLandform(biome.landform(), root.Child("land")).value(), recipe);
  recipe.set_season(season);
  BiomeDraft draft{root, season, density, {.low_m = 0, .middle_m = 20, .high_m = 60}, recipe};
  EXPECT_TRUE(WriteRules(biome, draft).ok());
  return recipe;
}

TEST(Density, EveryBiomeHasValidRulesAtEveryDensity) {
  int saturated = 0;
  for (const v1::Biome& biome : BuiltinBiomes()) {
    for (const char* season : {"summer", "winter"}) {
      for (const uint64_t seed : {1u, 2u, 3u}) {
        const v1::Terrain one = LimitedRules(biome, 1, season, seed);
        ASSERT_TRUE(CheckRules(one).ok()) << biome.name() << ": " << CheckRules(one);
        for (const double density : {0.0, 0.01, 5.0}) {
          const v1::Terrain recipe = LimitedRules(biome, density, season, seed);
          ASSERT_TRUE(CheckRules(recipe).ok()) << biome.name() << ": " << CheckRules(recipe);
          ASSERT_EQ(recipe.layers_size(), one.layers_size());
          for (int i = 0; i < one.layers_size(); ++i) {
            const double before = one.layers(i).per_m2(), after = recipe.layers(i).per_m2();
            if (after == before) continue;  // Stones.
            EXPECT_NEAR(after, std::min(density * before, kMostPerM2), 1e-9);
            saturated += after == kMostPerM2;
          }
        }
      }
    }
  }
  EXPECT_GT(saturated, 0);
}

TEST(Rules, AFormulaForAnyNumberOfSkylightsIsRefusedWithoutMakingThem) {
  v1::Biome cave = LoadBiome("cave").value();
  EXPECT_TRUE(CheckRules(LimitedRules(cave, 1, "summer", 1)).ok());
  cave.mutable_roof()->mutable_skylights()->set_formula("1000000 * 1000000");
  const v1::Terrain recipe = LimitedRules(cave, 1, "summer", 1);
  EXPECT_THAT(std::string(ToStd(CheckRules(recipe).message())), HasSubstr("roof.skylights is 65"));
}

// The ground of a recipe on coarse rasters, hardly eroded.
void MakeGroundCheap(v1::Terrain& recipe) {
  recipe.set_region_samples(65);
  recipe.set_site_samples(65);
  recipe.mutable_erosion()->set_stream_steps(2);
  recipe.mutable_erosion()->set_droplets(200);
  recipe.mutable_erosion()->set_gravity_passes(1);
}

// Single views along the x axis, 2 m above the ground.
Rigs ViewsAlongALine(const Terrain& terrain, int count, double step_m) {
  Rigs rigs;
  for (int i = 0; i < count; ++i) {
    const double x = step_m * (i - 0.5 * count);
    const float ground = terrain.Height(Vec2f(static_cast<float>(x), 0), 0.15f);
    *rigs.Add() = RigAt(Vec3d(x, 0, static_cast<double>(ground) + 2), static_cast<uint32_t>(i) + 1);
  }
  return rigs;
}

// Sixteen views of a plain at the greatest density want twice as much as there may be.
TEST(Density, OfTheDensestPlainSmallThingsAreThinnedToTheCapAndAllTreesStay) {
  v1::Terrain recipe = LimitedRules(LoadBiome("plain").value(), 5, "summer", 1);
  MakeGroundCheap(recipe);
  const auto terrain = TerrainOf(recipe).value();
  const Rigs rigs = ViewsAlongALine(*terrain, 16, 25);
  const auto expansion = ExpandTerrain(recipe, rigs);
  ASSERT_TRUE(expansion.ok()) << expansion.status();
  EXPECT_LE((*expansion)->instances.size(), kMostInstances);
  EXPECT_GT((*expansion)->instances.size(), kMostInstances - 2000);

  v1::Terrain bare = recipe;
  for (v1::ScatterLayer& layer : *bare.mutable_layers()) {
    if (!layer.index_each()) layer.set_per_m2(0);
  }
  const auto trees = ExpandTerrain(bare, rigs).value();
  size_t small = 0;
  for (int i = 0; i < recipe.layers_size(); ++i) {
    const auto layer = static_cast<size_t>(i);
    if (recipe.layers(i).index_each()) {
      EXPECT_EQ((*expansion)->of_layer[layer], trees->of_layer[layer]) << recipe.layers(i).name();
    } else {
      small += (*expansion)->of_layer[layer] > 100;
    }
  }
  EXPECT_GT(small, 3u) << "each layer gives way in proportion";
}

v1::SceneConfig WalksOf(int walks, int frames) {
  v1::SceneConfig config = LoadSceneConfig("nature").value();
  config.mutable_rigs()->set_count(frames);
  config.mutable_rigs()->set_width_px(160);
  config.mutable_rigs()->set_height_px(90);
  config.mutable_nature()->mutable_walk()->set_walks(walks);
  return config;
}

struct Placed {
  v1::Scene recipe;
  std::string why_not;
};

Placed PlaceWalks(const v1::Terrain& land, const v1::SceneConfig& config) {
  SceneInProgress scene;
  scene.seed = SceneSeed{3};
  *scene.recipe.mutable_place()->mutable_terrain() = land;
  const absl::Status status = PlaceWalkRigs(config, CancelToken(), scene);
  EXPECT_TRUE(status.ok()) << status;
  return {scene.recipe, scene.why_no_rigs};
}

// Soft swells, on which most walks are possible.
v1::Terrain Meadow() {
  v1::Terrain land = SmallLand("Pebbles", 3);
  AddLayer(land, "pebbles", 1).set_reach_m(20);
  return land;
}

TEST(Walks, OneFiveOrFiftyShareTheFrames) {
  const struct { int walks, frames, of_each; } cases[] = {{1, 4, 4}, {5, 10, 2}, {50, 50, 1}};
  for (const auto& c : cases) {
    const Placed placed = PlaceWalks(Meadow(), WalksOf(c.walks, c.frames));
    ASSERT_EQ(placed.recipe.rigs_size(), c.frames) << c.walks << ": " << placed.why_not;
    for (int i = 0; i < c.frames; ++i) {
      EXPECT_EQ(placed.recipe.rigs(i).path(), static_cast<uint32_t>(i / c.of_each) + 1);
    }
  }
}

TEST(Walks, FramesThatDoNotDivideAreSharedEvenly) {
  const Placed placed = PlaceWalks(Meadow(), WalksOf(7, 10));
  ASSERT_EQ(placed.recipe.rigs_size(), 10) << placed.why_not;
  std::vector<int> frames(7);
  for (const v1::Rig& rig : placed.recipe.rigs()) ++frames.at(rig.path() - 1);
  EXPECT_EQ(frames, (std::vector<int>{2, 2, 2, 1, 1, 1, 1}));
}

// A job may bring a layout of somebody's.
TEST(Walks, ALayoutOutOfBoundsIsAnErrorBeforeAnythingIsMade) {
  SceneInProgress scene;
  scene.seed = SceneSeed{3};
  v1::Terrain& land = *scene.recipe.mutable_place()->mutable_terrain();
  land = Meadow();
  land.mutable_layers(0)->set_prototypes(0, 1u << 30);
  const absl::Status status = PlaceWalkRigs(WalksOf(1, 2), CancelToken(), scene);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ToStd(status.message())), HasSubstr("layer \"pebbles\""));
}

// Half of the walks are blocked by stones that have no index: the place where the right eye would
// stand at the largest baseline is not kept clear of them.
TEST(Walks, WalksThatStonesBlockGiveWayToOthers) {
  v1::Terrain land = SmallLand("Boulder", 3);
  v1::ScatterLayer& stones = AddLayer(land, "stones", 0.3);
  stones.set_size_low(1.0);
  stones.set_size_high(1.2);
  stones.set_reach_m(20);
  v1::SceneConfig config = WalksOf(8, 8);
  config.mutable_rigs()->set_clearance_baseline_m(2);
  config.mutable_rigs()->mutable_baseline_m()->set_constant(0.075);
  config.mutable_rigs()->mutable_altitude_m()->set_constant(0.8);
  const Placed placed = PlaceWalks(land, config);
  EXPECT_EQ(placed.recipe.rigs_size(), 8) << placed.why_not;
}

TEST(Walks, ASeedWithoutEnoughSaysHowManyWereFound) {
  v1::SceneConfig config = WalksOf(3, 6);
  config.mutable_nature()->mutable_walk()->set_clearance_m(5);
  const Placed placed = PlaceWalks(Meadow(), config);
  EXPECT_EQ(placed.recipe.rigs_size(), 0);
  EXPECT_THAT(placed.why_not, HasSubstr("0 of 3 walks found"));
  EXPECT_THAT(placed.why_not, HasSubstr("blocked"));
}

// It would be too much on every worker: a rejected seed, not an error that is tried again.
TEST(Walks, ASeedAroundWhichTooMuchWouldStandIsRejected) {
  v1::Terrain land = SmallLand("Pebbles", 3);
  AddLayer(land, "gravel", kMostPerM2).set_reach_m(1500);
  const Placed placed = PlaceWalks(land, WalksOf(2, 4));
  EXPECT_EQ(placed.recipe.rigs_size(), 0);
  EXPECT_THAT(placed.why_not, HasSubstr("2 of 2 walks found"));
  EXPECT_THAT(placed.why_not, HasSubstr("layer \"gravel\""));
}

TEST(Clearance, PlantsWithoutAnIndexKeepAsFarAwayAsTheWalkSays) {
  v1::Terrain land = SmallLand("Boulder", 3);
  v1::ScatterLayer& stones = AddLayer(land, "stones", 0.1);
  stones.set_size_low(1.5);
  stones.set_size_high(2.5);
  stones.set_reach_m(20);
  v1::SceneConfig config = WalksOf(2, 4);
  config.mutable_rigs()->mutable_altitude_m()->set_constant(2.6);
  config.mutable_nature()->mutable_walk()->set_clearance_m(1.6);
  const Placed placed = PlaceWalks(land, config);
  ASSERT_EQ(placed.recipe.rigs_size(), 4) << placed.why_not;
  const v1::Terrain& made = placed.recipe.place().terrain();
  EXPECT_NEAR(made.clearance_m(), 1.6, 0.05);
  EXPECT_EQ(made.clearance_baseline_m(), config.rigs().clearance_baseline_m());
  const auto expansion = ExpandTerrain(made, placed.recipe.rigs()).value();
  EXPECT_GT(expansion->instances.size(), 20u);
  const auto nearby = MakeNearby(made, *expansion, placed.recipe.rigs(), 4).value();
  for (const v1::Rig& rig : placed.recipe.rigs()) {
    for (int k = 0; k <= 10; ++k) {
      const Vec3d eye = EyePosition(rig, 0) + k / 10.0 * 0.5 * RigAxes(rig).col(0);
      EXPECT_GE(nearby->NearestDistance(eye.cast<float>(), 3), 1.6f);
    }
  }
}

TEST(Clearance, OrdinaryOnesLeaveTheRecipeAsItWas) {
  for (const double clearance_m : {0.05, 0.35, 0.39}) {
    v1::SceneConfig config = WalksOf(1, 2);
    config.mutable_nature()->mutable_walk()->set_clearance_m(clearance_m);
    const v1::Terrain land = Meadow();
    const Placed placed = PlaceWalks(land, config);
    EXPECT_EQ(placed.recipe.place().terrain().SerializeAsString(), land.SerializeAsString());
  }
}

// Number of things whose origin is within 0.25 m of a place.
int CountAt(const Expansion& expansion, const Vec2f& place) {
  return static_cast<int>(std::count_if(
      expansion.instances.begin(), expansion.instances.end(), [&](const Instance& instance) {
        return (instance.world_from_object.col(3).head<2>() - place).norm() < 0.25f;
      }));
}

TEST(Expansion, GrassIsLeftOutBetweenFramesOfOneWalkOnly) {
  v1::Terrain land = SmallLand("GrassTuft", 3);
  land.set_roughness(0);
  AddLayer(land, "grass", 50).set_reach_m(10);
  const auto terrain = TerrainOf(land).value();
  const auto between = [&](double step_m, uint32_t second_path) {
    const Vec3d first(0, 0, static_cast<double>(terrain->Height(Vec2f::Zero(), 0.15f)) + 0.3);
    const auto x = static_cast<float>(step_m);
    const Vec3d second(step_m, 0, static_cast<double>(terrain->Height(Vec2f(x, 0), 0.15f)) + 0.3);
    Rigs rigs;
    *rigs.Add() = RigAt(first, 1);
    *rigs.Add() = RigAt(second, second_path);
    return CountAt(*ExpandTerrain(land, rigs).value(), Vec2f(0.5f * x, 0));
  };
  EXPECT_EQ(between(3, 1), 0) << "5 s between frames, the documented study, are one walk";
  EXPECT_GT(between(3, 2), 0);
  EXPECT_GT(between(1.9, 2), 0) << "another walk begins nearby";
}

// A cave on small rasters, and a rig in it.
v1::Terrain SmallCave() {
  TerrainSpec spec = *DrawLandform("cave", Rng(SceneSeed{3}));
  spec.region_samples = spec.site_samples = 65;
  spec.site_m = 300;
  spec.streams.steps = 2;
  spec.rain.droplets = 200;
  v1::Terrain recipe;
  SetTerrainSpec(spec, recipe);
  recipe.add_ground();
  v1::CaveRoof& roof = *recipe.mutable_roof();
  roof.set_rise_m(8);
  roof.set_spring_m(2.5);
  roof.set_reach_m(20);
  roof.set_half_length_m(30);
  roof.set_object_index(2);
  return recipe;
}

TEST(Expansion, ItsHashCoversTheGroundAndTheRoof) {
  const auto hash_of = [](const v1::Terrain& recipe) {
    Rigs rigs;
    *rigs.Add() = RigAt(Vec3d(0, 0, 3), 1);
    return ExpandTerrain(recipe, rigs).value()->hash;
  };
  v1::Terrain ground = SmallLand();
  const uint64_t smooth = hash_of(ground);
  EXPECT_EQ(hash_of(SmallLand()), smooth);
  ground.set_roughness(1.5 * ground.roughness());
  EXPECT_NE(hash_of(ground), smooth);

  v1::Terrain cave = SmallCave();
  const uint64_t low = hash_of(cave);
  cave.mutable_roof()->set_rise_m(8.5);
  EXPECT_NE(hash_of(cave), low) << "the ground is the same";
}

TEST(Expansion, RecipesThatWouldTakeAllMemoryAreRefused) {
  v1::Terrain land = SmallLand();
  AddLayer(land, "grass", 60).set_reach_m(3000);
  Rigs rigs;
  *rigs.Add() = RigAt(Vec3d(0, 0, 3), 1);
  const absl::Status many = ExpandTerrain(land, rigs).status();
  EXPECT_EQ(many.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(ToStd(many.message())), HasSubstr("layer \"grass\""));
  for (const double x : {1e9, std::numeric_limits<double>::quiet_NaN()}) {
    rigs.Mutable(0)->mutable_world_from_left()->set_tx(x);
    const absl::Status far = ExpandTerrain(SmallLand(), rigs).status();
    EXPECT_EQ(far.code(), absl::StatusCode::kInvalidArgument) << x;
    EXPECT_THAT(std::string(ToStd(far.message())), HasSubstr("rig 0"));
  }
}

}  // namespace
}  // namespace parallax
