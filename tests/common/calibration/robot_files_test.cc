// Files of robotics tools and other ones that are brought to OpenCV's names.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "common/calibration/calibration.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

void ExpectRobotIntrinsics(const Intrinsics& k, double fx, double fy, double cx, double cy) {
  EXPECT_EQ(k.fx_px, fx);
  EXPECT_EQ(k.fy_px, fy);
  EXPECT_EQ(k.cx_px, cx);
  EXPECT_EQ(k.cy_px, cy);
}

constexpr char kCamchain[] = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.0012, 0.0004, -3.2e-05, 0.0004]
  distortion_model: radtan
  intrinsics: [385.2, 385.1, 320.1, 240.2]
  resolution: [640, 480]
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.0501]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.002, 0.0001, 2.1e-05, 0.0003]
  distortion_model: radtan
  intrinsics: [386.0, 385.9, 319.4, 239.8]
  resolution: [640, 480]
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string ErrorOf(const std::string& text) {
  return std::string(ToStd(ParseCalibration(text, "f").status().message()));
}

TEST(RobotFiles, KalibrsCamchainIsARawPair) {
  const auto calibration = ParseCalibration(kCamchain, "camchain.yaml");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->format, "kalibr");
  EXPECT_EQ(calibration->width_px, 640);
  EXPECT_NEAR(*calibration->baseline_m, 0.0501, 1e-9);
  ASSERT_TRUE(calibration->raw);
  ExpectRobotIntrinsics((*calibration->raw)[1].k, 386.0, 385.9, 319.4, 239.8);
  EXPECT_EQ((*calibration->raw)[0].lens.model, LensDistortion::Model::kBrownConrady);
  EXPECT_EQ((*calibration->raw)[1].lens.c[0], 0.002);
  std::string fisheye = Replaced(kCamchain, "model: radtan", "model: equidistant");
  EXPECT_THAT(ErrorOf(fisheye), HasSubstr("two models of distortion"));
  fisheye = Replaced(fisheye, "model: radtan", "model: equidistant");
  EXPECT_EQ((*ParseCalibration(fisheye, "f")->raw)[0].lens.model,
            LensDistortion::Model::kKannalaBrandt);
  EXPECT_THAT(ErrorOf(Replaced(kCamchain, "-0.0501", "0.0501")),
              HasSubstr("cam1.T_cn_cnm1: cam1 does not stand to the right of cam0"));
  EXPECT_THAT(ErrorOf(Replaced(kCamchain, "pinhole", "omni")),
              HasSubstr("f:3: cam0.camera_model: \"omni\", allowed is pinhole"));
  EXPECT_THAT(ErrorOf(std::string(kCamchain).substr(0, std::string(kCamchain).find("cam1:"))),
              HasSubstr("Kalibr's camchain of one camera"));
}

std::string RosEye(const char* name, const char* tx) {
  return std::string("image_width: 640\nimage_height: 480\ncamera_name: ") + name +
         "\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [430.1, 0, 310.5, 0, 430.4, 237.8, 0, 0, "
         "1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: "
         "[-0.36, 0.16, 0.001, 0.0002, 0]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: "
         "[1, "
         "0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [400.5, 0, "
         "320.2, " +
         tx + ", 0, 400.5, 238.1, 0, 0, 0, 1, 0]\n";
}

TEST(RobotFiles, TheTwoFilesOfRosAreOnePair) {
  const std::string dir = ::testing::TempDir() + "ros_pair/";
  std::filesystem::create_directories(dir);
  ASSERT_TRUE(WriteFile(dir + "left.yaml", RosEye("narrow_stereo/left", "0.0")).ok());
  ASSERT_TRUE(WriteFile(dir + "right.yaml", RosEye("narrow_stereo/right", "-24.03")).ok());
  for (const char* name : {"left.yaml", "right.yaml"}) {
    const auto text = ReadCalibrationFile(dir + name, 1 << 20);
    ASSERT_TRUE(text.ok()) << text.status();
    const auto calibration = ParseCalibration(*text, name);
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    EXPECT_EQ(calibration->format, "ros");
    ExpectRobotIntrinsics(calibration->rectified, 400.5, 400.5, 320.2, 238.1);
    EXPECT_NEAR(*calibration->baseline_m, 24.03 / 400.5, 1e-9);
    ASSERT_TRUE(calibration->raw);
    ExpectRobotIntrinsics((*calibration->raw)[1].k, 430.1, 430.4, 310.5, 237.8);
  }
  std::filesystem::remove(dir + "left.yaml");
  const auto right =
      ParseCalibration(*ReadCalibrationFile(dir + "right.yaml", 1 << 20), "right.yaml");
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_NEAR(*right->baseline_m, 24.03 / 400.5, 1e-9);
  EXPECT_FALSE(right->raw);
  EXPECT_THAT(ErrorOf(RosEye("left", "0.0")), HasSubstr("this is the left camera"));
  std::filesystem::remove_all(dir);
}

TEST(RobotFiles, OstTxtOfRosHasBothEyes) {
  std::string text;
  for (const std::string eye : {"left", "right"}) {
    text +=
        "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n"
        "[narrow_stereo/" +
        eye +
        "]\n\ncamera matrix\n430.1 0 310.5\n0 430.4 237.8\n0 0 1\n\n"
        "distortion\n-0.36 0.16 0.001 0.0002 0.0\n\nrectification\n1 0 0\n0 1 0\n0 0 1\n\n"
        "projection\n400.5 0 320.2 " +
        (eye == "left" ? "0" : "-24.03") + "\n0 400.5 238.1 0\n0 0 1 0\n\n";
  }
  const auto calibration = ParseCalibration(text, "ost.txt");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->format, "ros");
  EXPECT_EQ(calibration->height_px, 480);
  EXPECT_NEAR(*calibration->baseline_m, 24.03 / 400.5, 1e-9);
  EXPECT_THAT(ErrorOf(Replaced(text, "projection", "something")),
              HasSubstr("left.projection: missing"));
}

std::string OakCamera(int socket, int to, const std::string& x) {
  return fmt::format(
      R"([{}, {{"cameraType": 0, "distortionCoeff": [0.1, -0.2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
      "extrinsics": {{"rotationMatrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "toCameraSocket": {},
      "translation": {{"x": {}, "y": 0, "z": 0}}}}, "height": 800, "width": 1280,
      "intrinsicMatrix": [[787.0, 0, 643.5], [0, 787.1, 400.2], [0, 0, 1]]}}])",
      socket, to, x);
}

TEST(RobotFiles, OaksSocketsSayWhichCameraIsTheLeftOne) {
  const std::string sockets =
      R"("stereoRectificationData": {"leftCameraSocket": 1, "rightCameraSocket": 2})";
  const auto json = [&](const std::string& cameras) {
    return R"({"boardName": "OAK-D", "cameraData": [)" + cameras + "], " + sockets + "}";
  };
  for (const std::string& cameras :
       {OakCamera(1, 2, "-7.5") + "," + OakCamera(2, -1, "0"),
        OakCamera(1, 2, "7.5") + "," + OakCamera(2, -1, "0"),
        OakCamera(2, 1, "7.5") + "," + OakCamera(1, -1, "0"),
        OakCamera(0, -1, "0") + "," + OakCamera(1, 0, "-3.75") + "," + OakCamera(2, 0, "3.75")}) {
    const auto calibration = ParseCalibration(json(cameras), "oak.json");
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    EXPECT_EQ(calibration->format, "oak");
    EXPECT_EQ(calibration->width_px, 1280);
    EXPECT_NEAR(*calibration->baseline_m, 0.075, 1e-9);
    ASSERT_TRUE(calibration->raw);
    EXPECT_EQ((*calibration->raw)[0].lens.c[1], -0.2);
  }
  EXPECT_THAT(ErrorOf(json(OakCamera(1, 2, "-7.5"))), HasSubstr("no camera at socket \"2\""));
}

TEST(RobotFiles, OrbSlam3HasItsPoseFromTheRightCamera) {
  const auto calibration = ParseCalibration(
      "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 458.6\nCamera1.fy: 457.2\nCamera1.cx: "
      "367.2\nCamera1.cy: 248.3\nCamera1.k1: -0.28\nCamera2.fx: 457.5\nCamera2.fy: "
      "456.1\nCamera2.cx: 379.9\nCamera2.cy: 255.2\nCamera.width: 752\nCamera.height: "
      "480\nStereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n  data:[1, 0, 0, "
      "0.11, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n",
      "EuRoC.yaml");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->format, "orb-slam3");
  EXPECT_NEAR(*calibration->baseline_m, 0.11, 1e-9);
}

TEST(RobotFiles, OrbSlam3sPinHoleHasAThirdCoefficient) {
  const std::string text =
      "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 458.6\nCamera1.fy: 457.2\nCamera1.cx: "
      "367.2\nCamera1.cy: 248.3\nCamera1.k1: -0.28\nCamera1.k3: 0.05\nCamera2.fx: "
      "457.5\nCamera2.fy: 456.1\nCamera2.cx: 379.9\nCamera2.cy: 255.2\nCamera2.k1: "
      "-0.27\nCamera.width: 752\nCamera.height: 480\nStereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n"
      "  cols: 4\n  dt: f\n  data: [1, 0, 0, 0.11, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
  const auto calibration = ParseCalibration(text, "f");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ASSERT_TRUE(calibration->raw);
  EXPECT_EQ((*calibration->raw)[0].lens.c[4], 0.05);
  EXPECT_EQ((*calibration->raw)[1].lens.c[4], 0);
  EXPECT_THAT(ErrorOf(Replaced(text, "Camera1.k3", "Camera1.k4")), HasSubstr("f:8: Camera1.k4: "));
}

TEST(RobotFiles, Kitti360HasItsGreyPairWithoutAPart) {
  const auto calibration = ParseCalibration(
      "calib_time: 0\nS_rect_00: 1408 376\nP_rect_00: 552.5 0 682.0 0 0 552.5 238.7 0 0 0 1 0\n"
      "S_rect_01: 1408 376\nP_rect_01: 552.5 0 682.0 -328.3 0 552.5 238.7 0 0 0 1 0\n",
      "perspective.txt");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->width_px, 1408);
  EXPECT_NEAR(*calibration->baseline_m, 328.3 / 552.5, 1e-9);
}

TEST(RobotFiles, ShortNamesOfIntrinsicsDo) {
  const auto calibration = ParseCalibration(
      R"({"left": {"fx": 600, "fy": 601, "cx": 320, "cy": 240, "width": 640, "height": 480},
          "right": {"fx": 600, "fy": 601, "cx": 320, "cy": 240, "width": 640, "height": 480},
          "baseline_m": 0.12})",
      "f");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ExpectRobotIntrinsics(calibration->rectified, 600, 601, 320, 240);
  EXPECT_NEAR(*calibration->baseline_m, 0.12, 1e-12);
}

TEST(RobotFiles, OtherFilesAreToldByWhatTheyLookLike) {
  EXPECT_THAT(ErrorOf("sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1]\n"),
              HasSubstr("EuRoC's sensor.yaml"));
  EXPECT_THAT(
      ErrorOf("# Camera list with one line of data per camera:\n1 PINHOLE 640 480 1 1 1 1\n"),
      HasSubstr("COLMAP's cameras.txt"));
  EXPECT_THAT(ErrorOf("%YAML:1.0\nCamera.fx: 435.2\nCamera.bf: 47.9\n"),
              HasSubstr("ORB-SLAM's YAML of one rectified camera"));
}

}  // namespace
}  // namespace parallax
