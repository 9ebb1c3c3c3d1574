// rigs.camera: presets and calibration files become numbers while a config is read.
#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kMiddlebury[] =
    "cam0=[4161.221 0 1445.577; 0 4160.5 984.686; 0 0 1]\nbaseline=176.252\nwidth=2880\n"
    "height=1988\n";

class CameraConfigTest : public FolderTest {
 protected:
  void SetUp() override { Write("calib.txt", kMiddlebury); }
  std::string Write(const std::string& name, const std::string& text) {
    const std::string path = dir_ + "/" + name;
    EXPECT_TRUE(WriteFile(path, text).ok());
    return path;
  }
  absl::StatusOr<v1::SceneConfig> Read(const std::string& yaml) {
    return ParseSceneConfig(yaml, dir_ + "/f.yaml");
  }
  std::string ErrorOf(const std::string& yaml) {
    const auto config = Read(yaml);
    EXPECT_FALSE(config.ok()) << yaml;
    return std::string(ToStd(config.status().message()));
  }
};

TEST_F(CameraConfigTest, NoneIsNoneAndChangesNoByte) {
  const auto config = Read("rigs: {camera: {}}");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_FALSE(config->rigs().has_camera());
  EXPECT_EQ(config->SerializeAsString(), DefaultSceneConfig().SerializeAsString());
  EXPECT_THAT(MessageToYaml(*config), Not(HasSubstr("camera")));
}

TEST_F(CameraConfigTest, APresetSetsKSizeAndBaselineInPlaceOfTheBase) {
  const auto config = Read("rigs: {camera: {preset: kitti}}");
  ASSERT_TRUE(config.ok()) << config.status();
  const v1::RigConfig& rigs = config->rigs();
  EXPECT_EQ(rigs.width_px(), 1242);
  EXPECT_EQ(rigs.height_px(), 375);
  EXPECT_EQ(rigs.baseline_m().constant(), 0.532725);
  EXPECT_EQ(rigs.camera().fx_px().constant(), 721.5377);
  EXPECT_EQ(rigs.camera().cx_px().constant(), 609.5593);
  EXPECT_EQ(rigs.camera().width_px(), 1242);
  EXPECT_FALSE(rigs.has_horizontal_fov_deg());
}

TEST_F(CameraConfigTest, WhatStandsBesideAPresetWins) {
  const auto config = Read(
      "rigs: {width_px: 621, height_px: 188, baseline_m: {uniform: [0.1, 0.2]}, camera: {preset: "
      "kitti, cy_px: {uniform: [170, 180]}}}");
  ASSERT_TRUE(config.ok()) << config.status();
  const v1::RigConfig& rigs = config->rigs();
  EXPECT_EQ(rigs.width_px(), 621);
  EXPECT_EQ(rigs.camera().width_px(), 1242) << "K is given for this width";
  EXPECT_EQ(rigs.baseline_m().uniform().high(), 0.2);
  EXPECT_EQ(rigs.camera().cy_px().uniform().low(), 170);
  EXPECT_EQ(rigs.camera().fx_px().constant(), 721.5377);
}

TEST_F(CameraConfigTest, APresetOfAnActiveCameraTurnsItsProjectorOn) {
  const auto config = Read("rigs: {camera: {preset: realsense_d435}}");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->rigs().baseline_m().constant(), 0.05);
  const v1::ProjectorConfig& projector = config->lighting().projector();
  EXPECT_EQ(projector.power_w().constant(), 0.36);
  EXPECT_EQ(projector.dots().constant(), 5000);
  EXPECT_EQ(projector.horizontal_fov_deg().constant(), 90);
  EXPECT_EQ(projector.vertical_fov_deg().constant(), 63);
  const auto off =
      Read("{rigs: {camera: {preset: realsense_d435}}, lighting: {projector: {power_w: 0}}}");
  ASSERT_TRUE(off.ok()) << off.status();
  EXPECT_EQ(off->lighting().projector().power_w().constant(), 0);
  EXPECT_EQ(off->lighting().projector().dots().constant(), 5000);
  const auto passive = Read("rigs: {camera: {preset: kitti}}");
  ASSERT_TRUE(passive.ok()) << passive.status();
  EXPECT_EQ(passive->lighting().projector().power_w().constant(), 0);
}

TEST_F(CameraConfigTest, AVariantsPresetReplacesTheCameraOfItsBase) {
  Write("base.yaml", "rigs: {camera: {preset: kitti, cy_px: 170, lens: {model: brown_conrady}}}");
  Write("s.yaml",
        "study: s\nbase: base.yaml\npairs: 4\nvariants:\n  - name: a\n  - name: b\n    set: {rigs: "
        "{camera: {preset: zed_2i}}}\n");
  const auto study = LoadStudy(dir_ + "/s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->variants(0).config().rigs().camera().cy_px().constant(), 170);
  const v1::RigConfig& rigs = study->variants(1).config().rigs();
  EXPECT_EQ(rigs.camera().cy_px().constant(), 360);
  EXPECT_FALSE(rigs.camera().has_lens());
  EXPECT_EQ(rigs.height_px(), 720);
}

TEST_F(CameraConfigTest, ACalibrationIsCopiedAndHashedAndItsLockNeedsNoFile) {
  Write("s.yaml",
        "study: s\npairs: 4\nvariants:\n  - name: a\n    set: {rigs: {width_px: 1440, height_px: "
        "994, camera: {calibration: calib.txt}}}\n");
  const auto study = LoadStudy(dir_ + "/s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  const v1::RigConfig& rigs = study->variants(0).config().rigs();
  EXPECT_EQ(rigs.camera().fx_px().constant(), 4161.221);
  EXPECT_EQ(rigs.camera().fy_px().constant(), 4160.5);
  EXPECT_EQ(rigs.camera().calibration_sha256(), Sha256Hex(kMiddlebury));
  EXPECT_EQ(rigs.camera().width_px(), 2880);
  EXPECT_EQ(rigs.width_px(), 1440);
  EXPECT_NEAR(rigs.baseline_m().constant(), 0.176252, 1e-12);
  EXPECT_TRUE(ValidateStudy(*study).ok()) << ValidateStudy(*study);
  // Loads the lock where the file is absent, and where another file has its name.
  const std::string lock = StudyToYaml(*study);
  std::filesystem::remove(dir_ + "/calib.txt");
  for (const char* text : {"", "another file"}) {
    if (*text != '\0') Write("calib.txt", text);
    auto again = ParseStudy(lock, dir_ + "/study.lock.yaml");
    ASSERT_TRUE(again.ok()) << again.status();
    again->set_source_yaml(study->source_yaml());
    EXPECT_TRUE(MessageDifferencer::Equals(*again, *study));
  }
}

TEST_F(CameraConfigTest, ARawPairComesWithItsCalibration) {
  Write("zed.conf",
        "[LEFT_CAM_HD]\nfx=700\nfy=701\ncx=640\ncy=350\nk1=-0.17\nk2=0.02\n[RIGHT_CAM_HD]\nfx=699\n"
        "fy=700\ncx=636\ncy=352\nk1=-0.16\n[STEREO]\nBaseline=120\nCV_HD=0.01\n");
  const auto config = Read("rigs: {camera: {calibration: zed.conf}}\nrender: {maps: [raw]}");
  ASSERT_TRUE(config.ok()) << config.status();
  const v1::CameraConfig& camera = config->rigs().camera();
  EXPECT_EQ(camera.raw_left().lens().model(), v1::LensConfig::MODEL_BROWN_CONRADY);
  EXPECT_EQ(camera.raw_left().lens().k1().constant(), -0.17);
  EXPECT_EQ(camera.raw_right().fx_px().constant(), 699);
  // X_right = R X_left + T with T along -x: the baseline is the right camera's own x axis, and the
  // left camera alone is turned.
  EXPECT_NEAR(std::abs(camera.raw_left().vergence_deg().constant()), 0.01 * 180 / 3.14159265, 1e-6);
  EXPECT_NEAR(camera.raw_right().vergence_deg().constant(), 0, 1e-9);
  const auto again = Read(MessageToYaml(*config));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(MessageDifferencer::Equals(*again, *config)) << MessageToYaml(*config);
}

TEST_F(CameraConfigTest, EachConflictNamesItsFieldAndWhatIsAllowed) {
  Write("odd.txt", "cam0=[1 2]\n");
  Write("p2.txt", "P2: 700 0 600 0 0 700 180 0 0 0 1 0\nP3: 700 0 600 -350 0 700 180 0 0 0 1 0\n");
  const struct {
    const char* yaml;
    std::string want;
  } rows[] = {
      {"rigs:\n  horizontal_fov_deg: 60\n  camera: {fx_px: 900}",
       "f.yaml:2: rigs.horizontal_fov_deg: given beside the focal length of rigs.camera (fx_px), "
       "allowed is one of them"},
      {"rigs: {horizontal_fov_deg: 60, camera: {preset: kitti}}",
       "f.yaml:1: rigs.horizontal_fov_deg: given beside the focal length of rigs.camera (fx_px, "
       "preset kitti), allowed"},
      {"rigs: {camera: {preset: zed}}", "f.yaml:1: rigs.camera.preset: \"zed\" is not known"},
      {"rigs: {camera: {preset: kitti, calibration: calib.txt}}",
       "f.yaml:1: rigs.camera.calibration: given beside a preset, allowed is one of them"},
      {"rigs: {camera: {calibration: nowhere.txt}}",
       "f.yaml:1: rigs.camera.calibration: " + dir_ + "/nowhere.txt: no such file, allowed"},
      {"rigs: {camera: {calibration: odd.txt}}",
       "f.yaml:1: rigs.camera.calibration: " + dir_ + "/odd.txt:1: cam0: 2 numbers, allowed is 9"},
      {"rigs: {camera: {calibration: p2.txt}}",
       "f.yaml:1: rigs.camera.calibration: " + dir_ + "/p2.txt does not say the size"},
      {"rigs: {camera: {calibration: calib.txt, calibration_sha256: abc}}",
       "f.yaml:1: rigs.camera.calibration: " + dir_ + "/calib.txt is not the file of"},
      {"rigs: {camera: {fy_px: 900}}", "f.yaml:1: rigs.camera.fy_px: given without fx_px"},
      {"rigs: {camera: {fx_px: 90}}",
       "f.yaml:1: rigs.camera.fx_px: reaches down to 90, allowed is at least 106.6666"},
      {"rigs: {camera: {cx_px: {uniform: [600, 1300]}}}",
       "f.yaml:1: rigs.camera.cx_px: reaches from 600 to 1300, allowed 0 to 1280 px"},
      {"rigs: {camera: {width_px: 900}}", "f.yaml:1: rigs.camera.width_px: given alone"},
      {"rigs: {camera: {lens: {k1: -0.1}}}",
       "f.yaml:1: rigs.camera.lens.k1: given without a model"},
      {"rigs: {camera: {lens: {model: kannala_brandt, p1: 0.1}}}",
       "f.yaml:1: rigs.camera.lens.p1: kannala_brandt has k1, k2, k3 and k4"},
      {"rigs: {camera: {preset: oak_d, lens: {model: brown_conrady, k1: {uniform: [-0.4, -0.1]}}}}",
       "f.yaml:1: rigs.camera.lens: with the coefficients -0.4 0 0 0 0 0 0 0 no direction leads"},
      {"render: {maps: [depth, raw]}", "f.yaml:1: render.maps: raw without a raw pair, allowed"},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.yaml);
    EXPECT_THAT(ErrorOf(row.yaml), StartsWith(dir_ + "/" + row.want));
  }
}

TEST_F(CameraConfigTest, AMessageMustBringItsNumbers) {
  v1::StudySpec study;
  study.set_name("s");
  study.set_pairs(1);
  study.set_rigs_per_scene(1);
  v1::VariantSpec& variant = *study.add_variants();
  variant.set_name("a");
  variant.mutable_config()->mutable_rigs()->mutable_camera()->set_preset("kitti");
  EXPECT_THAT(std::string(ToStd(ValidateStudy(study).message())),
              HasSubstr("rigs.camera.preset: without its numbers"));
}

}  // namespace
}  // namespace parallax
