#include "common/config/stages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/config/config.h"

namespace parallax {
namespace {

TEST(Stages, EachConfigFieldNamesTheStageThatReadsIt) {
  const std::vector<ConfigField> fields = ConfigFields();
  EXPECT_GT(fields.size(), 50u);
  for (const ConfigField& field : fields) {
    EXPECT_NE(field.stage, v1::FieldRule::STAGE_UNSPECIFIED)
        << field.path << ": say in config.proto which stage reads it, [(rule) = {stage: ...}]";
  }
}

TEST(Stages, FieldsComeOutOnceAndGroupsWithoutAnyAreLeftOut) {
  const v1::SceneConfig config = DefaultSceneConfig();
  v1::SceneConfig together;
  for (const auto stage : {v1::FieldRule::LAYOUT, v1::FieldRule::SCENE, v1::FieldRule::FRAME,
                           v1::FieldRule::SENSOR, v1::FieldRule::FINISH, v1::FieldRule::PLACE}) {
    together.MergeFrom(FieldsOf(config, stage));
  }
  EXPECT_EQ(together.SerializeAsString(), config.SerializeAsString());

  const v1::SceneConfig layout = FieldsOf(config, v1::FieldRule::LAYOUT);
  EXPECT_TRUE(layout.has_room());
  EXPECT_TRUE(layout.has_assets());
  EXPECT_FALSE(layout.assets().has_glass_parts());
  EXPECT_FALSE(layout.has_furniture());
  EXPECT_FALSE(layout.has_rigs());
}

}  // namespace
}  // namespace parallax
