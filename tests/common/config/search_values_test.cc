// The values of a search in a scene config.
#include "common/config/search/search_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using Values = std::vector<std::pair<std::string, std::string>>;

absl::StatusOr<v1::SceneConfig> With(const Values& values,
                                     const v1::SceneConfig& base = DefaultSceneConfig()) {
  v1::SearchTrial trial;
  for (const auto& [path, yaml] : values) {
    v1::SearchValue& value = *trial.add_values();
    value.set_path(path);
    value.set_yaml(yaml);
  }
  return WithSearchValues(base, trial.values());
}

std::string ValuesError(const Values& values) {
  return std::string(With(values).status().message());
}

TEST(SearchValuesTest, ValuesReplaceThoseOfTheirFieldsAlone) {
  const auto config = With({{"floating.count", "12"},
                            {"floating.size_m", "{uniform: [0.1, 0.4]}"},
                            {"materials.mode", "none"},
                            {"furniture.enabled", "false"}});
  ASSERT_TRUE(config.ok()) << config.status();
  v1::SceneConfig expected = DefaultSceneConfig();
  expected.mutable_floating()->mutable_count()->set_constant(12);
  expected.mutable_floating()->mutable_size_m()->mutable_uniform()->set_low(0.1);
  expected.mutable_floating()->mutable_size_m()->mutable_uniform()->set_high(0.4);
  expected.mutable_materials()->set_mode(v1::MaterialConfig::MODE_NONE);
  expected.mutable_furniture()->set_enabled(false);
  EXPECT_EQ(config->SerializeAsString(), expected.SerializeAsString());
  EXPECT_EQ(With({})->SerializeAsString(), DefaultSceneConfig().SerializeAsString());
}

// As in a `set`: the first weight that is given forbids the lands that are not named.
TEST(SearchValuesTest, AllValuesAreMergedAtOnce) {
  const auto config = With({{"nature.biomes.plain", "1"}, {"nature.biomes.desert", "2"}});
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->nature().biomes().plain(), 1);
  EXPECT_EQ(config->nature().biomes().desert(), 2);
}

TEST(SearchValuesTest, ASpaceOfChoicesAndWholeNumbersHasSoManyPoints) {
  v1::SearchSpec search;
  v1::SearchField& count = *search.add_space();
  count.set_high(3);
  count.set_integer(true);
  search.add_space()->add_choices("all");
  search.mutable_space(1)->add_choices("none");
  EXPECT_EQ(PointsOfSpace(search, 50), 8);
  EXPECT_EQ(PointsOfSpace(search, 7), 7);
  search.add_space()->set_high(0.5);
  EXPECT_EQ(PointsOfSpace(search, 50), 50);
}

TEST(SearchValuesTest, WhatIsWrongIsNamedWithoutAFile) {
  EXPECT_EQ(ValuesError({{"floating.count", "700"}}),
            "floating.count: 700 is out of range, allowed 0 to 500");
  EXPECT_THAT(ValuesError({{"floating.coun", "7"}}),
              HasSubstr("floating.coun: no such field, did you mean count"));
  EXPECT_THAT(ValuesError({{"materials.mode", "non"}}),
              HasSubstr("materials.mode: non is not known, did you mean none"));
  EXPECT_THAT(ValuesError({{"floating.count", "{uniform"}}), HasSubstr("not YAML"));
  EXPECT_THAT(ValuesError({{"floating.count.low", "3"}}), HasSubstr("floating.count"));
}

TEST(SearchValuesTest, FieldsAreCheckedAgainstEachOther) {
  EXPECT_THAT(ValuesError({{"floating.placement", "street"}}),
              HasSubstr("floating.placement: street, but that is for scenes of type dense"));
}

// A coordinator makes trials of what strangers send.
TEST(SearchValuesTest, NoFileIsRead) {
  EXPECT_EQ(ValuesError({{"rigs.camera", "{calibration: /etc/passwd}"}}),
            "rigs.camera.calibration: names files, allowed in a search are other fields");
  EXPECT_THAT(ValuesError({{"room.room_files", "[/etc/passwd]"}}), HasSubstr("names files"));
  EXPECT_THAT(ValuesError({{"nature.biome_files", "[/etc/passwd]"}}), HasSubstr("names files"));
  EXPECT_TRUE(With({{"rigs.camera.preset", "zed_2i"}}).ok());
}

TEST(SearchValuesTest, NumbersHaveTheirShortestText) {
  v1::SearchField field;
  EXPECT_EQ(SearchNumberText(field, 0.1), "0.1");
  EXPECT_EQ(SearchNumberText(field, 5), "5");
  field.set_integer(true);
  EXPECT_EQ(SearchNumberText(field, 12.6), "13");
}

}  // namespace
}  // namespace parallax
