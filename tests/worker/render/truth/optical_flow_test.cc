// Flow between frames of a sequence against closed forms, and what frames with one left eye share.
#include "worker/render/truth/optical_flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/math/sequence.h"
#include "tests/worker/render/render_frame.h"

namespace parallax {
namespace {

using test::DiffuseSample;
using test::MakeBox;
using test::MakeBoxRoom;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::TestScene;

constexpr int kWidth = 96, kHeight = 64;
constexpr double kFocal = 80, kBaseline = 0.2;

v1::RenderConfig FlowConfig() {
  v1::RenderConfig config = MakeConfig(1, 1, false);
  config.add_maps("flow");
  return config;
}

// Frames at these places, 0.1 s apart, that look along +y.
void AddWay(const std::vector<Vec3d>& eyes, TestScene* test) {
  for (const Vec3d& eye : eyes) {
    v1::Rig rig = MakeRig(eye, Vec3d::UnitY(), kWidth, kHeight, kFocal, kBaseline);
    rig.set_index(static_cast<uint32_t>(test->recipe.rigs_size()));
    rig.set_path(1);
    rig.set_time_s(0.1 * test->recipe.rigs_size());
    *test->recipe.add_rigs() = rig;
  }
}

// A wall at y = 4 that fills the view, and before it a plate at y = 2, |x|, |z| < 0.4.
TestScene WallAndPlate() {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f(0.5f, 0.5f, 0.5f)));
  test.AddMesh(MakeQuad({-9, 4, -9}, {18, 0, 0}, {0, 0, 18}), grey);
  test.AddMesh(MakeQuad({-0.4f, 2, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}), grey);
  test.AddPointLight({0, -1, 0}, 0.1, 100);
  for (v1::SceneObject& object : *test.recipe.mutable_objects()) {
    object.mutable_world_from_object()->set_qw(1);
    object.mutable_world_from_object()->set_scale(1);
  }
  return test;
}

const float* FlowAt(const FlowMaps& maps, int x, int y) { return maps.flow.At(x, y); }

TEST(Flow, OfAStillWallFollowsFromTheCamerasWay) {
  TestScene test = WallAndPlate();
  AddWay({{0, 0, 0}, {0.1, 0.5, 0.05}}, &test);
  const StereoFrame frame = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(0));
  // A corner of the picture: the wall, 4 m away and then 3.5 m.
  for (const auto& [x, y] : std::vector<std::pair<int, int>>{{3, 5}, {90, 60}, {5, 58}}) {
    const double right = (x + 0.5 - kWidth / 2.0) / kFocal * 4,
                 down = (y + 0.5 - kHeight / 2.0) / kFocal * 4;
    const float* flow = FlowAt(frame.left.forward, x, y);
    EXPECT_NEAR(flow[0], kWidth / 2.0 + kFocal * (right - 0.1) / 3.5 - (x + 0.5), 2e-4);
    EXPECT_NEAR(flow[1], kHeight / 2.0 + kFocal * (down + 0.05) / 3.5 - (y + 0.5), 2e-4);
    EXPECT_NEAR(flow[2], kFocal * kBaseline * (1 / 3.5 - 1 / 4.0), 1e-4);
  }
}

TEST(Flow, OfAMovingObjectFollowsItsMotion) {
  TestScene test = WallAndPlate();
  v1::RigidMotion& motion = *test.recipe.mutable_objects(1)->mutable_motion();
  motion.mutable_velocity_mps()->set_x(1);
  motion.mutable_velocity_mps()->set_y(-2);
  motion.mutable_spin_rps()->set_y(M_PI / 2);  // About the plate's normal through the origin.
  AddWay({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, &test);
  // The middle frame: 0.1 s have passed, the plate is 1.8 m away.
  const StereoFrame frame = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(1));
  const int x = kWidth / 2 + 6, y = kHeight / 2 - 4;
  ASSERT_NEAR(frame.left.depth_m(x, y), 1.8, 1e-5);
  const auto moved = [&](double dt) {
    const Vec3d now(6.5 / kFocal * 1.8, 1.8, 3.5 / kFocal * 1.8);  // World; z up.
    const Vec3d origin(0.1, -0.2, 0);                              // The object's, now.
    const Eigen::AngleAxisd turn(M_PI / 2 * dt, Vec3d::UnitY());
    return Vec3d(origin + dt * Vec3d(1, -2, 0) + turn * (now - origin));
  };
  for (const double dt : {0.1, -0.1}) {
    const FlowMaps& maps = dt > 0 ? frame.left.forward : frame.left.backward;
    const Vec3d then = moved(dt);
    EXPECT_NEAR(FlowAt(maps, x, y)[0], kFocal * then.x() / then.y() - 6.5, 3e-4);
    EXPECT_NEAR(FlowAt(maps, x, y)[1], -kFocal * then.z() / then.y() + 3.5, 3e-4);
    EXPECT_NEAR(FlowAt(maps, x, y)[2], kFocal * kBaseline * (1 / then.y() - 1 / 1.8), 2e-4);
    // The wall rests.
    EXPECT_EQ(FlowAt(maps, 2, 2)[0], 0);
    EXPECT_EQ(FlowAt(maps, 2, 2)[2], 0);
  }
}

TEST(Flow, WhatAMovingObjectComesToHideIsOccluded) {
  TestScene test = WallAndPlate();
  test.recipe.mutable_objects(1)->mutable_motion()->mutable_velocity_mps()->set_x(5);
  AddWay({{0, 0, 0}, {0, 0, 0}}, &test);
  const StereoFrame frame = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(0));
  // The plate spans 32 pixels about the middle and moves 20 to the right.
  const int row = kHeight / 2, middle = kWidth / 2;
  EXPECT_EQ(frame.left.forward.occlusion(middle + 10, row), kFlowVisible);   // The plate itself.
  EXPECT_EQ(frame.left.forward.occlusion(middle + 25, row), kFlowOccluded);  // Wall that it covers.
  EXPECT_EQ(frame.left.forward.occlusion(middle + 40, row), kFlowVisible);   // Wall beside it.
  EXPECT_EQ(frame.left.forward.occlusion(middle - 30, row), kFlowVisible);
  EXPECT_EQ(FlowAt(frame.left.forward, middle + 25, row)[0], 0);
  EXPECT_NEAR(FlowAt(frame.left.forward, middle + 10, row)[0], 20, 1e-3);
  // A point that leaves the picture is occluded too.
  TestScene fast = WallAndPlate();
  fast.recipe.mutable_objects(1)->mutable_motion()->mutable_velocity_mps()->set_x(30);
  AddWay({{0, 0, 0}, {0, 0, 0}}, &fast);
  const StereoFrame gone = test::RenderFrame(fast, FlowConfig(), fast.recipe.rigs(0));
  EXPECT_EQ(gone.left.forward.occlusion(middle, row), kFlowOccluded);
}

TEST(Flow, ForwardAndBackwardOfVisiblePointsAreOpposite) {
  TestScene test = MakeBoxRoom();
  AddWay({{2, 0.5, 1.5}, {2.05, 0.6, 1.48}}, &test);
  const StereoFrame now = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(0));
  const StereoFrame then = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(1));
  const std::pair<const View*, const View*> eyes[] = {{&now.left, &then.left},
                                                      {&now.right, &then.right}};
  for (const auto& [a, b] : eyes) {
    int good = 0, seen = 0;
    for (int y = 1; y + 1 < kHeight; ++y) {
      for (int x = 1; x + 1 < kWidth; ++x) {
        if (a->forward.occlusion(x, y) != kFlowVisible) continue;
        const float* f = FlowAt(a->forward, x, y);
        const int u = static_cast<int>(std::floor(x + 0.5f + f[0]));
        const int v = static_cast<int>(std::floor(y + 0.5f + f[1]));
        if (b->objects(u, v) != a->objects(x, y)) continue;
        const float* g = FlowAt(b->backward, u, v);
        ++seen;
        good += std::hypot(f[0] + g[0], f[1] + g[1]) < 0.5f && std::abs(f[2] + g[2]) < 0.2f;
      }
    }
    EXPECT_GT(seen, kWidth * kHeight / 2);
    EXPECT_GT(good, 0.98 * seen);
  }
}

TEST(Flow, IsNoneAtTheEndsOfASequence) {
  TestScene test = WallAndPlate();
  AddWay({{0, 0, 0}, {0.1, 0, 0}}, &test);
  const StereoFrame first = test::RenderFrame(test, FlowConfig(), test.recipe.rigs(0));
  EXPECT_EQ(first.right.backward.flow, ImageF3(kWidth, kHeight));
  EXPECT_EQ(first.right.backward.occlusion, ImageU8(kWidth, kHeight, kFlowNone));
  EXPECT_NE(first.right.forward.flow, ImageF3(kWidth, kHeight));
}

TEST(Flow, PicturesOfAMovingSceneDoNotDependOnTheOrderOfFrames) {
  TestScene test = MakeBoxRoom();
  for (v1::SceneObject& object : *test.recipe.mutable_objects()) {
    object.mutable_world_from_object()->set_qw(1);
    object.mutable_world_from_object()->set_scale(1);
  }
  test.recipe.mutable_objects(2)->mutable_motion()->mutable_velocity_mps()->set_z(0.5);
  AddWay({{2, 0.5, 1.5}, {2, 0.5, 1.5}, {2, 0.5, 1.5}}, &test);
  v1::RenderConfig config = MakeConfig(2, 4, false, "preview");
  config.add_maps("flow");
  const StereoFrame alone = test::RenderFrame(test, config, test.recipe.rigs(2));
  auto renderer = Renderer::Create(test.recipe, test.geometry, config);
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  ASSERT_TRUE((*renderer)->RenderRig(test.recipe.rigs(0), {}, {}).ok());
  const auto after = (*renderer)->RenderRig(test.recipe.rigs(2), {}, {});
  EXPECT_EQ(alone.left.color, after->left.color);
  EXPECT_EQ(alone.right.depth_m, after->right.depth_m);
  EXPECT_EQ(alone.left.backward.flow, after->left.backward.flow);
  EXPECT_EQ(alone.left.backward.occlusion, after->left.backward.occlusion);
}

// Two left eyes with three right ones each.
TestScene SharedRoom() {
  TestScene test = MakeBoxRoom();
  for (int i = 0; i < 6; ++i) {
    v1::Rig rig = test::BoxRoomRig(72, 54);
    rig.mutable_world_from_left()->set_tx(rig.world_from_left().tx() + 0.1 * (i / 3));
    rig.set_index(static_cast<uint32_t>(i));
    rig.set_baseline_m(0.05 * (1 << i % 3));
    rig.set_shares_left(i % 3 > 0);
    *test.recipe.add_rigs() = rig;
  }
  return test;
}

TEST(SharedLeft, LeftPicturesAndMapsAreTheSameInWhicheverOrder) {
  const TestScene test = SharedRoom();
  const v1::RenderConfig config = MakeConfig(2, 3, true, "preview");
  auto renderer = Renderer::Create(test.recipe, test.geometry, config);
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  std::vector<StereoFrame> frames;
  for (const v1::Rig& rig : test.recipe.rigs()) {
    frames.push_back(*(*renderer)->RenderRig(rig, {}, {}));
  }
  for (const size_t i : {1, 2}) {
    EXPECT_EQ(frames[0].left.color, frames[i].left.color);
    EXPECT_EQ(frames[0].left.depth_m, frames[i].left.depth_m);
    EXPECT_EQ(frames[0].left.objects, frames[i].left.objects);
    EXPECT_EQ(frames[0].exposure, frames[i].exposure);
    EXPECT_NE(frames[0].right.color, frames[i].right.color);
    EXPECT_NEAR(frames[i].left.disparity_px(30, 20) / frames[0].left.disparity_px(30, 20), 1 << i,
                1e-4);
  }
  EXPECT_NE(frames[0].left.color, frames[3].left.color);
  // By itself, and after others: the same bytes.
  for (const int i : {5, 2, 4}) {
    const StereoFrame alone = test::RenderFrame(test, config, test.recipe.rigs(i));
    const StereoFrame& all = frames[static_cast<size_t>(i)];
    EXPECT_EQ(alone.left.color, all.left.color) << i;
    EXPECT_EQ(alone.right.color, all.right.color) << i;
    EXPECT_EQ(alone.left.masks, all.left.masks) << i;
    EXPECT_EQ(alone.left.disparity_px, all.left.disparity_px) << i;
    EXPECT_EQ(alone.left.occlusion, all.left.occlusion) << i;
    EXPECT_EQ(alone.exposure, all.exposure) << i;
  }
}

TEST(SharedLeft, InfraredPicturesOfTheLeftEyeAreTheSame) {
  TestScene test = SharedRoom();
  v1::Projector projector;
  projector.set_power_w(0.3);
  projector.set_dots(2000);
  projector.set_horizontal_fov_rad(1.2);
  projector.set_vertical_fov_rad(1);
  projector.set_dot_rad(0.004);
  projector.set_place_m(0.03);
  for (v1::Rig& rig : *test.recipe.mutable_rigs()) {
    *rig.mutable_projector() = projector;
    // The right eyes of large baselines see other light.
    if (rig.shares_left()) rig.set_baseline_m(0.8);
  }
  v1::RenderConfig config = MakeConfig(2, 3, false, "preview");
  config.add_maps("infrared");
  const StereoFrame first = test::RenderFrame(test, config, test.recipe.rigs(0));
  const StereoFrame second = test::RenderFrame(test, config, test.recipe.rigs(1));
  EXPECT_EQ(first.left.infrared, second.left.infrared);
  EXPECT_EQ(first.infrared_exposure, second.infrared_exposure);
  EXPECT_NE(first.right.infrared, second.right.infrared);
}

TEST(SharedLeft, AFurtherRightEyeTracesHalfTheRays) {
  const TestScene test = SharedRoom();
  auto renderer = Renderer::Create(test.recipe, test.geometry, MakeConfig(4, 3, false, "preview"));
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  const auto first = (*renderer)->RenderRig(test.recipe.rigs(0), {}, {});
  const auto second = (*renderer)->RenderRig(test.recipe.rigs(1), {}, {});
  EXPECT_GT(second->rays, 0.4 * static_cast<double>(first->rays));
  EXPECT_LT(second->rays, 0.6 * static_cast<double>(first->rays));
}

// A pair whose wall, 4 m away, has a disparity of 4.5 px.
StereoFrame RenderHalfPixelPair(TestScene& test) {
  v1::RenderConfig config = MakeConfig(1, 1, false);
  config.add_maps("exact_occlusion");
  const v1::Rig rig =
      MakeRig(Vec3d::Zero(), Vec3d::UnitY(), kWidth, kHeight, kFocal, 4.5 * 4 / kFocal);
  *test.recipe.add_rigs() = rig;
  return test::RenderFrame(test, config, rig);
}

TEST(ExactOcclusion, FindsWhatStandsBetweenThePixelsOfTheOtherPicture) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f(0.5f, 0.5f, 0.5f)));
  test.AddMesh(MakeQuad({-9, 4, -9}, {18, 0, 0}, {0, 0, 18}), grey);
  // A fifth of a pixel wide, 2 m away, on the line from the right eye to the wall at the centre of
  // the left pixels of this column.
  constexpr int kColumn = 60;
  const double on_wall = (kColumn + 0.5 - kWidth / 2.0) / kFocal * 4;
  const auto middle = static_cast<float>((on_wall + 4.5 * 4 / kFocal) / 2);
  const float width = 0.2f / kFocal * 2;
  test.AddMesh(MakeQuad({middle - width / 2, 2, -9}, {width, 0, 0}, {0, 0, 18}), grey);
  test.AddPointLight({0, -1, 0}, 0.1, 100);
  const StereoFrame frame = RenderHalfPixelPair(test);
  for (int x = 0; x < kWidth; ++x) {
    SCOPED_TRACE(x);
    const bool outside = x + 0.5 < 4.5;
    EXPECT_EQ(frame.left.occlusion(x, 20), outside ? 255 : 0);
    EXPECT_EQ(frame.left.exact_occlusion(x, 20), outside || x == kColumn ? 255 : 0);
    // By symmetry the column of that number is hidden from the left eye.
    const bool outside_left = x + 0.5 + 4.5 >= kWidth;
    EXPECT_EQ(frame.right.exact_occlusion(x, 20), outside_left || x == kColumn ? 255 : 0);
  }
}

TEST(ExactOcclusion, IsThatOfReprojectionAwayFromEdges) {
  TestScene test = WallAndPlate();
  const StereoFrame frame = RenderHalfPixelPair(test);
  for (const View* view : {&frame.left, &frame.right}) {
    int hidden = 0, different = 0;
    for (size_t i = 0; i < view->occlusion.values().size(); ++i) {
      hidden += view->exact_occlusion.values()[i] == 255;
      different += view->exact_occlusion.values()[i] != view->occlusion.values()[i];
    }
    EXPECT_GT(hidden, 4 * kHeight) << "beside the plate and outside of the picture";
    EXPECT_LE(different, 2 * kHeight) << "at the sides of the plate";
  }
}

TEST(ExactOcclusion, IsTracedOnlyWhereAskedFor) {
  TestScene test = WallAndPlate();
  AddWay({{0, 0, 0}}, &test);
  EXPECT_TRUE(test::RenderFrame(test, MakeConfig(1, 1, false), test.recipe.rigs(0))
                  .left.exact_occlusion.empty());
}

}  // namespace
}  // namespace parallax
