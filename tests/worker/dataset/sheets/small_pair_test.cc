#include "worker/dataset/sheets/small_pair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/math/raw_rig.h"
#include "tests/worker/dataset/synthetic_scene.h"

namespace parallax {
namespace {

TEST(DisparityFigures, AreSharesOfThePixelsThatSeeASurface) {
  ImageF disparity_px(5, 2);
  const float values[] = {0, 0.5f, 0.9f, 1, 10, 20, 192, 193, 500, 30};
  std::copy(std::begin(values), std::end(values), disparity_px.data());
  const DisparityFigures figures = FiguresOf(disparity_px);
  EXPECT_DOUBLE_EQ(figures.share_no_surface, 0.1);
  EXPECT_DOUBLE_EQ(figures.share_below_1px, 2 / 9.0);
  EXPECT_DOUBLE_EQ(figures.share_beyond_192px, 2 / 9.0);
  EXPECT_FLOAT_EQ(static_cast<float>(figures.min_px), 0.5f);
  EXPECT_DOUBLE_EQ(figures.max_px, 500);
  EXPECT_DOUBLE_EQ(figures.median_px, 20);
  EXPECT_NEAR(figures.mean_px, 947.4 / 9, 1e-4);
}

TEST(DisparityFigures, ASkyHasNoDisparities) {
  const DisparityFigures figures = FiguresOf(ImageF(4, 4));
  EXPECT_EQ(figures.share_no_surface, 1);
  EXPECT_EQ(figures.max_px, 0);
  EXPECT_EQ(figures.share_below_1px, 0);
}

TEST(SmallRig, SeesWhatTheRigSeesAndOfLargeOnesOnly) {
  v1::Rig rig;
  rig.set_width_px(1280);
  rig.set_height_px(720);
  rig.set_fx_px(900);
  rig.set_fy_px(880);
  rig.set_cx_px(600);
  rig.set_cy_px(300);
  rig.set_baseline_m(0.2);
  rig.mutable_raw_left()->set_width_px(1600);
  rig.mutable_raw_left()->set_height_px(1200);
  rig.mutable_raw_left()->set_fx_px(1000);
  const v1::Rig small = SmallRig(rig, 320, 240);
  EXPECT_EQ(small.width_px(), 320);
  EXPECT_EQ(small.height_px(), 180);
  EXPECT_DOUBLE_EQ(small.fx_px(), 225);
  EXPECT_DOUBLE_EQ(small.fy_px(), 220);
  EXPECT_DOUBLE_EQ(small.cx_px(), 150);
  EXPECT_DOUBLE_EQ(small.cy_px(), 75);
  EXPECT_EQ(small.baseline_m(), 0.2);
  EXPECT_EQ(small.raw_left().width_px(), 320);
  EXPECT_EQ(small.raw_left().height_px(), 240);
  EXPECT_DOUBLE_EQ(small.raw_left().fx_px(), 200);
  EXPECT_FALSE(small.has_raw_right());
  EXPECT_EQ(SmallRig(small, 320, 240).SerializeAsString(), small.SerializeAsString());
  // A tall picture: its height is what fits.
  rig.set_width_px(720);
  rig.set_height_px(1280);
  EXPECT_EQ(SmallRig(rig, 320, 240).width_px(), 135);
}

// Figures from a picture of a quarter of the sides are those of the whole one: shares within half a
// percentage point, lengths within one percent.
TEST(SmallRig, GivesTheFiguresOfTheWholePicture) {
  const v1::Scene scene = MakeSyntheticScene(1, 1280, 720);
  // Some of the scene is too near for trainers with the first baseline, too far with the other.
  for (const double baseline_m : {0.9, 0.005}) {
    v1::Rig rig = scene.rigs(0);
    rig.set_baseline_m(baseline_m);
    const DisparityFigures whole = FiguresOf(RenderSyntheticFrame(scene, rig).left.disparity_px);
    const v1::Rig small = SmallRig(rig, 320, 240);
    ASSERT_EQ(small.width_px(), 320);
    ImageF disparity_px = RenderSyntheticFrame(scene, small).left.disparity_px;
    for (float& value : disparity_px.values()) value *= 4;
    const DisparityFigures figures = FiguresOf(disparity_px);
    EXPECT_GT(whole.share_below_1px + whole.share_beyond_192px, 0.02) << baseline_m;
    EXPECT_LT(whole.share_below_1px + whole.share_beyond_192px, 0.98) << baseline_m;
    EXPECT_NEAR(figures.share_below_1px, whole.share_below_1px, 0.005) << baseline_m;
    EXPECT_NEAR(figures.share_beyond_192px, whole.share_beyond_192px, 0.005) << baseline_m;
    EXPECT_NEAR(figures.share_no_surface, whole.share_no_surface, 0.005) << baseline_m;
    EXPECT_NEAR(figures.mean_px, whole.mean_px, 0.01 * whole.mean_px) << baseline_m;
    EXPECT_NEAR(figures.median_px, whole.median_px, 0.01 * whole.median_px) << baseline_m;
  }
}

// ---- Raw cameras
v1::RawCamera RawOf(const v1::Rig& rig, double pitch_rad, double k1) {
  v1::RawCamera raw;
  raw.set_width_px(rig.width_px());
  raw.set_height_px(rig.height_px());
  raw.set_fx_px(rig.fx_px());
  raw.set_fy_px(rig.fy_px());
  raw.set_cx_px(rig.cx_px());
  raw.set_cy_px(rig.cy_px());
  raw.set_lens(v1::LensConfig::MODEL_BROWN_CONRADY);
  for (const double value : {k1, 0.0, 0.0, 0.0, 0.0}) raw.add_distortion(value);
  const Eigen::Quaterniond turn(RotationOfTurn({.pitch_rad = pitch_rad}));
  raw.set_qw(turn.w());
  raw.set_qx(turn.x());
  raw.set_qy(turn.y());
  raw.set_qz(turn.z());
  return raw;
}

v1::Rig RawRig(double right_pitch_rad, double k1) {
  v1::Rig rig;
  rig.set_width_px(640);
  rig.set_height_px(480);
  rig.set_fx_px(500);
  rig.set_fy_px(500);
  rig.set_cx_px(320);
  rig.set_cy_px(240);
  rig.set_baseline_m(0.1);
  *rig.mutable_raw_left() = RawOf(rig, 0, k1);
  *rig.mutable_raw_right() = RawOf(rig, right_pitch_rad, k1);
  return rig;
}

// The correspondence of a wall that both eyes of `rig` see at this disparity.
RawView WallAt(const v1::Rig& rig, double disparity_px) {
  const RawIntrinsics left = FromProto(rig.raw_left()), right = FromProto(rig.raw_right());
  RawView view;
  view.flow = ImageF3(left.width_px, left.height_px);
  view.occlusion = ImageU8(left.width_px, left.height_px);
  for (int y = 0; y < left.height_px; ++y) {
    for (int x = 0; x < left.width_px; ++x) {
      view.occlusion(x, y) = 255;
      const auto ray = left.lens.Unproject(
          {(x + 0.5 - left.k.cx_px) / left.k.fx_px, (y + 0.5 - left.k.cy_px) / left.k.fy_px},
          left.lens.Reach());
      if (!ray) continue;
      Vec3d there = left.rectified_from_raw * *ray;
      there = Vec3d(there.x() / there.z() - disparity_px / rig.fx_px(), there.y() / there.z(), 1);
      const auto seen =
          right.lens.Project(right.rectified_from_raw.transpose() * there, right.lens.Reach());
      if (!seen) continue;
      float* flow = view.flow.At(x, y);
      flow[0] = static_cast<float>(right.k.cx_px + right.k.fx_px * seen->x() - (x + 0.5));
      flow[1] = static_cast<float>(right.k.cy_px + right.k.fy_px * seen->y() - (y + 0.5));
      flow[2] = 1;
      view.occlusion(x, y) = 0;
    }
  }
  return view;
}

TEST(RowFigures, AnEyeThatIsPitchedSeesPointsInOtherRowsUntilItIsRectified) {
  const v1::Rig rig = RawRig(0.01, -0.1), small = SmallRig(rig, 160, 120);
  const RowFigures figures = RowsOf(rig, small, WallAt(small, 5));
  // Near the middle 500 px x 0.01 rad; more at the edges, less where the lens shrinks them.
  EXPECT_NEAR(figures.raw_mean_px, 5, 0.5);
  EXPECT_GT(figures.raw_max_px, 5);
  EXPECT_LT(figures.rectified_max_px, 0.01);
  // The same at the rig's own size.
  const RowFigures whole = RowsOf(rig, rig, WallAt(rig, 20));
  EXPECT_NEAR(figures.raw_mean_px, whole.raw_mean_px, 0.05);
}

TEST(RowFigures, CamerasThatAreNotWhereTheyAreSaidToBeShow) {
  const v1::Rig rig = RawRig(0.01, 0);
  v1::Rig said = rig;
  *said.mutable_raw_right() = RawOf(rig, 0.012, 0);
  EXPECT_NEAR(RowsOf(said, said, WallAt(rig, 20)).rectified_max_px, 500 * 0.002, 0.5);
}

TEST(RowInRaw, IsStraightForAPinholeAndBentByALens) {
  const v1::Rig pinhole = RawRig(0, 0), lens = RawRig(0, -0.1);
  const std::vector<Vec2d> straight = RowInRaw(pinhole, 0, 100);
  ASSERT_GT(straight.size(), 640u);
  EXPECT_LT((straight.front() - Vec2d(0, 100)).norm(), 1e-9);
  EXPECT_LT((straight.back() - Vec2d(640, 100)).norm(), 1e-9);
  const std::vector<Vec2d> bent = RowInRaw(lens, 1, 100);
  EXPECT_GT(bent.front().y(), 101) << "barrel distortion pulls corners to the middle";
  EXPECT_NEAR(bent.front().y(), bent.back().y(), 1e-6);
  EXPECT_LT(bent[bent.size() / 2].y(), bent.front().y());
}

}  // namespace
}  // namespace parallax
