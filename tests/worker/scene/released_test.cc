// The settings of the paper's released generator: each changes what it says, and the scene keeps
// all other draws.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/choose_materials.h"
#include "worker/scene/dress.h"
#include "worker/scene/floating/floating_choice.h"
#include "worker/scene/types/indoor/dress_house.h"

namespace parallax {
namespace {

constexpr uint64_t kSeeds = 60;

v1::Distribution Constant(double value) {
  v1::Distribution distribution;
  distribution.set_constant(value);
  return distribution;
}

std::vector<v1::Light> PointLights(const v1::LightingConfig& config, uint64_t seed) {
  google::protobuf::RepeatedPtrField<v1::Light> lights;
  const auto place = [](Rng& rng, double ball_m) {
    return LightPlace{{rng.Uniform(), 0, 1}, ball_m > 0 ? ball_m : 0.05, rng.Uniform()};
  };
  AddPointLights(config, Rng(SceneSeed{seed}, "dress/lighting"), place, lights);
  return {lights.begin(), lights.end()};
}

v1::LightingConfig FourLights() {
  v1::LightingConfig config = DefaultSceneConfig().lighting();
  *config.mutable_point_lights() = Constant(4);
  *config.mutable_point_power_w() = Constant(1000);
  return config;
}

double PowerOf(const v1::Light& light) { return FromProto(light.power_w()).mean(); }

TEST(PointLights, DrawEachItsOwnPowerOrShareTheTotal) {
  v1::LightingConfig config = FourLights();
  double shared = 0;
  for (const v1::Light& light : PointLights(config, 1)) shared += PowerOf(light);
  EXPECT_NEAR(shared, 1000, 1e-6);

  config.set_point_split(v1::LightingConfig::POINT_SPLIT_EACH);
  double least = 1e9, most = 0, sum = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const v1::Light& light : PointLights(config, seed)) {
      least = std::min(least, PowerOf(light));
      most = std::max(most, PowerOf(light));
      sum += PowerOf(light);
    }
  }
  EXPECT_LT(least, 10);
  EXPECT_GT(most, 240);
  EXPECT_LE(most, 250);
  EXPECT_NEAR(sum / (4 * kSeeds), 125, 15);
}

TEST(PointLights, HaveColoursAndSizesWhereAsked) {
  const auto bluest = [](const v1::LightingConfig& config) {
    double ratio = 0;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      for (const v1::Light& light : PointLights(config, seed)) {
        ratio = std::max(ratio, light.power_w().z() / light.power_w().x());
      }
    }
    return ratio;
  };
  v1::LightingConfig config = FourLights();
  EXPECT_LE(bluest(config), 1.0 + 1e-9) << "white to warm";
  config.set_point_colored_p(1);
  EXPECT_GT(bluest(config), 3);

  config.set_point_large_p(0.5);
  *config.mutable_point_radius_m() = Constant(2);
  int large = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const v1::Light& light : PointLights(config, seed)) {
      EXPECT_TRUE(light.radius_m() == 2 || light.radius_m() == 0.05) << light.radius_m();
      large += light.radius_m() == 2;
    }
  }
  EXPECT_NEAR(large, 2 * kSeeds, 25);
}

// A house with a lamp on the ceiling and one on a table, 100 W each.
SceneInProgress TwoLamps(uint64_t seed) {
  SceneInProgress scene;
  scene.seed = SceneSeed{seed};
  for (const char* relation : {"on_ceiling", "on_top"}) {
    v1::SceneObject& object = *scene.recipe.add_objects();
    object.set_index(static_cast<uint32_t>(scene.recipe.objects_size()));
    object.set_relation(relation);
    v1::Light& light = *scene.recipe.add_lights();
    light.set_kind(v1::Light::KIND_MESH);
    light.set_object_index(object.index());
    *light.mutable_power_w() = ToProto(Vec3d(100, 100, 100));
  }
  return scene;
}

TEST(Lamps, AreColouredOrDimmedTogether) {
  v1::LightingConfig config = DefaultSceneConfig().lighting();
  *config.mutable_point_lights() = Constant(0);
  config.set_ceiling_dimmed_p(0);
  config.set_lamps_colored_p(0.3);
  config.set_lamps_dimmed_p(0.3);
  int colored = 0, dimmed = 0;
  for (uint64_t seed = 1; seed <= 10 * kSeeds; ++seed) {
    SceneInProgress scene = TwoLamps(seed);
    ChooseHouseLighting(config, scene);
    const Vec3d ceiling = FromProto(scene.recipe.lights(0).power_w());
    EXPECT_EQ(ceiling, FromProto(scene.recipe.lights(1).power_w())) << "one draw for both";
    const bool has_color = ceiling.maxCoeff() - ceiling.minCoeff() > 1;
    colored += has_color;
    if (ceiling.mean() < 99) {
      ++dimmed;
      EXPECT_FALSE(has_color);
      EXPECT_GE(ceiling.mean(), 2);
      EXPECT_LE(ceiling.mean(), 10);
    }
  }
  EXPECT_NEAR(colored, 180, 40);
  EXPECT_NEAR(dimmed, 180, 40);
}

TEST(Skies, AreDarkFlatAndSunnyAsAsked) {
  v1::LightingConfig config = DefaultSceneConfig().lighting();
  config.set_dark_sky_p(0.5);
  *config.mutable_dark_sky_strength() = Constant(0.01);
  *config.mutable_sun_strength() = Constant(3);
  *config.mutable_flat_sky() = Constant(0.25);
  int dark = 0;
  std::set<double> hues;
  for (uint64_t seed = 1; seed <= 4 * kSeeds; ++seed) {
    const Rng root(SceneSeed{seed}, "dress/lighting");
    v1::Sky sky, usual;
    ChooseSky(config, root, sky);
    ChooseSky(DefaultSceneConfig().lighting(), root, usual);
    const bool is_dark = sky.strength() == 0.01;
    dark += is_dark;
    EXPECT_TRUE(is_dark || sky.strength() == usual.strength()) << sky.strength();
    EXPECT_EQ(sky.sun_strength(), 3);
    EXPECT_EQ(sky.flat_share(), 0.25);
    EXPECT_FALSE(usual.has_flat());
    EXPECT_EQ(sky.sun_azimuth_rad(), usual.sun_azimuth_rad());
    hues.insert(sky.flat().x());
  }
  EXPECT_NEAR(dark, 2 * kSeeds, 30);
  EXPECT_GT(hues.size(), 3 * kSeeds);
}

TEST(FloatingSizes, GrowAndThenHaveSomethingAdded) {
  v1::FloatingConfig config = DefaultSceneConfig().floating();
  *config.mutable_size_m() = Constant(1);
  *config.mutable_size_added_m() = Constant(-0.25);
  config.set_size_at_m(7.5);
  const FloatingSize size = FloatingSize::Draw(config, Rng(SceneSeed{1}, "object"));
  EXPECT_DOUBLE_EQ(size.At(config, 15), 1.75);
  EXPECT_DOUBLE_EQ(size.At(config, 0.1), 0.02) << "never nothing";
  config.set_size_at_m(0);
  EXPECT_DOUBLE_EQ(size.At(config, 15), 0.75);
}

// Two pans, which are metal with a handle.
SceneInProgress TwoPans(uint64_t seed) {
  SceneInProgress scene;
  scene.seed = SceneSeed{seed};
  scene.recipe.set_type(v1::SCENE_TYPE_DENSE);
  scene.recipe.mutable_place()->mutable_open_sky();
  for (uint32_t i = 1; i <= 2; ++i) {
    v1::SceneObject& object = *scene.recipe.add_objects();
    object.set_index(i);
    object.set_name("Pan_" + std::to_string(i));
    object.set_asset_class("Pan");
    object.set_seed(i);
    object.set_role(v1::OBJECT_ROLE_FURNITURE);
  }
  return scene;
}

// The classes of an object's materials, by part.
std::vector<std::string> MaterialsOf(const v1::Scene& recipe, int object) {
  std::vector<std::string> classes;
  for (const v1::MaterialBinding& binding : recipe.objects(object).materials()) {
    classes.push_back(
        recipe.materials(static_cast<int>(binding.material_index()) - 1).material_class());
  }
  return classes;
}

TEST(ReplacedMaterials, AreDrawnByPartByObjectOrOnceAScene) {
  v1::MaterialConfig config = DefaultSceneConfig().materials();
  v1::MaterialConfig never = config;
  never.set_replace_probability(0);
  // How often both objects, and both parts of one, share their fate.
  const auto agree = [&](v1::MaterialConfig::ReplacePer per) {
    config.set_replace_per(per);
    int objects = 0, parts = 0;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      SceneInProgress scene = TwoPans(seed), own = TwoPans(seed);
      EXPECT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
      EXPECT_TRUE(ChooseMaterials(never, nullptr, own).ok());
      const auto first = MaterialsOf(scene.recipe, 0), own_first = MaterialsOf(own.recipe, 0);
      const auto second = MaterialsOf(scene.recipe, 1), own_second = MaterialsOf(own.recipe, 1);
      objects += (first == own_first) == (second == own_second);
      parts += (first[0] == own_first[0]) == (first[1] == own_first[1]);
    }
    return std::pair(objects, parts);
  };
  const auto [object_objects, object_parts] = agree(v1::MaterialConfig::REPLACE_PER_OBJECT);
  EXPECT_LT(object_objects, 50);
  EXPECT_GE(object_parts, 55);
  const auto [scene_objects, scene_parts] = agree(v1::MaterialConfig::REPLACE_PER_SCENE);
  EXPECT_GE(scene_objects, 58);
  EXPECT_GE(scene_parts, 55);
  const auto [part_objects, part_parts] = agree(v1::MaterialConfig::REPLACE_PER_PART);
  EXPECT_LT(part_parts, 50);
}

TEST(ReplacedMaterials, AreThoseThatAreNamed) {
  v1::MaterialConfig config = DefaultSceneConfig().materials();
  config.set_replace_probability(1);
  config.add_replacements("MattePlastic");
  SceneInProgress scene = TwoPans(3);
  ASSERT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
  for (const v1::SceneMaterial& material : scene.recipe.materials()) {
    EXPECT_EQ(material.material_class(), "MattePlastic");
  }
}

TEST(OwnMaterials, LoseMetalAndGlassWhereAsked) {
  v1::MaterialConfig config = DefaultSceneConfig().materials();
  config.set_replace_probability(0);
  const auto metals = [&] {
    int count = 0;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      SceneInProgress scene = TwoPans(seed);
      EXPECT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
      for (const v1::SceneMaterial& material : scene.recipe.materials()) {
        count += FindMaterialClass(material.material_class())->tags.metal_or_glass;
      }
    }
    return count;
  };
  EXPECT_GT(metals(), 10);
  config.set_metal_and_glass(false);
  EXPECT_EQ(metals(), 0);
}

}  // namespace
}  // namespace parallax
