// The parts of a land that rigs see in plan, and the way of their eyes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/worker/scene/small_land.h"
#include "worker/scene/types/nature/ground/views.h"

namespace parallax {
namespace {

using Rigs = google::protobuf::RepeatedPtrField<v1::Rig>;

// Both raw cameras are fisheyes of this focal length; 0: none exist.
Rigs OneRig(double raw_focal_px) {
  Rigs rigs;
  v1::Rig& rig = *rigs.Add();
  rig = RigAt(Vec3d(0, 0, 2), 1, 0);
  if (raw_focal_px <= 0) return rigs;
  v1::RawCamera& raw = *rig.mutable_raw_left();
  raw.set_width_px(160);
  raw.set_height_px(90);
  raw.set_fx_px(raw_focal_px);
  raw.set_fy_px(raw_focal_px);
  raw.set_cx_px(80);
  raw.set_cy_px(45);
  raw.set_lens(v1::LensConfig::MODEL_KANNALA_BRANDT);
  for (int i = 0; i < 4; ++i) raw.add_distortion(0);
  raw.set_qw(1);
  *rig.mutable_raw_right() = raw;
  return rigs;
}

// Whether something small is wanted 50 m away, so far to the left of +x, where the rig looks.
bool WantsAt(const Rigs& rigs, double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180;
  const Vec2f place = 50 * Vec2d(std::cos(angle), std::sin(angle)).cast<float>();
  return Views(rigs).Wants(place, 0.1f, 1, 100);
}

TEST(Views, RawCamerasWidenWhatIsSeen) {
  EXPECT_TRUE(WantsAt(OneRig(0), 15));
  EXPECT_FALSE(WantsAt(OneRig(0), 40));
  // 80 px from the axis are 1.2 rad: 69 degrees.
  EXPECT_TRUE(WantsAt(OneRig(66.7), 65));
  EXPECT_TRUE(WantsAt(OneRig(66.7), -65));
  EXPECT_FALSE(WantsAt(OneRig(66.7), 120));
}

TEST(Views, ARawCameraThatSeesStraightDownSeesAllAround) {
  // 45 px from the axis are 1.6 rad: 92 degrees.
  EXPECT_TRUE(WantsAt(OneRig(28), 170));
}

TEST(Views, ARawCameraThatIsTurnedSeesWhereItLooks) {
  Rigs rigs = OneRig(200);  // 23 degrees to each side.
  const double half = 30 * std::numbers::pi / 180;
  // By 60 degrees to the right, about the camera's axis that points down.
  rigs.Mutable(0)->mutable_raw_right()->set_qw(std::cos(half));
  rigs.Mutable(0)->mutable_raw_right()->set_qy(std::sin(half));
  EXPECT_TRUE(WantsAt(rigs, -80));
  EXPECT_FALSE(WantsAt(rigs, -110));
}

TEST(Views, WhatIsNearIsMadeForTheSharpestCamera) {
  EXPECT_EQ(Views(OneRig(0)).focal_px(), static_cast<float>(OneRig(0)[0].fx_px()));
  EXPECT_EQ(Views(OneRig(500)).focal_px(), 500);
}

// Two frames 6 m apart, looking across their way.
Rigs TwoFrames(uint32_t second_path) {
  Rigs rigs;
  *rigs.Add() = RigAt(Vec3d(0, 0, 2), 1);
  *rigs.Add() = RigAt(Vec3d(6, 0, 2), second_path);
  return rigs;
}

TEST(EyeWay, LeadsFromFrameToFrameOfOneWalk) {
  const Vec3f between(3, 0.2f, 2);
  EXPECT_TRUE(EyeWay(Views(TwoFrames(1)), 0).Meets(between, 0.05f, 0.2f));
  EXPECT_FALSE(EyeWay(Views(TwoFrames(1)), 0).Meets(between, 0.05f, 0.1f));
  EXPECT_TRUE(EyeWay(Views(TwoFrames(1)), 0).IsWithin(between.head<2>(), 0.25f));
  EXPECT_FALSE(EyeWay(Views(TwoFrames(1)), 0).IsWithin(between.head<2>(), 0.15f));
  EXPECT_FALSE(EyeWay(Views(TwoFrames(2)), 0).Meets(between, 0.05f, 0.2f));
  EXPECT_FALSE(EyeWay(Views(TwoFrames(2)), 0).IsWithin(between.head<2>(), 2));
  // Single views belong to no walk.
  Rigs single = TwoFrames(0);
  single.Mutable(0)->set_path(0);
  EXPECT_FALSE(EyeWay(Views(single), 0).Meets(between, 0.05f, 0.2f));
}

TEST(EyeWay, HasTheRightEyeAtTheRigsBaselineOrALargerOne) {
  // The right eye is 0.1 m beside the left one, on the side of +x.
  const Vec3f beside(6.6f, 0, 2);
  EXPECT_FALSE(EyeWay(Views(TwoFrames(1)), 0).Meets(beside, 0, 0.3f));
  EXPECT_TRUE(EyeWay(Views(TwoFrames(1)), 0).Meets(beside, 0, 0.55f));
  EXPECT_TRUE(EyeWay(Views(TwoFrames(1)), 0.5f).Meets(beside, 0, 0.15f));
  EXPECT_TRUE(EyeWay(Views(TwoFrames(1)), 0.5f).IsWithin(beside.head<2>(), 0.15f));
  EXPECT_FALSE(EyeWay(Views(TwoFrames(1)), 0.05f).IsWithin(beside.head<2>(), 0.3f));
}

}  // namespace
}  // namespace parallax
