#include "common/config/sensor_presets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<v1::SceneConfig> Parse(const std::string& sensor, const std::string& render) {
  return ParseSceneConfig("sensor: " + sensor + "\nrender: " + render + "\n", "c.yaml");
}

TEST(SensorPresets, AllAreInRangeAndSetEveryField) {
  for (const char* name : {"off", "ideal", "industrial", "stereo_module", "webcam", "phone"}) {
    const auto config = Parse("{preset: " + std::string(name) + "}", "{keep_hdr: true}");
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->sensor().preset(), name);
    EXPECT_TRUE(config->sensor().has_white_e()) << name;
    const bool real = std::string(name) != "off" && std::string(name) != "ideal";
    EXPECT_EQ(SupportOf(config->sensor().white_e()).low > 0, real) << name;
    EXPECT_EQ(SupportOf(config->sensor().exposure_mismatch_ev()).high > 0, real) << name;
  }
}

TEST(SensorPresets, FieldsBesideOneReplaceItsNumbersWhereverTheyStand) {
  const auto before = Parse("{white_e: 123, preset: webcam}", "{keep_hdr: true}");
  const auto after = Parse("{preset: webcam, white_e: 123}", "{keep_hdr: true}");
  ASSERT_TRUE(before.ok()) << before.status();
  EXPECT_EQ(before->SerializeAsString(), after->SerializeAsString());
  EXPECT_EQ(before->sensor().white_e().constant(), 123);
  EXPECT_TRUE(before->sensor().bayer());
}

TEST(SensorPresets, AnotherOneLeavesNothingOfTheFirst) {
  const auto study = ParseStudy(
      "study: s\npairs: 1\nrigs_per_scene: 1\nvariants:\n"
      "  - {name: a, set: {render: {keep_hdr: true}, sensor: {preset: webcam}}}\n"
      "  - {name: b, set: {render: {keep_hdr: true}, sensor: {preset: ideal}}}\n",
      "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->variants(1).config().sensor().white_e().constant(), 0);
  EXPECT_FALSE(study->variants(1).config().sensor().bayer());
  const auto again = ParseStudy(StudyToYaml(*study), "lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->variants(0).config().SerializeAsString(),
            study->variants(0).config().SerializeAsString());
}

TEST(SensorPresets, WhatASensorNeedsMustBeKept) {
  EXPECT_THAT(
      std::string(Parse("{preset: webcam}", "{}").status().message()),
      HasSubstr("render.keep_hdr: false, but a sensor makes its pictures of what it keeps"));
  EXPECT_THAT(
      std::string(Parse("{preset: ideal, defocus_px: 2}", "{keep_hdr: true, maps: [disparity]}")
                      .status()
                      .message()),
      HasSubstr("without depth, which sensor.defocus_px is worked out from"));
  EXPECT_THAT(
      std::string(Parse("{preset: ideal, exposure_ms: 9}", "{keep_hdr: true, maps: [disparity]}")
                      .status()
                      .message()),
      HasSubstr("without depth, which the blur of sensor.exposure_ms is worked out from"));
  EXPECT_TRUE(Parse("{preset: ideal}", "{keep_hdr: true, maps: [disparity]}").ok());
  EXPECT_TRUE(Parse("{preset: off}", "{}").ok());
  EXPECT_THAT(std::string(Parse("{preset: webcan}", "{keep_hdr: true}").status().message()),
              HasSubstr("did you mean webcam?"));
}

}  // namespace
}  // namespace parallax
