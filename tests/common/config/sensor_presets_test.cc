#include "common/config/sensor_presets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<v1::SceneConfig> ParseSensor(const std::string& sensor, const std::string& render) {
  return ParseSceneConfig("sensor: " + sensor + "\nrender: " + render + "\n", "c.yaml");
}

TEST(SensorPresets, AllAreInRangeAndSetEveryField) {
  for (const char* name : {"off", "ideal", "industrial", "stereo_module", "webcam", "phone"}) {
    const auto config = ParseSensor("{preset: " + std::string(name) + "}", "{keep_hdr: true}");
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->sensor().preset(), name);
    EXPECT_TRUE(config->sensor().has_white_e()) << name;
    const bool real = std::string(name) != "off" && std::string(name) != "ideal";
    EXPECT_EQ(SupportOf(config->sensor().white_e()).low > 0, real) << name;
    EXPECT_EQ(SupportOf(config->sensor().exposure_mismatch_ev()).high > 0, real) << name;
  }
}

TEST(SensorPresets, FieldsBesideOneReplaceItsNumbersWhereverTheyStand) {
  const auto before = ParseSensor("{white_e: 123, preset: webcam}", "{keep_hdr: true}");
  const auto after = ParseSensor("{preset: webcam, white_e: 123}", "{keep_hdr: true}");
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

TEST(SensorPresets, NumbersOfASensorThatIsOffAreErrors) {
  const std::string off(ParseSensor("{white_e: 200, bayer: true}", "{}").status().message());
  EXPECT_THAT(off, HasSubstr("c.yaml:1: sensor.white_e: given, but sensor.preset is off, allowed "
                             "with ideal, industrial, stereo_module, webcam, phone"));
  EXPECT_THAT(off, HasSubstr("sensor.bayer: given"));
  EXPECT_TRUE(ParseSensor("{white_e: 0, focus_m: 2, bayer: false}", "{}").ok()) << "the defaults";
  EXPECT_TRUE(ParseSceneConfig(*BuiltinConfigText("scenes/indoor.yaml"), "indoor.yaml").ok());
}

TEST(SensorPresets, NumbersThatAnotherFieldTurnsOffAreErrors) {
  const struct {
    const char* sensor;
    const char* want;
  } rows[] = {
      {"{preset: phone, shake_m_s: 2}", "sensor.shake_m_s: given, but sensor.exposure_ms is 0"},
      {"{preset: ideal, shake_deg_s: 2}", "sensor.shake_deg_s: given, but sensor.exposure_ms is 0"},
      {"{preset: ideal, read_noise_e: 20}", "sensor.read_noise_e: given, but sensor.white_e is 0"},
      {"{preset: phone, white_e: 0}", ""},  // The preset's read noise goes with it.
      {"{preset: ideal, exposure_ms: {uniform: [0, 5]}, shake_m_s: 2}", ""},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.sensor);
    const absl::Status status = ParseSensor(row.sensor, "{keep_hdr: true}").status();
    EXPECT_EQ(status.ok(), *row.want == 0) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(row.want));
  }
  const auto study = ParseStudy(
      "study: s\npairs: 1\nvariants:\n"
      "  - {name: a, set: {render: {keep_hdr: true}, sensor: {preset: phone, shake_m_s: 2}}}\n",
      "s.yaml");
  EXPECT_THAT(std::string(study.status().message()),
              HasSubstr("s.yaml:4: variants[0].set.sensor.shake_m_s: given"));
}

TEST(SensorPresets, WhatASensorNeedsMustBeKept) {
  EXPECT_THAT(
      std::string(ParseSensor("{preset: webcam}", "{}").status().message()),
      HasSubstr("sensor.preset: webcam, which makes its pictures of what render.keep_hdr keeps"));
  EXPECT_THAT(std::string(ParseSensor("{preset: ideal, defocus_px: 2}",
                                      "{keep_hdr: true, maps: [disparity]}")
                              .status()
                              .message()),
              HasSubstr("without depth, which sensor.defocus_px is worked out from"));
  EXPECT_THAT(std::string(ParseSensor("{preset: ideal, exposure_ms: 9}",
                                      "{keep_hdr: true, maps: [disparity]}")
                              .status()
                              .message()),
              HasSubstr("without depth, which the blur of sensor.exposure_ms is worked out from"));
  EXPECT_TRUE(ParseSensor("{preset: ideal}", "{keep_hdr: true, maps: [disparity]}").ok());
  EXPECT_TRUE(ParseSensor("{preset: off}", "{}").ok());
  EXPECT_THAT(std::string(ParseSensor("{preset: webcan}", "{keep_hdr: true}").status().message()),
              HasSubstr("did you mean webcam?"));
}

}  // namespace
}  // namespace parallax
