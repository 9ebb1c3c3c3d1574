// Landscapes with water: nothing stands in it that should not, walks stay dry, workers agree.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "common/math/stereo.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/nature/ground/beach_tint.h"
#include "worker/scene/types/nature/ground/expand.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

v1::SceneConfig Only(const std::string& biome) {
  v1::SceneConfig config = LoadSceneConfig("nature").value();
  v1::BiomeWeights& weights = *config.mutable_nature()->mutable_biomes();
  const auto* fields = weights.GetDescriptor();
  for (int k = 0; k < fields->field_count(); ++k) {
    weights.GetReflection()->SetDouble(&weights, fields->field(k),
                                       fields->field(k)->name() == biome);
  }
  config.mutable_rigs()->set_count(4);
  config.mutable_rigs()->set_width_px(160);
  config.mutable_rigs()->set_height_px(90);
  return config;
}

// Made once each: a landscape takes seconds.
const v1::Scene& WaterScene(const std::string& biome) {
  static std::map<std::string, v1::Scene>& scenes = *new std::map<std::string, v1::Scene>;
  const auto found = scenes.find(biome);
  if (found != scenes.end()) return found->second;
  for (uint64_t seed = 1;; ++seed) {
    v1::SolveJob job;
    job.set_scene_seed(seed);
    *job.mutable_config() = Only(biome);
    const auto result = Solve(job, CancelToken());
    EXPECT_TRUE(result.ok()) << result.status();
    if (result->has_scene()) return scenes[biome] = result->scene();
  }
}

class NatureWater : public testing::TestWithParam<const char*> {
 protected:
  const v1::Scene& scene() const { return WaterScene(GetParam()); }
  const v1::Terrain& land() const { return scene().place().terrain(); }
  std::shared_ptr<const Expansion> Expanded() const {
    return ExpandTerrain(land(), scene().rigs()).value();
  }
};

INSTANTIATE_TEST_SUITE_P(Biomes, NatureWater, testing::Values("arctic", "coast", "river"));

TEST_P(NatureWater, IsAnObjectOfItsOwnRole) {
  ASSERT_TRUE(land().has_water());
  ASSERT_EQ(scene().objects_size(), 2);
  const v1::SceneObject& water = scene().objects(1);
  EXPECT_EQ(water.index(), land().water().object_index());
  EXPECT_EQ(water.role(), v1::OBJECT_ROLE_WATER);
  ASSERT_EQ(water.materials_size(), 1);
  EXPECT_EQ(water.materials(0).material_index(), land().water().material_index());
  for (const v1::ScatterLayer& layer : land().layers()) {
    EXPECT_GT(layer.first_object_index(), water.index()) << layer.name();
  }
}

TEST_P(NatureWater, ExpandsAlikeOnAnyNumberOfThreadsAndItsWavesCount) {
  v1::Terrain land = this->land();
  const auto first = Expanded();
  EXPECT_EQ(first->hash, land.expansion_hash());
  for (const int threads : {1, 16}) {
    // A seed of nothing but the memo's key: each is expanded anew.
    land.set_placed_triangles(static_cast<uint64_t>(threads));
    tbb::global_control most(tbb::global_control::max_allowed_parallelism,
                             static_cast<size_t>(threads));
    tbb::task_arena(threads).execute([&] {
      const auto again = ExpandTerrain(land, scene().rigs());
      ASSERT_TRUE(again.ok()) << again.status();
      EXPECT_EQ((*again)->hash, land.expansion_hash());
      ASSERT_EQ((*again)->water->positions.size(), first->water->positions.size());
      EXPECT_TRUE(std::equal(first->water->positions.begin(), first->water->positions.end(),
                             (*again)->water->positions.begin()));
    });
  }
  // Other waves are another expansion, where the mesh shows any.
  v1::Scene windy = scene();
  v1::Water& water = *windy.mutable_place()->mutable_terrain()->mutable_water();
  water.set_wind_mps(water.wind_mps() + 2);
  const auto other = ExpandTerrain(windy.place().terrain(), windy.rigs()).value();
  const bool same = std::equal(first->water->positions.begin(), first->water->positions.end(),
                               other->water->positions.begin(), [](const Vec3f& a, const Vec3f& b) {
                                 return std::lround(1000 * a.z()) == std::lround(1000 * b.z());
                               });
  EXPECT_EQ(same, other->hash == first->hash);
  EXPECT_FALSE(same && water.kind() == "sea");
  EXPECT_EQ(BuildSceneGeometry(windy).status().code(),
            same ? absl::StatusCode::kOk : absl::StatusCode::kInternal);
}

TEST_P(NatureWater, ThingsStandAsFarAboveItAsTheirLayersSay) {
  const auto expansion = Expanded();
  const Terrain& terrain = *expansion->terrain;
  size_t index = 0, dry = 0;
  for (int l = 0; l < land().layers_size(); ++l) {
    const v1::ScatterLayer& layer = land().layers(l);
    const v1::SoftRange& above = layer.mask().above_water_m();
    const bool plant = land().prototypes(static_cast<int>(layer.prototypes(0))).role() ==
                       v1::OBJECT_ROLE_VEGETATION;
    if (plant && layer.near_parents_m() <= 0) {
      EXPECT_NE(above.high(), 0) << layer.name() << ": grows anywhere";
    }
    for (uint32_t k = 0; k < expansion->of_layer[static_cast<size_t>(l)]; ++k, ++index) {
      const Vec2f p = expansion->instances[index].world_from_object.col(3).head<2>();
      const auto height = static_cast<double>(terrain.AboveWater(p));
      if (above.high() != 0) {
        EXPECT_GE(height, above.low() - above.soft() - 0.01) << layer.name();
        EXPECT_LE(height, above.high() + above.soft() + 0.01) << layer.name();
      }
      dry += height > 0;
      // Reeds alone grow in it.
      if (plant && layer.name() != "reeds") {
        EXPECT_GT(height, 0) << layer.name();
      }
      if (layer.floats() && height < -0.5) {
        EXPECT_NEAR(expansion->instances[index].world_from_object(2, 3), terrain.water()->Level(p),
                    1.2 * layer.sink_m() * layer.size_high() + 0.01)
            << layer.name();
      }
    }
  }
  EXPECT_GT(dry, 100u);
}

TEST_P(NatureWater, WalksStayDryAndAboveItsWaves) {
  const auto expansion = Expanded();
  const Terrain& terrain = *expansion->terrain;
  for (const v1::Rig& rig : scene().rigs()) {
    EXPECT_GE(terrain.AboveWater(EyePosition(rig, 0).head<2>().cast<float>()), 0.1f);
    for (const int eye : {0, 1}) {
      const Vec3f at = EyePosition(rig, eye).cast<float>();
      EXPECT_GT(at.z(), terrain.water()->Level(at.head<2>()) +
                            terrain.water()->Waves(at.head<2>(), 0.05f) + 0.3f);
    }
  }
}

TEST_P(NatureWater, ItsMeshCoversEveryPlaceThatIsWet) {
  const auto expansion = Expanded();
  const Water& water = *expansion->terrain->water();
  RayScene surface;
  surface.Add(*expansion->water, Eigen::Affine3f::Identity());
  surface.Commit();
  for (float along = -700; along <= 700; along += 37) {
    for (const float from_shore : {3.0f, -0.5f, -2.0f}) {
      const Vec2f p = water.Beside(along, from_shore, 1);
      const Vec3f above(p.x(), p.y(), water.Level(p) + 50);
      const auto hit = surface.Intersect(above, -Vec3f::UnitZ());
      ASSERT_TRUE(hit.has_value()) << p.transpose();
      EXPECT_NEAR(hit->distance, 50, water.most_wave_m());
    }
  }
}

TEST(NatureWaterRecipe, WaterThatNobodyCanMakeIsAnError) {
  v1::Terrain land = WaterScene("river").place().terrain();
  EXPECT_TRUE(TerrainSpecOf(land).ok());
  const auto broken = [&](auto change) {
    v1::Terrain copy = land;
    change(*copy.mutable_water());
    return TerrainSpecOf(copy).status();
  };
  for (const absl::Status& status : {broken([](v1::Water& w) { w.set_kind("lake"); }),
                                     broken([](v1::Water& w) { w.set_bend_m(0); }),
                                     broken([](v1::Water& w) { w.set_swing_m(w.bend_m()); }),
                                     broken([](v1::Water& w) { w.set_clarity_m(0); }),
                                     broken([](v1::Water& w) { w.set_wind_mps(std::nan("")); })}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr("water"));
  }
}

TEST(NatureBiomes, EachReadsTheWeightOfItsName) {
  const auto* fields = v1::BiomeWeights::descriptor();
  ASSERT_EQ(static_cast<int>(BuiltinBiomes().size()), fields->field_count());
  for (const v1::Biome& biome : BuiltinBiomes()) {
    const auto* own = fields->FindFieldByName(biome.name());
    ASSERT_NE(own, nullptr) << biome.name();
    v1::NatureConfig nature;
    nature.mutable_biomes()->GetReflection()->SetDouble(nature.mutable_biomes(), own, 3);
    for (const WeightedBiome& row : BiomesOf(nature)) {
      EXPECT_EQ(row.weight, row.biome->name() == biome.name() ? 3 : 0) << biome.name();
    }
    EXPECT_EQ(FindBiome(nature, biome.name()), &biome);
  }
}

// Neither mint nor brick: from white to black sand, red is strongest and blue weakest, by little.
TEST(Beaches, SandIsBeigeAsLightAsItWas) {
  const Vec3d luminance(0.2126, 0.7152, 0.0722);
  double palest = 0, darkest = 1;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    const Vec3d before = MeanColor("Sand", seed).value();
    const Vec3d color = before.cwiseProduct(BeachTint(seed).value());
    EXPECT_NEAR(color.dot(luminance), before.dot(luminance), 1e-9) << seed;
    EXPECT_GE(color.x(), color.y()) << seed;
    EXPECT_GE(color.y(), color.z()) << seed;
    EXPECT_LT(color.x(), 2.5 * color.z()) << seed;
    palest = std::max(palest, color.y());
    darkest = std::min(darkest, color.y());
  }
  EXPECT_GT(palest, 3 * darkest);
}

// Snow takes no tone of dry or damp earth: it was blue in one place and beige in another.
TEST(ArcticGround, IsAsWhiteInOnePlaceAsInAnother) {
  const v1::Scene& scene = WaterScene("arctic");
  const auto geometry = BuildSceneGeometry(scene).value();
  const v1::Terrain& land = scene.place().terrain();
  const auto terrain = TerrainOf(land).value();
  const auto& ground = geometry.materials[land.ground(0).material_index()];
  int places = 0;
  for (int k = 0; k < 4000; ++k) {
    const Vec2f p(static_cast<float>(k % 63 - 31) * 7.3f, static_cast<float>(k / 63 - 31) * 7.3f);
    if (terrain->AboveWater(p) < 3) continue;  // Below, waves wet it.
    const float z = terrain->Height(p, 0.1f);
    const SurfacePoint point = {.texture_m = {p.x(), p.y(), z},
                                .normal = Vec3f::UnitZ(),
                                .footprint_m = 0.5f,
                                .texture_normal = Vec3f::UnitZ()};
    const Vec3f color = ground->Evaluate(SurfacePoint8({&point, 1})).base_color.Get(0);
    if (color.y() < 0.5f) continue;  // The wind has bared gravel.
    ++places;
    EXPECT_GT(color.z(), 0.9f * color.x()) << p.transpose();
    EXPECT_LT(color.z(), 1.3f * color.x()) << p.transpose();
  }
  EXPECT_GT(places, 100);
}

// Shingle is of the stones that the sand was ground from: no black gravel on a pale beach.
TEST(Beaches, ShingleIsSomewhatDarkerThanItsSand) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const Vec3d sand = MeanColor("Sand", seed).value().cwiseProduct(BeachTint(seed).value());
    const Vec3d gravel = MeanColor("Gravel", seed + 100).value();
    const Vec3d shingle = gravel.cwiseProduct(ShingleTint(seed + 100, seed).value());
    for (int c = 0; c < 3; ++c) {
      EXPECT_LT(shingle[c], 0.8 * sand[c]) << seed;
      EXPECT_GT(shingle[c], 0.5 * sand[c]) << seed;
    }
  }
}

}  // namespace
}  // namespace parallax
