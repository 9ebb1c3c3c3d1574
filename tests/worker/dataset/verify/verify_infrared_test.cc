// Faults that verify finds in infrared pictures of frames that the renderer made.
#include "worker/dataset/verify/verify_infrared.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/render/render_frame.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::ordered_json;
using test::DiffuseSample;
using test::MakeBox;
using test::MakeConfig;
using test::MakeQuad;
using test::TestScene;

// A wall, and before it a box that throws a shadow of dots to one side.
TestScene WallWithBox(bool box) {
  TestScene scene;
  const uint32_t grey = scene.AddMaterial(DiffuseSample(Vec3f::Constant(0.6f)));
  scene.AddMesh(MakeQuad({-9, 2, -9}, {18, 0, 0}, {0, 0, 18}), grey);
  if (box) scene.AddMesh(MakeBox({-0.35f, 0.9f, -0.5f}, {0.15f, 1.1f, 0.5f}), grey);
  scene.AddPointLight({0, -2, 1}, 0, 40);
  return scene;
}

class VerifyInfraredTest : public FolderTest {
 protected:
  void SetUp() override {
    rig_ = test::MakeRig({0, 0, 0}, {0, 1, 0}, 320, 240, 260, 0.3);
    v1::Projector& projector = *rig_.mutable_projector();
    projector.set_place_m(0.15);
    projector.set_power_w(3);
    projector.set_dots(2500);
    projector.set_horizontal_fov_rad(65 * std::numbers::pi / 180);
    projector.set_vertical_fov_rad(55 * std::numbers::pi / 180);
    projector.set_dot_rad(0.3 * std::numbers::pi / 180);
    projector.set_seed(3);
  }

  StereoFrame Render(bool box) const {
    v1::RenderConfig config = MakeConfig(2, 1, /*denoise=*/false);
    config.add_maps("infrared");
    return test::RenderFrame(WallWithBox(box), config, rig_);
  }

  // Verify's findings on the truth of one frame beside the infrared pictures of another.
  std::vector<Finding> Check(const StereoFrame& truth, const ImageU8& left, const ImageU8& right,
                             float exposure) const {
    EXPECT_TRUE(WritePng(dir_ + "/infrared_left.png", left).ok());
    EXPECT_TRUE(WritePng(dir_ + "/infrared_right.png", right).ok());
    EXPECT_TRUE(WriteExrY(dir_ + "/depth_left.exr", truth.left.depth_m).ok());
    EXPECT_TRUE(WriteExrY(dir_ + "/depth_right.exr", truth.right.depth_m).ok());
    const v1::Projector& p = rig_.projector();
    const Json json = {
        {"intrinsics",
         {{"fx", 260}, {"fy", 260}, {"cx", 160}, {"cy", 120}, {"width", 320}, {"height", 240}}},
        {"baseline_m", rig_.baseline_m()},
        {"infrared",
         {{"exposure", exposure},
          {"projector",
           {{"place_m", p.place_m()},
            {"power_w", p.power_w()},
            {"dots", p.dots()},
            {"horizontal_fov_rad", p.horizontal_fov_rad()},
            {"vertical_fov_rad", p.vertical_fov_rad()},
            {"dot_rad", p.dot_rad()},
            {"seed", std::to_string(p.seed())}}}}}};
    return CheckInfrared({.dir = dir_}, json);
  }

  v1::Rig rig_;
};

TEST_F(VerifyInfraredTest, AcceptsWhatTheRendererMakes) {
  const StereoFrame frame = Render(/*box=*/true);
  EXPECT_THAT(Check(frame, frame.left.infrared, frame.right.infrared, frame.infrared_exposure),
              IsEmpty());
}

TEST_F(VerifyInfraredTest, FindsPicturesOfTheOtherEye) {
  const StereoFrame frame = Render(/*box=*/true);
  const auto found =
      Check(frame, frame.right.infrared, frame.left.infrared, frame.infrared_exposure);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_THAT(found[0].message, HasSubstr("do not stand where depth says"));
  EXPECT_THAT(found[0].path, HasSubstr("infrared_left.png"));
}

TEST_F(VerifyInfraredTest, FindsDotsInTheProjectorsShadow) {
  const StereoFrame truth = Render(/*box=*/true), open = Render(/*box=*/false);
  const auto found = Check(truth, open.left.infrared, open.right.infrared, open.infrared_exposure);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].message, HasSubstr("in the projector's shadow"));
}

TEST_F(VerifyInfraredTest, FindsMissingPicturesAndThoseOfAnotherSize) {
  const StereoFrame frame = Render(/*box=*/true);
  auto found = Check(frame, ImageU8(32, 24, 9), frame.right.infrared, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message, HasSubstr("32x24, frame.json says 320x240"));
}

}  // namespace
}  // namespace parallax
