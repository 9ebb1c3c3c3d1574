#include "worker/scene/types/nature/nature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "common/math/stereo.h"
#include "common/math/sun.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/nature/ground/expand.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/scene/types/nature/walk/arena.h"
#include "worker/scene/types/nature/walk/sight.h"

namespace parallax {
namespace {

v1::SceneConfig SmallNature(const std::string& biome) {
  v1::SceneConfig config = LoadSceneConfig("nature").value();
  v1::BiomeWeights& weights = *config.mutable_nature()->mutable_biomes();
  // Each field of BiomeWeights is named as its biome.
  const auto* fields = weights.GetDescriptor();
  for (int k = 0; k < fields->field_count(); ++k) {
    weights.GetReflection()->SetDouble(&weights, fields->field(k),
                                       fields->field(k)->name() == biome);
  }
  config.mutable_rigs()->set_count(6);
  config.mutable_rigs()->set_width_px(320);
  config.mutable_rigs()->set_height_px(180);
  return config;
}

v1::SolveResult SolveFor(const v1::SceneConfig& config, uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = config;
  auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

// Made once: a landscape takes seconds.
const v1::Scene& Plain() {
  static const v1::Scene& scene = *new v1::Scene([] {
    for (uint64_t seed = 1;; ++seed) {
      const v1::SolveResult result = SolveFor(SmallNature("plain"), seed);
      if (result.has_scene()) return result.scene();
    }
  }());
  return scene;
}

TEST(Nature, ARecipeOfRulesIsSmallAndSaysWhatItExpandsTo) {
  const v1::Scene& scene = Plain();
  const v1::Terrain& land = scene.place().terrain();
  EXPECT_EQ(land.biome(), "plain");
  EXPECT_LE(scene.ByteSizeLong(), 64u << 10);
  EXPECT_NE(land.expansion_hash(), 0u);
  EXPECT_GT(land.instances(), 1000u);
  EXPECT_EQ(scene.rigs_size(), 6);
}

TEST(Nature, ExpansionIsTheSameOnAnyNumberOfThreads) {
  v1::Terrain land = Plain().place().terrain();
  for (const int threads : {1, 2, 16}) {
    // A seed of nothing but the memo's key: each is expanded anew.
    land.set_placed_triangles(static_cast<uint64_t>(threads));
    tbb::global_control most(tbb::global_control::max_allowed_parallelism,
                             static_cast<size_t>(threads));
    tbb::task_arena(threads).execute([&] {
      const auto expansion = ExpandTerrain(land, Plain().rigs());
      ASSERT_TRUE(expansion.ok()) << expansion.status();
      EXPECT_EQ((*expansion)->hash, land.expansion_hash());
      EXPECT_EQ((*expansion)->instances.size(), land.instances());
    });
  }
}

TEST(Nature, AWorkerThatExpandsToSomethingElseFails) {
  v1::Scene scene = Plain();
  EXPECT_TRUE(BuildSceneGeometry(scene).ok());
  v1::Terrain& land = *scene.mutable_place()->mutable_terrain();
  land.mutable_layers(land.layers_size() - 1)->set_seed(1);
  const absl::Status status = BuildSceneGeometry(scene).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("expansion"));
}

TEST(Nature, BothEyesStayClearOfEverythingAtTheLargestBaseline) {
  const v1::Scene& scene = Plain();
  const v1::SceneConfig config = SmallNature("plain");
  const auto expansion = ExpandTerrain(scene.place().terrain(), scene.rigs()).value();
  const auto nearby = MakeNearby(scene.place().terrain(), *expansion, scene.rigs(), 1).value();
  const double clearance = config.nature().walk().clearance_m();
  for (const v1::Rig& rig : scene.rigs()) {
    for (int k = 0; k <= 10; ++k) {
      const Vec3d eye = EyePosition(rig, 0) +
                        k / 10.0 * config.rigs().clearance_baseline_m() * RigAxes(rig).col(0);
      EXPECT_GE(static_cast<double>(nearby->NearestDistance(eye.cast<float>(), 2)),
                clearance - 0.01);
    }
  }
}

TEST(Nature, AWalkKeepsItsSpeedItsLensAndItsBaseline) {
  const v1::Scene& scene = Plain();
  const v1::SceneConfig config = SmallNature("plain");
  const auto& speed = config.nature().walk().speed_mps().uniform();
  for (int i = 0; i + 1 < scene.rigs_size(); ++i) {
    const v1::Rig &a = scene.rigs(i), &b = scene.rigs(i + 1);
    EXPECT_EQ(a.baseline_m(), b.baseline_m());
    EXPECT_EQ(a.fx_px(), b.fx_px());
    const double step = (EyePosition(b, 0) - EyePosition(a, 0)).head<2>().norm();
    EXPECT_GT(step * config.nature().walk().fps(), 0.8 * speed.low());
    EXPECT_LT(step * config.nature().walk().fps(), 1.2 * speed.high());
  }
  EXPECT_GE(scene.rigs(0).baseline_m(), 0.075);
  EXPECT_LE(scene.rigs(0).baseline_m(), 0.5);
}

// High above a valley, thin haze at the eye must not be fog below.
TEST(Nature, HazeIsAtMostETimesAsThickInTheLowestValley) {
  const v1::Scene& scene = Plain();
  const auto terrain = TerrainOf(scene.place().terrain()).value();
  const std::vector<float>& heights = terrain->region().values;
  const double low_m = *std::min_element(heights.begin(), heights.end());
  const double eye_m = scene.rigs(0).world_from_left().tz();
  EXPECT_GE(scene.air().scale_height_m(), eye_m - low_m);
  EXPECT_GE(scene.air().scale_height_m(), 120);
}

TEST(Nature, HazeLeavesHalfOfTheLightOfTheMedianGround) {
  v1::SceneConfig config = SmallNature("plain");
  config.mutable_nature()->mutable_haze_per_m()->mutable_uniform()->set_low(0.5);
  config.mutable_nature()->mutable_haze_per_m()->mutable_uniform()->set_high(0.5);
  const v1::SolveResult result = SolveFor(config, Plain().scene_seed());
  ASSERT_TRUE(result.has_scene());
  const v1::Scene& scene = result.scene();
  const auto terrain = TerrainOf(scene.place().terrain()).value();
  const double sight_m = Sight(*terrain, scene.rigs()).median_m();
  const double eye_m = scene.rigs(0).world_from_left().tz();
  const double at_eye = scene.air().haze_per_m() * std::exp(-eye_m / scene.air().scale_height_m());
  EXPECT_NEAR(std::exp(-at_eye * sight_m), 0.5, 0.01);
}

// From 10 m above a plane, a narrow view 30 degrees down meets it after about 20 m. Any sun above
// the horizon lights all of it.
TEST(Nature, SightIsOfThePlaneBelow) {
  TerrainSpec flat;
  flat.region_samples = flat.site_samples = 33;
  flat.streams.steps = 0;
  flat.rain.droplets = 0;
  flat.roughness = 0;
  v1::Scene scene;
  v1::Rig rig = Plain().rigs(0);
  const Eigen::Matrix3d axes = CameraAxes(0.3, std::numbers::pi / 3);
  *rig.mutable_world_from_left() =
      ToProto(Pose{Vec3d(0, 0, 10), Eigen::Quaterniond(axes).normalized(), 1.0});
  *scene.add_rigs() = rig;
  const Terrain plane = MakeTerrain(flat);
  const Sight sight(plane, scene.rigs());
  EXPECT_NEAR(sight.median_m(), 20, 3);
  EXPECT_EQ(sight.SunlitShare(Vec3d(-1, 0.2, 0.2).normalized()), 1);
  EXPECT_EQ(sight.SunlitShare(Vec3d(1, 0.2, -0.2).normalized()), 0);
}

// A low sun stands on a side from which it reaches into a gorge.
TEST(Nature, TheSunStandsWhereItLightsTheSight) {
  v1::SceneConfig config = SmallNature("canyon");
  config.mutable_nature()->mutable_sun_elevation_deg()->set_constant(15);
  int sunny = 0;
  for (const uint64_t seed : {1u, 2u, 3u, 4u}) {
    const v1::SolveResult result = SolveFor(config, seed);
    if (!result.has_scene() || result.scene().sky().sun_strength() == 0) continue;
    const v1::Scene& scene = result.scene();
    const auto terrain = TerrainOf(scene.place().terrain()).value();
    const Sight sight(*terrain, scene.rigs());
    const double here = sight.SunlitShare(SunDirection(scene.sky()));
    double mean = 0;
    for (int k = 0; k < 12; ++k) {
      v1::Sky turned = scene.sky();
      turned.set_sun_azimuth_rad(k * std::numbers::pi / 6);
      mean += sight.SunlitShare(SunDirection(turned)) / 12;
    }
    EXPECT_TRUE(here >= 0.7 || here > mean) << "seed " << seed << ": " << here << ", " << mean;
    sunny += here < 1 || mean < 1 ? 1 : 0;
  }
  EXPECT_GT(sunny, 0) << "no seed tests anything";
}

TEST(Nature, EveryInstanceHasAnObjectThatTheRecipeKnows) {
  const v1::Scene& scene = Plain();
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  ASSERT_EQ(geometry.instances.size(), scene.place().terrain().instances());
  std::set<uint32_t> indices;
  for (const Instance& instance : geometry.instances) indices.insert(instance.object_index);
  for (const uint32_t index : indices) {
    const auto object = kNatureScenes.grown(scene, index);
    ASSERT_TRUE(object.has_value()) << index;
    EXPECT_FALSE(object->asset_class().empty());
    EXPECT_NE(object->role(), v1::OBJECT_ROLE_UNSPECIFIED);
  }
  EXPECT_FALSE(kNatureScenes.grown(scene, 0).has_value());
  EXPECT_FALSE(kNatureScenes.grown(scene, kGroundIndex).has_value()) << "is in the recipe";
  EXPECT_FALSE(kNatureScenes.grown(scene, 65000).has_value());
}

// The rim of a thing's base is in the ground, or lies flat on it.
void ExpectRooted(const v1::ScatterLayer& layer, const Instance& instance,
                  const GroundMesh& ground) {
  if (layer.hangs() || layer.floats()) return;
  const auto r = static_cast<float>(std::max(0.02, 0.5 * layer.claim_m()));
  for (const Vec3f& p : {Vec3f(r, 0, 0), Vec3f(-r, 0, 0), Vec3f(0, r, 0), Vec3f(0, -r, 0)}) {
    const Vec3f at = instance.Affine() * p;
    EXPECT_LE(at.z(), ground.HeightAt(at.head<2>()) + 0.005f) << layer.name();
  }
}

TEST(Nature, NothingStandsOnDaylight) {
  const v1::Scene& scene = Plain();
  const auto expansion = ExpandTerrain(scene.place().terrain(), scene.rigs()).value();
  size_t index = 0;
  for (int l = 0; l < scene.place().terrain().layers_size(); ++l) {
    const v1::ScatterLayer& layer = scene.place().terrain().layers(l);
    for (uint32_t k = 0; k < expansion->of_layer[static_cast<size_t>(l)]; ++k, ++index) {
      ExpectRooted(layer, expansion->instances[index], expansion->ground);
    }
  }
}

// The landscapes of dry lands, of snow and of caves: what each is for, and what all must hold.
class DryLands : public testing::TestWithParam<const char*> {
 protected:
  // The first seed that has a walk.
  static v1::Scene SceneOf(const std::string& biome) {
    int rejected = 0;
    for (uint64_t seed = 1;; ++seed) {
      const v1::SolveResult result = SolveFor(SmallNature(biome), seed);
      if (result.has_scene()) return result.scene();
      EXPECT_LT(++rejected, 3) << result.rejected().reason();
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Nature, DryLands,
                         testing::Values("desert", "snowy_mountain", "canyon", "cliff", "cave"));

TEST_P(DryLands, ExpandAlikeStandOnTheirGroundAndKeepTheWalkClear) {
  const v1::Scene scene = SceneOf(GetParam());
  v1::Terrain land = scene.place().terrain();
  EXPECT_EQ(land.biome(), GetParam());
  EXPECT_LE(scene.ByteSizeLong(), 64u << 10);
  EXPECT_EQ(land.has_snow(), land.biome() == "snowy_mountain");
  EXPECT_EQ(land.has_roof(), land.biome() == "cave");
  std::shared_ptr<const Expansion> expansion;
  for (const int threads : {1, 2, 16}) {
    land.set_placed_triangles(static_cast<uint64_t>(threads));
    tbb::global_control most(tbb::global_control::max_allowed_parallelism,
                             static_cast<size_t>(threads));
    tbb::task_arena(threads).execute(
        [&] { expansion = ExpandTerrain(land, scene.rigs()).value(); });
    EXPECT_EQ(expansion->hash, land.expansion_hash());
  }
  size_t index = 0;
  for (int l = 0; l < land.layers_size(); ++l) {
    const v1::ScatterLayer& layer = land.layers(l);
    for (uint32_t k = 0; k < expansion->of_layer[static_cast<size_t>(l)]; ++k, ++index) {
      const Vec3f at = expansion->instances[index].Affine().translation();
      if (layer.hangs()) {
        const auto ceiling = expansion->roof->CeilingAt(at.head<2>());
        ASSERT_TRUE(ceiling.has_value());
        EXPECT_GE(at.z(), *ceiling - 0.01f) << layer.name();
        continue;
      }
      ExpectRooted(layer, expansion->instances[index], expansion->ground);
    }
  }
  const auto nearby = MakeNearby(land, *expansion, scene.rigs(), 1).value();
  const v1::SceneConfig config = SmallNature(GetParam());
  for (const v1::Rig& rig : scene.rigs()) {
    for (int k = 0; k <= 5; ++k) {
      const Vec3d eye = EyePosition(rig, 0) +
                        k / 5.0 * config.rigs().clearance_baseline_m() * RigAxes(rig).col(0);
      EXPECT_GE(static_cast<double>(nearby->NearestDistance(eye.cast<float>(), 2)),
                config.nature().walk().clearance_m() - 0.01);
    }
  }
}

TEST(Nature, WeightsOfBiomesChooseAndAllZeroIsAnError) {
  v1::SceneConfig config = SmallNature("none");
  const absl::Status status = kNatureScenes.layout(config, SceneSeed{1}, CancelToken()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(FindBiome(config.nature(), "reef"), nullptr);
}

}  // namespace
}  // namespace parallax
