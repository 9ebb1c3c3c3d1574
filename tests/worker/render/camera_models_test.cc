// Presets, imported calibrations and raw pairs: epipolar geometry in closed form, and OpenCV as the
// other opinion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/system/file.h"
#include "common/calibration/calibration.h"
#include "tests/worker/render/test_scenes.h"
#include "worker/render/renderer.h"
#include "worker/render/truth/ground_truth.h"
#include "worker/render/truth/raw_pair.h"

namespace parallax {
namespace {

using test::DiffuseSample;
using test::MakeBoxRoom;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::TestScene;

void SetRaw(const RawIntrinsics& raw, double scale, v1::RawCamera* out) {
  out->set_fx_px(raw.k.fx_px * scale);
  out->set_fy_px(raw.k.fy_px * scale);
  out->set_cx_px(raw.k.cx_px * scale);
  out->set_cy_px(raw.k.cy_px * scale);
  out->set_width_px(static_cast<int>(raw.width_px * scale));
  out->set_height_px(static_cast<int>(raw.height_px * scale));
  using Model = LensDistortion::Model;
  out->set_lens(raw.lens.model == Model::kNone           ? v1::LensConfig::MODEL_NONE
                : raw.lens.model == Model::kBrownConrady ? v1::LensConfig::MODEL_BROWN_CONRADY
                                                         : v1::LensConfig::MODEL_KANNALA_BRANDT);
  for (const double c : raw.lens.c) out->add_distortion(c);
  const Eigen::Quaterniond q(raw.rectified_from_raw);
  out->set_qw(q.w());
  out->set_qx(q.x());
  out->set_qy(q.y());
  out->set_qz(q.z());
}

// Returns a rig in the box room that looks at its boxes, about 160 px wide.
v1::Rig RigOf(const StereoCalibration& calibration) {
  const double scale = 160.0 / calibration.width_px;
  v1::Rig rig =
      MakeRig({2, 0.3, 1.5}, {0.1, 1, -0.2}, 160, static_cast<int>(calibration.height_px * scale),
              100, *calibration.baseline_m);
  rig.set_fx_px(calibration.rectified.fx_px * scale);
  rig.set_fy_px(calibration.rectified.fy_px * scale);
  rig.set_cx_px(calibration.rectified.cx_px * scale);
  rig.set_cy_px(calibration.rectified.cy_px * scale);
  if (!calibration.raw) return rig;
  SetRaw((*calibration.raw)[0], scale, rig.mutable_raw_left());
  SetRaw((*calibration.raw)[1], scale, rig.mutable_raw_right());
  return rig;
}

StereoCalibration Imported(const std::string& name, const CalibrationOptions& options = {}) {
  const std::string path = std::string(PARALLAX_CALIBRATION_DATA) + "/" + name;
  auto calibration = ParseCalibration(*ReadFile(path), path, options);
  EXPECT_TRUE(calibration.ok()) << calibration.status();
  return *calibration;
}

// Returns OpenCV's position of the raw point in the rectified picture's plane, in tangents.
cv::Point2d Rectified(const v1::RawCamera& raw, const Vec2d& at) {
  const cv::Matx33d k(raw.fx_px(), 0, raw.cx_px(), 0, raw.fy_px(), raw.cy_px(), 0, 0, 1);
  const std::vector<double> d(
      raw.distortion().begin(),
      raw.distortion().begin() +
          std::min(raw.distortion_size(),
                   raw.lens() == v1::LensConfig::MODEL_KANNALA_BRANDT ? 4 : 8));
  const Eigen::Matrix3d r = FromProto(raw).rectified_from_raw;
  const cv::Matx33d turn(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                         r(2, 2));
  const cv::TermCriteria exact(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-14);
  const std::vector<cv::Point2d> in = {{at.x(), at.y()}};
  std::vector<cv::Point2d> out;
  if (raw.lens() == v1::LensConfig::MODEL_KANNALA_BRANDT) {
    cv::fisheye::undistortPoints(in, out, k, d, turn, cv::noArray());
  } else {
    cv::undistortPoints(in, out, k, d, turn, cv::noArray(), exact);
  }
  return out[0];
}

// A wall with large soft waves, lit without noise: smooth enough that a bilinear warp is exact.
TestScene SmoothScene() {
  class Waves : public PointMaterial {
   public:
    SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
      const auto& at = point.texture_m;
      return DiffuseSample({0.5f + 0.3f * std::sin(1.1f * at.x()),
                            0.5f + 0.3f * std::sin(0.9f * at.y()),
                            0.5f + 0.3f * std::sin(0.7f * (at.x() + at.y()))});
    }
  };
  TestScene scene;
  scene.AddMesh(MakeQuad({-40, 5, -40}, {80, 0, 0}, {0, 4, 80}),
                scene.AddMaterial(std::make_shared<Waves>()));
  scene.AddPointLight({0, -20, 3}, 0, 90000);
  return scene;
}

TEST(CameraModels, PresetsAndImportedCalibrationsAreRectifiedTo1e5) {
  std::vector<std::pair<std::string, StereoCalibration>> cameras;
  for (const std::string& name : CameraPresets())
    cameras.push_back({name, *FindCameraPreset(name)});
  cameras.push_back({"middlebury", Imported("middlebury_calib.txt")});
  cameras.push_back({"kitti", Imported("kitti_calib_cam_to_cam.txt")});
  cameras.push_back({"zed", Imported("zed.conf")});
  cameras.push_back({"opencv", Imported("opencv.yml", {.part = "", .unit_m = 1e-3})});
  cameras.push_back({"realsense", Imported("realsense.json")});
  const TestScene room = MakeBoxRoom();
  const auto scene = *RenderScene::Build(room.geometry, 0);
  for (const auto& [name, calibration] : cameras) {
    SCOPED_TRACE(name);
    const v1::Rig rig = RigOf(calibration);
    const auto stereo = StereoCamera::FromRig(rig);
    ASSERT_TRUE(stereo.ok()) << stereo.status();
    View view;
    ASSERT_TRUE(TraceGroundTruth(*scene, stereo->eyes[0], rig.baseline_m(), {}, &view).ok());
    const PinholeCamera &left = stereo->eyes[0], &right = stereo->eyes[1];
    int seen = 0;
    for (int y = 0; y < rig.height_px(); y += 3) {
      for (int x = 0; x < rig.width_px(); x += 3) {
        const double z = double{view.depth_m(x, y)};
        if (!(z > 0)) continue;
        const Vec3d point =
            left.origin + z * (left.world_from_camera * left.DirectionAt(x + 0.5, y + 0.5));
        const Vec3d at = right.world_from_camera.transpose() * (point - right.origin);
        const double u = at.x() / at.z() * rig.fx_px() + rig.cx_px();
        const double v = at.y() / at.z() * rig.fy_px() + rig.cy_px();
        ASSERT_NEAR(v, y + 0.5, 1e-5) << "epipolar residual";
        const double disparity = double{view.disparity_px(x, y)};
        ASSERT_NEAR(x + 0.5 - u, disparity, 1e-5 * disparity);
        ASSERT_NEAR(disparity * z, rig.fx_px() * rig.baseline_m(), 1e-5 * disparity * z);
        ++seen;
      }
    }
    EXPECT_GT(seen, 200);
  }
}

// Both ends of a raw correspondence, rectified by OpenCV, lie in one row, fx * b / z apart.
TEST(CameraModels, RawCorrespondencesAreEpipolarForOpenCv) {
  std::vector<std::pair<std::string, v1::Rig>> rigs = {
      {"kitti", RigOf(Imported("kitti_calib_cam_to_cam.txt"))},
      {"zed", RigOf(Imported("zed.conf"))},
      {"opencv", RigOf(Imported("opencv.yml", {.part = "", .unit_m = 1e-3}))}};
  v1::Rig fisheye = MakeRig({2, 0.3, 1.5}, {0.1, 1, -0.2}, 120, 120, 45, 0.1);
  RawIntrinsics raw{{38, 39, 61, 58},
                    120,
                    120,
                    {LensDistortion::Model::kKannalaBrandt, {-0.03, 0.012, -0.004, 0.0007}}};
  raw.rectified_from_raw = RotationOfTurn({0.02, -0.01, 0.03});
  SetRaw(raw, 1, fisheye.mutable_raw_left());
  raw.rectified_from_raw = RotationOfTurn({-0.015, 0.02, -0.02});
  SetRaw(raw, 1, fisheye.mutable_raw_right());
  rigs.push_back({"fisheye", fisheye});
  const TestScene room = MakeBoxRoom();
  const auto scene = *RenderScene::Build(room.geometry, 0);
  for (const auto& [name, rig] : rigs) {
    SCOPED_TRACE(name);
    const auto stereo = StereoCamera::RawFromRig(rig);
    ASSERT_TRUE(stereo.ok()) << stereo.status();
    RawView views[2];
    View truth;
    ASSERT_TRUE(TraceCorrespondence(*scene, *stereo, {}, &views[0], &views[1]).ok());
    ASSERT_TRUE(TraceGroundTruth(*scene, stereo->eyes[0], 1, {}, &truth).ok());
    int seen = 0, visible = 0;
    for (int y = 1; y < views[0].flow.height(); y += 4) {
      for (int x = 1; x < views[0].flow.width(); x += 4) {
        const double distance = double{truth.depth_m(x, y)};
        if (!(distance > 0) || views[0].flow(x, y, 2) == 0) continue;
        const Vec2d from(x + 0.5, y + 0.5);
        const Vec2d to = from + Vec2d(views[0].flow(x, y, 0), views[0].flow(x, y, 1));
        const Vec3d ray = stereo->eyes[0].DirectionAt(from.x(), from.y());
        const double z = distance * (FromProto(rig.raw_left()).rectified_from_raw * ray).z();
        if (z < 0.1) continue;  // Beside the rectified picture's half of the world.
        const cv::Point2d a = Rectified(rig.raw_left(), from), b = Rectified(rig.raw_right(), to);
        const double reach = 1 + std::hypot(a.x, a.y) + std::hypot(b.x, b.y);
        // Near the end of a polynomial the flow has fewer exact digits, and OpenCV's iterations end
        // early.
        if (reach > 3) continue;
        // Flow has a float's digits.
        ASSERT_NEAR(a.y, b.y, 1e-5 * reach) << x << ", " << y;
        ASSERT_NEAR(a.x - b.x, rig.baseline_m() / z, 1e-5 * reach) << x << ", " << y;
        ++seen;
        if (views[0].occlusion(x, y) != 0) continue;
        ++visible;
        // The other view's flow leads back, from one of the pixels around at edges.
        double nearest = 1e9;
        for (int k = 0; k < 4; ++k) {
          const int u =
              std::clamp(static_cast<int>(to.x() - 0.5) + k % 2, 0, views[1].flow.width() - 1);
          const int v =
              std::clamp(static_cast<int>(to.y() - 0.5) + k / 2, 0, views[1].flow.height() - 1);
          const Vec2d back = to + Vec2d(views[1].flow(u, v, 0), views[1].flow(u, v, 1));
          nearest = std::min(nearest, (back - from).norm());
        }
        EXPECT_LT(nearest, 3) << x << ", " << y;
      }
    }
    EXPECT_GT(seen, 100);
    EXPECT_GT(visible, seen / 3);
  }
}

TEST(CameraModels, RawPicturesUndistortedByOpenCvAreTheRectifiedOnes) {
  const TestScene scene = SmoothScene();
  v1::RenderConfig config = MakeConfig(64, 1, false);
  config.add_maps("raw");
  auto renderer = *Renderer::Create(scene.recipe, scene.geometry, config);
  v1::Rig brown = MakeRig({0, 0, 0}, {0.05, 1, 0.03}, 192, 128, 170, 0.12);
  RawIntrinsics raw{{168, 171, 97, 61},
                    192,
                    128,
                    {LensDistortion::Model::kBrownConrady, {-0.25, 0.06, 8e-4, -5e-4, 0.01}}};
  raw.rectified_from_raw = RotationOfTurn({0.01, -0.006, 0.012});
  SetRaw(raw, 1, brown.mutable_raw_left());
  raw.rectified_from_raw = RotationOfTurn({-0.012, 0.009, -0.02});
  SetRaw(raw, 1, brown.mutable_raw_right());
  v1::Rig fisheye = brown;
  raw.lens = {LensDistortion::Model::kKannalaBrandt, {-0.03, 0.012, -0.004, 0.0007}};
  fisheye.clear_raw_left();
  fisheye.clear_raw_right();
  SetRaw(raw, 1, fisheye.mutable_raw_left());
  SetRaw(raw, 1, fisheye.mutable_raw_right());
  for (const v1::Rig& rig : {brown, fisheye}) {
    const auto frame = renderer->RenderRig(rig, {}, {});
    ASSERT_TRUE(frame.ok()) << frame.status();
    for (int eye = 0; eye < 2; ++eye) {
      const RawView& seen = eye == 0 ? frame->raw_left : frame->raw_right;
      const View& wanted = eye == 0 ? frame->left : frame->right;
      const v1::RawCamera& camera = eye == 0 ? rig.raw_left() : rig.raw_right();
      // OpenCV's pixel centres are at integers.
      const cv::Matx33d k(camera.fx_px(), 0, camera.cx_px() - 0.5, 0, camera.fy_px(),
                          camera.cy_px() - 0.5, 0, 0, 1);
      const cv::Matx33d p(rig.fx_px(), 0, rig.cx_px() - 0.5, 0, rig.fy_px(), rig.cy_px() - 0.5, 0,
                          0, 1);
      const bool round = camera.lens() == v1::LensConfig::MODEL_KANNALA_BRANDT;
      const std::vector<double> d(camera.distortion().begin(),
                                  camera.distortion().begin() + (round ? 4 : 5));
      const Eigen::Matrix3d r = FromProto(camera).rectified_from_raw;
      const cv::Matx33d turn(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                             r(2, 2));
      cv::Mat x, y;
      const cv::Size size(rig.width_px(), rig.height_px());
      if (round) {
        cv::fisheye::initUndistortRectifyMap(k, d, turn, p, size, CV_32F, x, y);
      } else {
        cv::initUndistortRectifyMap(k, d, turn, p, size, CV_32F, x, y);
      }
      const cv::Mat picture(camera.height_px(), camera.width_px(), CV_8UC3,
                            const_cast<uint8_t*>(seen.color.data()));
      cv::Mat in_float, undistorted;
      picture.convertTo(in_float, CV_32FC3);
      cv::remap(in_float, undistorted, x, y, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                cv::Scalar(-1e6, -1e6, -1e6));
      double sum = 0;
      int count = 0;
      for (int row = 0; row < size.height; ++row) {
        for (int column = 0; column < size.width; ++column) {
          const auto& at = undistorted.at<cv::Vec3f>(row, column);
          if (at[0] < 0) continue;  // Outside of the raw picture.
          for (int c = 0; c < 3; ++c) {
            sum += std::abs(double{at[c]} - wanted.color(column, row, c));
            ++count;
          }
        }
      }
      EXPECT_GT(count, 3 * size.area() * 0.7);
      const double mean = sum / count;
      RecordProperty(std::string(round ? "fisheye" : "brown") + std::to_string(eye),
                     std::to_string(mean));
      EXPECT_LT(mean, 0.5) << "of 255";
    }
  }
}

TEST(CameraModels, CornersToWhichNoDirectionLeadsAreBlackAndHaveNoFlow) {
  const TestScene scene = SmoothScene();
  v1::RenderConfig config = MakeConfig(2, 1, false);
  config.add_maps("raw");
  auto renderer = *Renderer::Create(scene.recipe, scene.geometry, config);
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 64, 64, 50, 0.1);
  // r (1 - r^2 / 3) ends at 2/3; the sides lie at 0.64, the corners at 0.9.
  const RawIntrinsics raw{
      {50, 50, 32, 32}, 64, 64, {LensDistortion::Model::kBrownConrady, {-1.0 / 3}}};
  SetRaw(raw, 1, rig.mutable_raw_left());
  SetRaw(raw, 1, rig.mutable_raw_right());
  const auto frame = renderer->RenderRig(rig, {}, {});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->raw_left.color(1, 1), 0);
  EXPECT_EQ(frame->raw_left.flow(1, 1, 2), 0);
  EXPECT_EQ(frame->raw_left.occlusion(1, 1), 255);
  EXPECT_GT(frame->raw_left.color(1, 32), 20);
  EXPECT_EQ(frame->raw_left.flow(32, 32, 2), 1);
  // A lens that does not even show the sides is an error.
  rig.mutable_raw_left()->set_distortion(0, -0.4);
  EXPECT_EQ(renderer->RenderRig(rig, {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(CameraModels, WithoutTheMapRawNothingOfItIsRendered) {
  const TestScene scene = SmoothScene();
  v1::Rig rig = MakeRig({0, 0, 0}, {0.05, 1, 0.03}, 48, 32, 40, 0.12);
  const RawIntrinsics raw{{40, 40, 24, 16}, 48, 32, {}};
  SetRaw(raw, 1, rig.mutable_raw_left());
  SetRaw(raw, 1, rig.mutable_raw_right());
  auto plain = *Renderer::Create(scene.recipe, scene.geometry, MakeConfig(2, 1, false));
  v1::RenderConfig config = MakeConfig(2, 1, false);
  config.add_maps("raw");
  auto with_raw = *Renderer::Create(scene.recipe, scene.geometry, config);
  const auto a = plain->RenderRig(rig, {}, {}), b = with_raw->RenderRig(rig, {}, {});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(a->raw_left.color.empty());
  EXPECT_FALSE(b->raw_left.color.empty());
  EXPECT_EQ(a->left.color, b->left.color) << "the rectified pair is the same";
  EXPECT_EQ(a->right.disparity_px, b->right.disparity_px);
}

TEST(CameraModels, ProgressCountsRawPicturesOfAnotherSize) {
  const TestScene scene = SmoothScene();
  v1::RenderConfig config = MakeConfig(1, 1, false);
  config.add_maps("raw");
  auto renderer = *Renderer::Create(scene.recipe, scene.geometry, config);
  for (const double scale : {0.5, 2.0}) {
    v1::Rig rig = MakeRig({0, 0, 0}, {0.05, 1, 0.03}, 64, 32, 40, 0.12);
    const RawIntrinsics raw{{40, 40, 32, 16}, 64, 32, {}};
    SetRaw(raw, scale, rig.mutable_raw_left());
    SetRaw(raw, scale, rig.mutable_raw_right());
    std::mutex mutex;
    double highest = 0;  // While the pictures are traced.
    const auto frame = renderer->RenderRig(rig, {}, [&](double fraction) {
      const std::lock_guard<std::mutex> lock(mutex);
      EXPECT_LE(fraction, 1.0) << scale;
      if (fraction < 1) highest = std::max(highest, fraction);
    });
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_NEAR(highest, 0.95, 1e-6) << scale;
  }
}

}  // namespace
}  // namespace parallax
