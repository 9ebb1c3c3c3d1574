// Lands from files: the built-in ones write the recipes that they always wrote, and one of the
// user's own is scattered without a rebuild.
#include "worker/scene/types/nature/rules/biomes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "tests/folder_test.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

constexpr uint64_t kFnvStart = 1469598103934665603u, kFnvPrime = 1099511628211u;

uint64_t HashOf(const std::string& bytes) {
  uint64_t hash = kFnvStart;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * kFnvPrime;
  return hash;
}

// A land's rules on its own landform, whose ground is not made.
v1::Terrain RulesOf(const v1::Biome& biome, const std::string& season, uint64_t seed) {
  const Rng root(SceneSeed{seed}, "rules");
  v1::Terrain recipe;
  SetTerrainSpec(DrawLandform(biome.landform(), root.Child("land")).value(), recipe);
  const float lift = static_cast<float>(seed) * 0.731f;
  BiomeDraft draft{root,
                   season,
                   0.7 + 0.01 * static_cast<double>(seed),
                   {.low_m = lift, .middle_m = 20 + 1.3f * lift, .high_m = 60 + 1.7f * lift},
                   recipe};
  EXPECT_TRUE(WriteRules(biome, draft).ok());
  return recipe;
}

// The hashes are of the recipes that lands wrote when they were C++: same seeds, same scenes.
TEST(BuiltinBiomes, WriteTheRecipesThatTheyAlwaysWrote) {
  const struct {
    const char* name;
    uint64_t hash;
  } rows[] = {
      {"arctic", 0x9f45c56a069c9603u},         {"canyon", 0x58e467003ecee899u},
      {"cave", 0x5cb5bdbfb0d119cau},           {"cliff", 0xcf73e95b3e525cd0u},
      {"coast", 0x7885c11660dd91f1u},          {"desert", 0x858b35de93d354b3u},
      {"forest", 0x6ab643e3a4f20e60u},         {"mountain", 0x716e2b15a83e2977u},
      {"plain", 0x8860634653ec4f1fu},          {"river", 0x5d955e8845cf6778u},
      {"snowy_mountain", 0x4173832d4c018e65u},
  };
  ASSERT_EQ(BuiltinBiomes().size(), std::size(rows));
  for (const auto& [name, hash] : rows) {
    const v1::Biome biome = LoadBiome(name).value();
    uint64_t of_all = kFnvStart;
    for (const char* season : {"spring", "summer", "autumn", "winter"}) {
      for (uint64_t seed = 1; seed <= 10; ++seed) {
        const std::string recipe = RulesOf(biome, season, seed).SerializeAsString();
        of_all = (of_all ^ HashOf(recipe)) * kFnvPrime;
      }
    }
    EXPECT_EQ(of_all, hash) << name;
  }
}

using OwnBiome = FolderTest;

TEST_F(OwnBiome, OfAFileIsScatteredAndDressed) {
  std::ofstream(dir_ + "/my_heath.yaml")
      << "landform: plain\n"
         "trace_times: 1.5\n"
         "ground:\n"
         "  - {material: Soil}\n"
         "  - {material: Rock, where: {slope: [0.75, 99, 0.2]}}\n"
         "trees:\n"
         "  - {name: pines, class: Conifer/pine, crown_m: 2, per_m2: 0.01, spacing_m: 3,\n"
         "     reach_m: 200, size: [0.6, 1]}\n"
         "layers:\n"
         "  - {trees: pines}\n"
         "  - {name: heather, class: Shrub, each: true, per_m2: 0.3, spacing_m: 0.6,\n"
         "     where: {slope: [0, 0.6, 0.2], patches: [9, {uniform: [0.5, 0.8]}, 0.1]}}\n";
  const auto config = ParseSceneConfig(
      "type: nature\n"
      "nature: {biome_files: [my_heath.yaml], biomes: {my_heath: 2}}\n"
      "rigs: {count: 2, width_px: 320, height_px: 180, clearance_baseline_m: 0.5}\n",
      dir_ + "/scene.yaml");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(kNatureScenes.costs(*config).trace_times, 1.5);
  v1::SolveJob job;
  *job.mutable_config() = *config;
  v1::SolveResult result;
  for (uint64_t seed = 1; seed <= 5 && !result.has_scene(); ++seed) {
    job.set_scene_seed(seed);
    const auto solved = Solve(job, CancelToken());
    ASSERT_TRUE(solved.ok()) << solved.status();
    result = *solved;
  }
  ASSERT_TRUE(result.has_scene());
  const v1::Terrain& land = result.scene().place().terrain();
  EXPECT_EQ(land.biome(), "my_heath");
  ASSERT_EQ(land.layers_size(), 2);
  EXPECT_EQ(land.layers(0).name(), "pines");
  EXPECT_EQ(land.layers(1).name(), "heather");
  EXPECT_GT(land.layers(1).indices(), 100u);
  ASSERT_EQ(land.ground_size(), 2);
  const auto& materials = result.scene().materials();
  EXPECT_TRUE(std::any_of(materials.begin(), materials.end(),
                          [](const v1::SceneMaterial& m) { return m.material_class() == "Soil"; }));
}

}  // namespace
}  // namespace parallax
