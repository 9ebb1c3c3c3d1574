#include "coordinator/study/keys.h"

#include <gtest/gtest.h>

#include <set>

#include "common/config/config.h"
#include "common/config/stages.h"

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

// Gives the field at `path` another value, whatever its type.
void Change(const std::string& path, google::protobuf::Message* message) {
  const google::protobuf::Reflection& reflection = *message->GetReflection();
  const size_t dot = path.find('.');
  const auto& field = *message->GetDescriptor()->FindFieldByName(path.substr(0, dot));
  using Field = google::protobuf::FieldDescriptor;
  if (dot != std::string::npos) {
    return Change(path.substr(dot + 1), reflection.MutableMessage(message, &field));
  }
  if (field.is_repeated() && field.cpp_type() == Field::CPPTYPE_MESSAGE) {
    reflection.AddMessage(message, &field);
    return;
  }
  if (field.is_repeated() && field.cpp_type() == Field::CPPTYPE_DOUBLE) {
    return reflection.AddDouble(message, &field, 987);
  }
  if (field.is_repeated()) return reflection.AddString(message, &field, "another");
  switch (field.cpp_type()) {
    case Field::CPPTYPE_MESSAGE: {
      auto* value = reflection.MutableMessage(message, &field);
      return static_cast<v1::Distribution*>(value)->set_constant(987);
    }
    case Field::CPPTYPE_DOUBLE:
      return reflection.SetDouble(message, &field, 987);
    case Field::CPPTYPE_INT32:
      return reflection.SetInt32(message, &field, 987);
    case Field::CPPTYPE_BOOL:
      return reflection.SetBool(message, &field, !reflection.GetBool(*message, &field));
    case Field::CPPTYPE_STRING:
      return reflection.SetString(message, &field, "another");
    case Field::CPPTYPE_ENUM:
      return reflection.SetEnumValue(message, &field,
                                     reflection.GetEnumValue(*message, &field) == 1 ? 2 : 1);
    default:
      FAIL() << path << ": a type that no config field had so far";
  }
}

// A layout's key follows the layout's fields, a scene's key those and the scene's, and so on.
TEST(Keys, EachConfigFieldCountsForExactlyTheStagesThatReadIt) {
  const struct Keys {
    explicit Keys(const v1::SceneConfig& config)
        : layout(LayoutKey({}, DigestsOf(config), SceneSeed{1})),
          scene(SceneKey({}, DigestsOf(config), SceneSeed{1})),
          frame(FrameKey({}, DigestsOf(config), Sha256Of("scene"), 0)),
          render(RenderKey({}, DigestsOf(config), Sha256Of("scene"), "0-19")) {}
    Sha256Digest layout, scene, frame, render;
  } of_defaults(DefaultSceneConfig());
  v1::SceneConfig nature = DefaultSceneConfig();
  nature.set_type(v1::SCENE_TYPE_NATURE);
  const Keys of_nature(nature);
  std::set<v1::FieldRule::Stage> seen;
  for (const ConfigField& field : ConfigFields()) {
    SCOPED_TRACE(field.path);
    const bool of_type = field.path.rfind("nature.", 0) == 0;
    v1::SceneConfig config = of_type ? nature : DefaultSceneConfig();
    const Keys& before = of_type ? of_nature : of_defaults;
    Change(field.path, &config);
    const Keys after(config);
    seen.insert(field.stage);
    EXPECT_EQ(after.layout != before.layout, field.stage == v1::FieldRule::LAYOUT);
    EXPECT_EQ(after.scene != before.scene,
              field.stage == v1::FieldRule::LAYOUT || field.stage == v1::FieldRule::SCENE);
    EXPECT_EQ(after.frame != before.frame, field.stage == v1::FieldRule::FRAME);
    EXPECT_EQ(after.render != before.render, field.stage == v1::FieldRule::FRAME);
  }
  EXPECT_EQ(seen.size(), 6u) << "layout, scene, frame, sensor, finish, and none: a place";
}

TEST(Keys, FieldsOfAnotherTypeOfSceneCountForNothing) {
  const v1::SceneConfig before = DefaultSceneConfig();
  v1::SceneConfig after = before;
  after.mutable_nature()->mutable_walk()->set_fps(2);
  after.mutable_nature()->add_seasons("winter");
  EXPECT_EQ(SceneKey({}, DigestsOf(after), SceneSeed{1}),
            SceneKey({}, DigestsOf(before), SceneSeed{1}));
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

TEST(Keys, SeedSceneAndRigEachChangeTheKey) {
  const ConfigDigests config = DigestsOf(SomeConfig());
  const Sha256Digest scene = Sha256Of("scene");
  std::set<Sha256Digest> keys = {LayoutKey({}, config, SceneSeed{1}),
                                 LayoutKey({}, config, SceneSeed{2}),
                                 SceneKey({}, config, SceneSeed{1}),
                                 SceneKey({}, config, SceneSeed{2}),
                                 FrameKey({}, config, scene, 0),
                                 FrameKey({}, config, scene, 1),
                                 RenderKey({}, config, scene, "0-19"),
                                 RenderKey({}, config, scene, "0-9"),
                                 FrameKey({}, config, Sha256Of("other"), 0)};
  EXPECT_EQ(keys.size(), 9u);
}

// A change of pictures alone keeps layouts and recipes. A frame follows its recipe, which names the
// versions of layout and scene.
TEST(Keys, AStagesVersionCountsForItAndTheStagesAfterIt) {
  const ConfigDigests config = DigestsOf(SomeConfig());
  const StageVersions before = {.layout = "1", .scene = "1", .frame = "1"};
  const struct {
    StageVersions versions;
    bool layout, scene, frame;
  } cases[] = {
      {{"2", "1", "1"}, true, true, false},
      {{"1", "2", "1"}, false, true, false},
      {{"1", "1", "2"}, false, false, true},
  };
  const Sha256Digest hash = Sha256Of("scene");
  for (const auto& row : cases) {
    SCOPED_TRACE(DescribeVersions(row.versions));
    const auto changes = [&](auto key_of) { return key_of(row.versions) != key_of(before); };
    EXPECT_EQ(changes([&](auto& v) { return LayoutKey(v, config, SceneSeed{7}); }), row.layout);
    EXPECT_EQ(changes([&](auto& v) { return SceneKey(v, config, SceneSeed{7}); }), row.scene);
    EXPECT_EQ(changes([&](auto& v) { return FrameKey(v, config, hash, 0); }), row.frame);
    EXPECT_EQ(changes([&](auto& v) { return RenderKey(v, config, hash, "0"); }), row.frame);
  }
}

// Results of earlier runs are found by these; a change here makes everything again.
TEST(Keys, StayWhatTheyAreWithinAVersion) {
  EXPECT_EQ(SceneSeedOf(1, 0).value, 13697308113189384837ull);
  const StageVersions versions = {.layout = "1", .scene = "1", .frame = "1"};
  const ConfigDigests config = DigestsOf(SomeConfig());
  EXPECT_EQ(HexOf(LayoutKey(versions, config, SceneSeed{7})).substr(0, 16), "6f5e5bb74412ca5a");
  EXPECT_EQ(HexOf(SceneKey(versions, config, SceneSeed{7})).substr(0, 16), "63629d709041819e");
  EXPECT_EQ(HexOf(FrameKey(versions, config, Sha256Of("scene"), 3)).substr(0, 16),
            "87b7461d9064a0e0");
}

TEST(Keys, StorePrefixIsTwoHexDigitsAndTheKey) {
  const Sha256Digest key = Sha256Of("x");
  EXPECT_EQ(StorePrefixOf(key), HexOf(key).substr(0, 2) + "/" + HexOf(key));
}

}  // namespace
}  // namespace parallax
