#include "coordinator/study/keys.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

namespace parallax {
namespace {

v1::SceneConfig SomeConfig() {
  v1::SceneConfig config;
  config.set_type(v1::SCENE_TYPE_INDOOR);
  config.mutable_room()->mutable_width_m()->set_constant(4);
  config.mutable_furniture()->set_enabled(true);
  config.mutable_solver()->set_steps(60);
  config.mutable_assets()->add_exclude("Cactus");
  config.mutable_floating()->mutable_count()->set_constant(12);
  config.mutable_materials()->set_replace_probability(0.5);
  config.mutable_lighting()->set_ceiling_removed_p(0.3);
  config.mutable_rigs()->set_count(20);
  config.mutable_render()->set_samples_per_pixel(8);
  config.mutable_filters()->set_min_depth_m(0.1);
  return config;
}

// Each field of SceneConfig, and which stage's digest must notice a change of it.
TEST(Keys, EachConfigFieldCountsForExactlyTheStagesThatReadIt) {
  const struct {
    const char* field;
    std::function<void(v1::SceneConfig&)> change;
    bool layout, scene, render;
  } cases[] = {
      {"type", [](auto& c) { c.set_type(v1::SCENE_TYPE_DENSE); }, true, true, false},
      {"room", [](auto& c) { c.mutable_room()->mutable_width_m()->set_constant(5); }, true, true,
       false},
      {"furniture", [](auto& c) { c.mutable_furniture()->set_enabled(false); }, false, true, false},
      {"solver", [](auto& c) { c.mutable_solver()->set_steps(61); }, true, true, false},
      {"assets", [](auto& c) { c.mutable_assets()->add_exclude("Rack"); }, true, true, false},
      {"floating", [](auto& c) { c.mutable_floating()->add_classes("Chair"); }, false, true, false},
      {"materials", [](auto& c) { c.mutable_materials()->set_replace_probability(0.6); }, false,
       true, false},
      {"lighting", [](auto& c) { c.mutable_lighting()->set_ceiling_removed_p(0); }, false, true,
       false},
      {"rigs", [](auto& c) { c.mutable_rigs()->set_count(21); }, false, true, false},
      {"render", [](auto& c) { c.mutable_render()->set_samples_per_pixel(9); }, false, false, true},
      {"filters", [](auto& c) { c.mutable_filters()->set_min_depth_m(0.2); }, false, false, true},
  };
  EXPECT_EQ(std::size(cases), static_cast<size_t>(v1::SceneConfig::descriptor()->field_count()));
  const ConfigDigests before = DigestsOf(SomeConfig());
  for (const auto& c : cases) {
    v1::SceneConfig config = SomeConfig();
    c.change(config);
    const ConfigDigests after = DigestsOf(config);
    EXPECT_EQ(after.layout != before.layout, c.layout) << c.field;
    EXPECT_EQ(after.scene != before.scene, c.scene) << c.field;
    EXPECT_EQ(after.render != before.render, c.render) << c.field;
  }
}

TEST(Keys, SceneSeedsAreTheSameForEqualStudySeedsAndDifferElsewhere) {
  std::set<uint64_t> seeds;
  for (uint64_t study_seed : {0, 1, 2}) {
    for (uint32_t ordinal = 0; ordinal < 1000; ++ordinal) {
      EXPECT_EQ(SceneSeedOf(study_seed, ordinal), SceneSeedOf(study_seed, ordinal));
      seeds.insert(SceneSeedOf(study_seed, ordinal).value);
    }
  }
  EXPECT_EQ(seeds.size(), 3000u);
}

TEST(Keys, VersionSeedSceneAndRigEachChangeTheKey) {
  const ConfigDigests config = DigestsOf(SomeConfig());
  const Sha256Digest scene = Sha256Of("scene");
  std::set<Sha256Digest> keys = {
      LayoutKey("1", config, SceneSeed{1}),  LayoutKey("2", config, SceneSeed{1}),
      LayoutKey("1", config, SceneSeed{2}),  SceneKey("1", config, SceneSeed{1}),
      SceneKey("2", config, SceneSeed{1}),   SceneKey("1", config, SceneSeed{2}),
      FrameKey("1", config, scene, 0),       FrameKey("2", config, scene, 0),
      FrameKey("1", config, scene, 1),       FrameKey("1", config, Sha256Of("other"), 0),
      RenderKey("1", config, scene, "0-19"), RenderKey("1", config, scene, "0-9")};
  EXPECT_EQ(keys.size(), 12u);
}

// Results of earlier runs are found by these; a change here makes everything again.
TEST(Keys, StayWhatTheyAreWithinAGeneratorVersion) {
  EXPECT_EQ(SceneSeedOf(1, 0).value, 13697308113189384837ull);
  EXPECT_EQ(HexOf(LayoutKey("1", DigestsOf(SomeConfig()), SceneSeed{7})).substr(0, 16),
            "71d83bcadf415c48");
}

TEST(Keys, StorePrefixIsTwoHexDigitsAndTheKey) {
  const Sha256Digest key = Sha256Of("x");
  EXPECT_EQ(StorePrefixOf(key), HexOf(key).substr(0, 2) + "/" + HexOf(key));
}

}  // namespace
}  // namespace parallax
