// Cameras of rigs, from the config to the recipe.
#include "worker/scene/rigs/rig_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "common/config/config.h"
#include "common/math/raw_rig.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

v1::SceneConfig ConfigOf(const std::string& yaml) {
  const auto config = ParseSceneConfig(yaml, "f.yaml");
  EXPECT_TRUE(config.ok()) << config.status();
  return *config;
}

TEST(RigCamera, WithoutACameraItIsTheCentredOneOfTheFieldOfView) {
  const v1::SceneConfig config = DefaultSceneConfig();
  const RigCamera camera = DrawRigCamera(config.rigs(), 0.25, Rng(SceneSeed{5}, "camera"));
  const double fov = Draw(config.rigs().horizontal_fov_deg(), 0.25) * std::numbers::pi / 180;
  EXPECT_EQ(camera.k.fx_px, 1280 / 2.0 / std::tan(fov / 2));
  EXPECT_EQ(camera.k.fy_px, camera.k.fx_px);
  EXPECT_EQ(camera.k.cx_px, 640);
  EXPECT_EQ(camera.shift_x, 0);
  EXPECT_EQ(camera.half_x, std::tan(fov / 2));
  EXPECT_NEAR(camera.half_y, std::tan(fov / 2) * 720 / 1280, 1e-15);
}

TEST(RigCamera, KIsThatOfTheConfigScaledToThePicture) {
  const v1::SceneConfig config = ConfigOf(
      "rigs: {width_px: 621, height_px: 188, camera: {preset: kitti, fy_px: 700, cy_px: {uniform: "
      "[100, 200]}}}");
  const RigCamera camera = DrawRigCamera(config.rigs(), 0.5, Rng(SceneSeed{5}, "camera"));
  EXPECT_NEAR(camera.k.fx_px, 721.5377 / 2, 1e-9);
  constexpr double kDown = 188.0 / 375;
  EXPECT_NEAR(camera.k.fy_px, 700 * kDown, 1e-9);
  EXPECT_NEAR(camera.k.cx_px, 609.5593 / 2, 1e-9);
  EXPECT_GT(camera.k.cy_px, 100 * kDown);
  EXPECT_LT(camera.k.cy_px, 200 * kDown);
  // Corners of the picture lie where K puts them.
  const Vec3d corner = camera.DirectionAt(-1, 1);
  EXPECT_NEAR(corner.x(), -camera.k.cx_px / camera.k.fx_px, 1e-12);
  EXPECT_NEAR(corner.y(), (188 - camera.k.cy_px) / camera.k.fy_px, 1e-12);
  EXPECT_GE(camera.Corner(), corner.norm());
}

TEST(RigCamera, RawCamerasHaveLensesOfTheirOwnAndTurns) {
  const v1::SceneConfig config = ConfigOf(
      "rigs: {width_px: 640, height_px: 400, camera: {preset: oak_d, lens: {model: brown_conrady, "
      "k1: {uniform: [-0.2, -0.1]}, k2: 0.03}, raw_right: {vergence_deg: 0.5, pitch_deg: -0.25, "
      "fx_px: "
      "790}}}\nrender: {maps: [raw]}");
  v1::Rig rig = MakeRig({.baseline_m = 0.075,
                         .k = DrawRigCamera(config.rigs(), 0, Rng(SceneSeed{5}, "camera")).k,
                         .width_px = 640,
                         .height_px = 400});
  AddRawCameras(config.rigs(), Rng(SceneSeed{5}, "camera"), &rig);
  EXPECT_NEAR(rig.raw_left().fx_px(), rig.fx_px(), 1e-12);
  EXPECT_NEAR(rig.raw_right().fx_px(), 395, 1e-12) << "half the size";
  EXPECT_EQ(rig.raw_left().width_px(), 640);
  ASSERT_EQ(rig.raw_left().distortion_size(), 5);
  EXPECT_NE(rig.raw_left().distortion(0), rig.raw_right().distortion(0));
  const CameraTurn turn = TurnOfRotation(FromProto(rig.raw_right()).rectified_from_raw);
  EXPECT_NEAR(turn.yaw_rad, -0.5 * std::numbers::pi / 180, 1e-12) << "towards the left camera";
  EXPECT_NEAR(turn.pitch_rad, -0.25 * std::numbers::pi / 180, 1e-12);
  v1::Scene scene;
  *scene.add_rigs() = rig;
  EXPECT_TRUE(CheckRawCameras(scene).ok()) << CheckRawCameras(scene);
  scene.mutable_rigs(0)->mutable_raw_right()->set_distortion(0, -0.9);
  const absl::Status ends = CheckRawCameras(scene);
  EXPECT_EQ(ends.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ToStd(ends.message())),
              HasSubstr("rig 0: rigs.camera: the right lens: its distortion ends within"));
}

TEST(RigCamera, EveryRigOfARecipeHasTheConfigsK) {
  v1::SolveJob job;
  *job.mutable_config() = ConfigOf(
      "type: dense\nfloating: {count: 2, classes: [Vase], placement: view}\nrigs: {count: 2, "
      "camera: {preset: eth3d}}");
  job.set_scene_seed(7);
  const auto result = Solve(job, {});
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->scene().rigs_size(), 2);
  for (const v1::Rig& rig : result->scene().rigs()) {
    EXPECT_EQ(rig.fx_px(), 541.764);
    EXPECT_EQ(rig.cx_px(), 553.869);
    EXPECT_EQ(rig.cy_px(), 232.396);
    EXPECT_EQ(rig.baseline_m(), 0.0599054);
    EXPECT_EQ(rig.width_px(), 941);
    EXPECT_FALSE(rig.has_raw_left());
  }
}

TEST(RigProjector, RigsCarryOneDeviceAndNothingElseChanges) {
  v1::SolveJob job;
  job.set_scene_seed(7);
  const auto solve = [&job](const std::string& power) {
    *job.mutable_config() = ConfigOf(
        "type: dense\nfloating: {count: 2, classes: [Vase], placement: view}\nrigs: {count: 3}\n"
        "lighting: {projector: {power_w: " +
        power +
        ", dots: 900, horizontal_fov_deg: {uniform: "
        "[40, 90]}, place: 0.25}}");
    const auto result = Solve(job, {});
    EXPECT_TRUE(result.ok()) << result.status();
    return result->scene();
  };
  v1::Scene with = solve("{uniform: [0.2, 0.4]}");
  const v1::Scene without = solve("0");
  ASSERT_EQ(with.rigs_size(), 3);
  for (const v1::Rig& rig : with.rigs()) {
    const v1::Projector& projector = rig.projector();
    EXPECT_GE(projector.power_w(), 0.2);
    EXPECT_LE(projector.power_w(), 0.4);
    EXPECT_EQ(projector.dots(), 900);
    EXPECT_EQ(projector.seed(), with.rigs(0).projector().seed());
    EXPECT_EQ(projector.horizontal_fov_rad(), with.rigs(0).projector().horizontal_fov_rad());
    EXPECT_EQ(projector.place_m(), 0.25 * rig.baseline_m());
  }
  for (const v1::Rig& rig : without.rigs()) EXPECT_FALSE(rig.has_projector());
  for (v1::Rig& rig : *with.mutable_rigs()) rig.clear_projector();
  EXPECT_EQ(with.SerializeAsString(), without.SerializeAsString());
}

}  // namespace
}  // namespace parallax
