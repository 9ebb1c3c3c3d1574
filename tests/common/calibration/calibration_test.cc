#include "common/calibration/calibration.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "common/base/system/file.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kData = PARALLAX_CALIBRATION_DATA;

std::string TextOf(const std::string& name) { return *ReadFile(kData + "/" + name); }

StereoCalibration Parse(const std::string& name, const CalibrationOptions& options = {}) {
  auto calibration = ParseCalibration(TextOf(name), name, options);
  EXPECT_TRUE(calibration.ok()) << calibration.status();
  return calibration.ok() ? *calibration : StereoCalibration();
}

void ExpectIntrinsics(const Intrinsics& k, double fx, double fy, double cx, double cy) {
  EXPECT_EQ(k.fx_px, fx);
  EXPECT_EQ(k.fy_px, fy);
  EXPECT_EQ(k.cx_px, cx);
  EXPECT_EQ(k.cy_px, cy);
}

cv::Matx33d MatxOf(const Intrinsics& k) {
  return {k.fx_px, 0, k.cx_px, 0, k.fy_px, k.cy_px, 0, 0, 1};
}

Eigen::Matrix3d EigenOf(const cv::Mat& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.ptr<double>());
}

TEST(Calibration, MiddleburyHasTheLeftKAndItsBaselineInMillimetres) {
  const StereoCalibration calibration = Parse("middlebury_calib.txt");
  EXPECT_EQ(calibration.format, "middlebury");
  ExpectIntrinsics(calibration.rectified, 4161.221, 4161.221, 1445.577, 984.686);
  EXPECT_EQ(calibration.width_px, 2880);
  EXPECT_EQ(calibration.height_px, 1988);
  EXPECT_NEAR(*calibration.baseline_m, 0.176252, 1e-12);
  EXPECT_FALSE(calibration.raw);
}

TEST(Calibration, KittiHasTheColourPairItsBaselineAndTheRawCameras) {
  const StereoCalibration calibration = Parse("kitti_calib_cam_to_cam.txt");
  EXPECT_EQ(calibration.format, "kitti");
  ExpectIntrinsics(calibration.rectified, 721.5377, 721.5377, 609.5593, 172.854);
  EXPECT_EQ(calibration.width_px, 1242);
  EXPECT_EQ(calibration.height_px, 375);
  EXPECT_NEAR(*calibration.baseline_m, 0.5327254279, 1e-9);
  ASSERT_TRUE(calibration.raw);
  const RawIntrinsics& right = (*calibration.raw)[1];
  ExpectIntrinsics(right.k, 903.7596, 901.9653, 695.7519, 224.2509);
  EXPECT_EQ(right.width_px, 1392);
  EXPECT_EQ(right.height_px, 512);
  EXPECT_EQ(right.lens.model, LensDistortion::Model::kBrownConrady);
  EXPECT_EQ(right.lens.c[4], -5.38246e-02) << "k3";
  EXPECT_NEAR(right.rectified_from_raw(0, 2), 1.685599e-02, 1e-6);
  EXPECT_TRUE((right.rectified_from_raw.transpose() * right.rectified_from_raw).isIdentity(1e-14));
}

TEST(Calibration, KittiWithoutSizesLeavesThemOpen) {
  const std::string text =
      "P0: 718.856 0 607.1928 0 0 718.856 185.2157 0 0 0 1 0\n"
      "P1: 718.856 0 607.1928 -386.1448 0 718.856 185.2157 0 0 0 1 0\n"
      "P2: 718.856 0 607.1928 45.38225 0 718.856 185.2157 -0.1130887 0 0 1 0.003779761\n"
      "P3: 718.856 0 607.1928 -337.2877 0 718.856 185.2157 2.369057 0 0 1 0.004915215\n";
  const auto colour = ParseCalibration(text, "calib.txt");
  ASSERT_TRUE(colour.ok()) << colour.status();
  EXPECT_EQ(colour->width_px, 0);
  EXPECT_NEAR(*colour->baseline_m, (45.38225 + 337.2877) / 718.856, 1e-12);
  const auto grey = ParseCalibration(text, "calib.txt", {.part = "00", .unit_m = {}});
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_NEAR(*grey->baseline_m, 386.1448 / 718.856, 1e-12);
}

TEST(Calibration, ZedHasARawPairOfTheChosenResolution) {
  const StereoCalibration hd = Parse("zed.conf");
  EXPECT_EQ(hd.format, "zed");
  ExpectIntrinsics(hd.rectified, 701.88, 701.7, 641.285, 344.1835);
  EXPECT_EQ(hd.width_px, 1280);
  EXPECT_NEAR(*hd.baseline_m, 0.119978, 1e-7);
  ASSERT_TRUE(hd.raw);
  EXPECT_EQ((*hd.raw)[1].lens.c[0], -0.172795);
  // Together the cameras are turned against each other by the file's vector.
  const Eigen::Matrix3d between =
      (*hd.raw)[1].rectified_from_raw.transpose() * (*hd.raw)[0].rectified_from_raw;
  EXPECT_NEAR(Eigen::AngleAxisd(between).angle(),
              Vec3d(-0.000916611, 0.00623976, 0.000770041).norm(), 1e-9);
  const StereoCalibration large = Parse("zed.conf", {.part = "2K", .unit_m = {}});
  EXPECT_EQ(large.width_px, 2208);
  EXPECT_EQ(large.rectified.fx_px, 1403.76);
}

// Stereolabs' own programs give (Baseline, TY, TZ) to cv::stereoRectify as it stands.
TEST(Calibration, ZedIsRectifiedAsItsMakerRectifies) {
  std::string text = TextOf("zed.conf");
  text.replace(text.find("TY=0.0259812"), 12, "TY=1.2");
  text.replace(text.find("TZ=0.0158877"), 12, "TZ=-0.6");
  const auto ours = ParseCalibration(text, "zed.conf");
  ASSERT_TRUE(ours.ok()) << ours.status();
  ASSERT_TRUE(ours->raw);
  const cv::Mat vector = (cv::Mat_<double>(3, 1) << -0.000916611, 0.00623976, 0.000770041);
  const cv::Mat place = (cv::Mat_<double>(3, 1) << 119.978, 1.2, -0.6);
  const cv::Mat none = cv::Mat::zeros(1, 5, CV_64F);
  cv::Mat rotation, r1, r2, p1, p2, q;
  cv::Rodrigues(vector, rotation);
  cv::stereoRectify(MatxOf((*ours->raw)[0].k), none, MatxOf((*ours->raw)[1].k), none, {1280, 720},
                    rotation, place, r1, r2, p1, p2, q);
  EXPECT_LT((EigenOf(r1) - (*ours->raw)[0].rectified_from_raw).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((EigenOf(r2) - (*ours->raw)[1].rectified_from_raw).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(*ours->baseline_m, 1e-3 * cv::norm(place), 1e-12);
}

TEST(Calibration, ZedXHasItsLensesInSectionsOfTheirOwn) {
  const std::string cameras =
      "[LEFT_CAM_FHD1200]\nfx=738.5\nfy=738.25\ncx=961.5\ncy=603.5\n"
      "[RIGHT_CAM_FHD1200]\nfx=739.5\nfy=739.25\ncx=955.5\ncy=601.5\n"
      "[STEREO]\nBaseline=119.9\n";
  const std::string lens = "k1=0.5\nk2=-0.1\np1=0.001\np2=0.002\nk3=-0.03\nk4=0.8\nk5=-0.2\n";
  const CalibrationOptions options{.part = "FHD1200", .unit_m = {}};
  const auto calibration = ParseCalibration(
      cameras + "[LEFT_DISTO]\n" + lens + "k6=-0.05\n[RIGHT_DISTO]\n" + lens + "k6=-0.06\n",
      "zedx.conf", options);
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ASSERT_TRUE(calibration->raw);
  EXPECT_EQ((*calibration->raw)[0].lens.c[4], -0.03) << "k3";
  EXPECT_EQ((*calibration->raw)[0].lens.c[7], -0.05) << "k6";
  EXPECT_EQ((*calibration->raw)[1].lens.c[7], -0.06) << "k6";
  EXPECT_THAT(std::string(ToStd(ParseCalibration(cameras, "f", options).status().message())),
              HasSubstr("f: LEFT_CAM_FHD1200.k1: missing"));
}

TEST(Calibration, OpenCvIsRectifiedAsOpenCvRectifies) {
  const StereoCalibration ours = Parse("opencv.yml", {.part = "", .unit_m = 1e-3});
  EXPECT_EQ(ours.format, "opencv");
  EXPECT_EQ(ours.width_px, 640);
  EXPECT_EQ(ours.rectified.fx_px, 534.80490112304688);
  ASSERT_TRUE(ours.raw);
  EXPECT_EQ((*ours.raw)[0].lens.c[7], 0.012) << "k6 of eight";
  cv::FileStorage file(kData + "/opencv.yml", cv::FileStorage::READ);
  cv::Mat rotation, translation, r1, r2, p1, p2, q;
  file["R"] >> rotation;
  file["T"] >> translation;
  // Takes the nearest rotation first, because the file has six digits.
  const cv::SVD svd(rotation);
  rotation = svd.u * svd.vt;
  const cv::Mat none = cv::Mat::zeros(1, 5, CV_64F);
  cv::stereoRectify(MatxOf((*ours.raw)[0].k), none, MatxOf((*ours.raw)[1].k), none, {640, 480},
                    rotation, translation, r1, r2, p1, p2, q);
  EXPECT_LT((EigenOf(r1) - (*ours.raw)[0].rectified_from_raw).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((EigenOf(r2) - (*ours.raw)[1].rectified_from_raw).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(*ours.baseline_m, 1e-3 * cv::norm(translation), 1e-12);
}

// Writes what OpenCV's sample stereo_calib writes into its two files.
std::string StereoFileOf(const char* name) {
  const cv::Matx33d k(500, 0, 320, 0, 500, 240, 0, 0, 1);
  const cv::Mat lens = (cv::Mat_<double>(1, 5) << -0.2, 0.1, 0, 0, 0);
  const cv::Mat rotation = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat translation = (cv::Mat_<double>(3, 1) << -0.1, 0, 0);
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(k, lens, k, lens, {640, 480}, rotation, translation, r1, r2, p1, p2, q);
  cv::FileStorage file(name, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "M1" << cv::Mat(k) << "D1" << lens << "M2" << cv::Mat(k) << "D2" << lens;
  file << "R" << rotation << "T" << translation;
  file << "R1" << r1 << "R2" << r2 << "P1" << p1 << "P2" << p2 << "Q" << q;
  return file.releaseAndGetString();
}

TEST(Calibration, OpenCvWithProjectionsIsNoKitti) {
  for (const char* name : {"stereo.yml", "stereo.xml", "stereo.json"}) {
    SCOPED_TRACE(name);
    const auto calibration = ParseCalibration(StereoFileOf(name), name);
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    EXPECT_EQ(calibration->format, "opencv");
    EXPECT_NEAR(*calibration->baseline_m, 0.1, 1e-12);
    ASSERT_TRUE(calibration->raw);
    EXPECT_EQ((*calibration->raw)[1].lens.c[0], -0.2);
  }
  // Plain YAML, without cv::FileStorage's first line.
  const auto plain = ParseCalibration(
      "P1: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]\n"
      "P2: [500, 0, 320, -50, 0, 500, 240, 0, 0, 0, 1, 0]\n",
      "f");
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->format, "opencv");
  EXPECT_NEAR(*plain->baseline_m, 0.1, 1e-12);
}

// Without P1 and P2 the baseline is the length of T, whatever its name.
TEST(Calibration, OpenCvWithRectificationsHasTheBaselineOfItsTranslation) {
  const std::string eyes =
      "K1: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nK2: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "R1: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nR2: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  for (const std::string name : {"T", "Trns", "translation", "translation_vector"}) {
    const auto calibration = ParseCalibration(eyes + name + ": [-0.3, 0.4, 0]\n", "f");
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    ASSERT_TRUE(calibration->baseline_m) << name;
    EXPECT_NEAR(*calibration->baseline_m, 0.5, 1e-12) << name;
  }
}

TEST(Calibration, OpenCvXmlOfBoosterHasItsProjections) {
  const StereoCalibration calibration = Parse("opencv.xml");
  ExpectIntrinsics(calibration.rectified, 800.25, 801.5, 514.5, 376.25);
  EXPECT_EQ(calibration.width_px, 1028);
  EXPECT_EQ(calibration.height_px, 752);
  EXPECT_NEAR(*calibration.baseline_m, 0.08, 1e-12);
  EXPECT_FALSE(calibration.raw);
}

TEST(Calibration, RealSenseOfARectifiedPairHasNoRawCameras) {
  const StereoCalibration calibration = Parse("realsense.json");
  EXPECT_EQ(calibration.format, "realsense");
  ExpectIntrinsics(calibration.rectified, 641.5, 641.25, 640.4, 363.8);
  EXPECT_EQ(calibration.width_px, 1280);
  EXPECT_NEAR(*calibration.baseline_m, 0.0950137, 1e-12);
  EXPECT_FALSE(calibration.raw);
  // The other direction of the extrinsics, and one camera that is turned.
  std::string text = TextOf("realsense.json");
  text.replace(text.find("[1, 0, 0, 0, 1, 0, 0, 0, 1]"), 27, "[1,0,0, 0,0.8,0.6, 0,-0.6,0.8]");
  text.replace(text.find("-0.0950137"), 10, "0.0950137");
  const auto turned = ParseCalibration(text, "f");
  ASSERT_TRUE(turned.ok()) << turned.status();
  ASSERT_TRUE(turned->raw);
  EXPECT_NEAR(*turned->baseline_m, 0.0950137, 1e-12);
  EXPECT_NEAR(TurnOfRotation((*turned->raw)[0].rectified_from_raw).pitch_rad,
              -TurnOfRotation((*turned->raw)[1].rectified_from_raw).pitch_rad, 1e-12);
}

// A file with the extrinsics of several streams, in place of the two cameras' own.
std::string RealSenseWith(const std::string& extrinsics) {
  std::string text = TextOf("realsense.json");
  const size_t at = text.find("\"infrared1_to_infrared2\"");
  return text.substr(0, at) + extrinsics + "}";
}

TEST(Calibration, RealSenseTakesTheExtrinsicsBetweenItsTwoStreams) {
  const std::string turned =
      R"({"rotation": [0,1,0, -1,0,0, 0,0,1], "translation": [-0.015, 0, 0]})";
  const std::string plain =
      R"({"rotation": [1,0,0, 0,1,0, 0,0,1], "translation": [-0.0950137, 0, 0]})";
  const std::string back =
      R"({"rotation": [1,0,0, 0,1,0, 0,0,1], "translation": [0.0950137, 0, 0]})";
  for (const std::string& extrinsics : {
           R"("color_to_infrared1": )" + turned + R"(, "infrared1_to_infrared2": )" + plain +
               R"(, "infrared2_to_color": )" + turned,
           R"("infrared1_to_color": )" + turned + R"(, "infrared2_to_infrared1": )" + back,
           R"("extrinsics": {"Infrared 1": {"Infrared 2": )" + plain + R"(, "Color": )" + turned +
               "}}",
       }) {
    SCOPED_TRACE(extrinsics);
    const auto calibration = ParseCalibration(RealSenseWith(extrinsics), "f");
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    EXPECT_NEAR(*calibration->baseline_m, 0.0950137, 1e-12);
    EXPECT_FALSE(calibration->raw) << "not turned";
  }
  const auto others = ParseCalibration(
      RealSenseWith(R"("infrared1_to_color": )" + turned + R"(, "infrared1_to_gyro": )" + plain),
      "f");
  EXPECT_EQ(others.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ToStd(others.status().message())),
              HasSubstr("of several streams (\"infrared1_to_color\", \"infrared1_to_gyro\")"));
}

TEST(Calibration, RealSenseDoesNotTakeTheExtrinsicsOfAnotherSensor) {
  const std::string entry =
      R"("depth_to_color": {"rotation": [1,0,0, 0,1,0, 0,0,1], "translation": [0.015, 0, 0]})";
  const auto refused = ParseCalibration(RealSenseWith(entry), "f");
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ToStd(refused.status().message())),
              HasSubstr("of other streams (\"depth_to_color\")"));
  const auto told = ParseCalibration(RealSenseWith(entry + R"(, "baseline_mm": 50)"), "f");
  ASSERT_TRUE(told.ok()) << told.status();
  EXPECT_NEAR(*told->baseline_m, 0.05, 1e-12);
  const std::string own = R"({"translation": [-0.055, 0, 0]})";
  for (const char* name : {"extrinsics", "depth_to_infrared2"}) {
    const auto taken =
        ParseCalibration(RealSenseWith("\"" + std::string(name) + "\": " + own), "f");
    ASSERT_TRUE(taken.ok()) << taken.status();
    EXPECT_NEAR(*taken->baseline_m, 0.055, 1e-12) << name;
  }
}

TEST(Calibration, OpenCvsLooserYamlIsReadWithItsLines) {
  const std::string text = StereoFileOf("opencv.yml");
  const auto strict = ParseCalibration(text, "f");
  std::string loose = text;
  for (size_t at; (at = loose.find("data: [")) != std::string::npos;) loose.erase(at + 5, 1);
  ASSERT_NE(loose, text);
  const auto read = ParseCalibration(loose, "f");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->baseline_m, strict->baseline_m);
  EXPECT_EQ(read->rectified.fx_px, strict->rectified.fx_px);
}

TEST(Calibration, EveryPresetIsAPlausibleRectifiedCamera) {
  EXPECT_EQ(CameraPresets().size(), 8u);
  for (const std::string& name : CameraPresets()) {
    SCOPED_TRACE(name);
    const auto preset = FindCameraPreset(name);
    ASSERT_TRUE(preset);
    const double angle = 2 * std::atan(preset->width_px / 2.0 / preset->rectified.fx_px);
    EXPECT_GT(angle, 0.6);
    EXPECT_LT(angle, 1.8);
    EXPECT_NEAR(preset->rectified.cx_px, preset->width_px / 2.0, 0.18 * preset->width_px);
    EXPECT_NEAR(preset->rectified.cy_px, preset->height_px / 2.0, 0.1 * preset->height_px);
    EXPECT_GE(*preset->baseline_m, 0.05);
    EXPECT_LT(*preset->baseline_m, 0.6);
    EXPECT_FALSE(preset->raw);
  }
  EXPECT_FALSE(FindCameraPreset("zed"));
}

TEST(Calibration, EachBadFileNamesItsLineFieldAndWhatIsAllowed) {
  const struct {
    const char* file;
    const char* from;
    const char* to;
    const char* want;
  } rows[] = {
      {"middlebury_calib.txt", "cam0=[4161.221 0", "cam0=[fast 0",
       "f:1: cam0: \"fast\" is not a number, allowed is 9 numbers"},
      {"middlebury_calib.txt", "; 0 0 1]\ncam1", "]\ncam1",
       "f:1: cam0: 6 numbers, allowed is 9 numbers"},
      {"middlebury_calib.txt", "cam0=[4161.221 0", "cam0=[4161.221 2",
       "f:1: cam0: not of the form [fx 0 cx; 0 fy cy; 0 0 1]"},
      {"middlebury_calib.txt", "cam0=[4161.221", "cam0=[-1",
       "f:1: cam0: its focal lengths are not above 0"},
      {"middlebury_calib.txt", "baseline=176.252\n", "",
       "f: baseline: missing, allowed is a number"},
      {"middlebury_calib.txt", "width=2880", "width=28.5",
       "f:5: width: \"28.5\", allowed is a whole number from 1 to 16384"},
      {"middlebury_calib.txt", "baseline=176.252", "baseline=17625",
       "f: a baseline of 17.625000 m, allowed 0.001 to 2; camera.calibration_unit_m says"},
      {"kitti_calib_cam_to_cam.txt", "P_rect_03: 7.215377e+02",
       "P_rect_03: ", "f:18: P_rect_03: 11 numbers, allowed is 12 numbers"},
      {"kitti_calib_cam_to_cam.txt",
       "S_rect_02:", "S_wrong:", "f: S_rect_02: missing, allowed is 2 numbers"},
      {"kitti_calib_cam_to_cam.txt", "R_rect_02: 9.998817e-01", "R_rect_02: 0.5",
       "f:9: R_rect_02: not a rotation"},
      {"kitti_calib_cam_to_cam.txt", "S_02: 1.392000e+03", "S_02: 1e300",
       "f:3: S_02: \"1e300 5.120000e+02\", allowed are whole numbers from 1 to 16384"},
      {"kitti_calib_cam_to_cam.txt", "S_rect_02: 1.242000e+03", "S_rect_02: -3",
       "f:8: S_rect_02: \"-3 3.750000e+02\", allowed are whole numbers"},
      {"opencv.yml", "image_width: 640", "imageSize: [640, 4e9]",
       "f:3: imageSize: \"640 4e9\", allowed are whole numbers from 1 to 16384"},
      {"zed.conf", "[RIGHT_CAM_HD]", "[RIGHT_CAM_VGA]",
       "f: RIGHT_CAM_HD.fx: missing, allowed is a number"},
      {"zed.conf", "cy=344.1835", "cy=nan",
       "f:25: LEFT_CAM_HD.cy: \"nan\" is not a number, allowed is a number"},
      {"opencv.yml", "T: !!opencv-matrix", "U: !!opencv-matrix",
       "f: T: missing, allowed is 3 numbers"},
      {"opencv.yml", "-83.1, 1.0", "83.1, 1.0",
       "f:38: T: the second camera does not stand to the right of the first"},
      {"opencv.yml", "-2.6591e-01, -3.9e-02, 1.8e-03,", "1.8e-03,",
       "f:27: D2: 3 coefficients, allowed are 4, 5 or 8"},
      {"opencv.yml", "data: [ -83.1", "data: [ -83.1 {", "f:"},
      {"opencv.xml", "</proj_matL>", "</proj_mat>", "f:10: not XML: mismatched tag"},
      {"opencv.xml", "-64020.", "far", "f:11: proj_matR: \"far\" is not a number"},
      {"realsense.json",
       "\"ppx\": 640.4, \"ppy\": 363.8,\n\t\t\"model\": \"distortion.brown_conrady\", \"coeffs\": "
       "[0.0, 0.0, 0.0, 0.0, 0.0]},\n\t\"infrared2\"",
       "\"ppy\": 363.8},\n\t\"infrared2\"", "f: infrared1.ppx: missing, allowed is a number"},
      {"realsense.json", "\"model\": \"distortion.brown_conrady\", \"coeffs\": [0.0",
       "\"model\": \"distortion.inverse_brown_conrady\", \"coeffs\": [0.1",
       "f:4: infrared1.model: \"distortion.inverse_brown_conrady\" with coefficients"},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(std::string(row.file) + ": " + row.to);
    std::string text = TextOf(row.file);
    const size_t at = text.find(row.from);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, std::string(row.from).size(), row.to);
    const auto result = ParseCalibration(text, "f");
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(ToStd(result.status().message())), StartsWith(row.want));
  }
}

TEST(Calibration, AFileThatIsNoCalibrationIsToldWhatIsAllowed) {
  for (const std::string text :
       {"", "  \n", "hello", "{}", "a: 1\n", "<html></html>", "%YAML:1.0\n---\nx: [1, 2]\n"}) {
    const auto result = ParseCalibration(text, "f");
    ASSERT_FALSE(result.ok()) << text;
    EXPECT_THAT(std::string(ToStd(result.status().message())), HasSubstr("allowed")) << text;
  }
  EXPECT_FALSE(ParseCalibration(std::string("cam0=\0[", 7), "f").ok());
  // Aliases that stand for nine to the tenth numbers, in lists and in maps.
  std::string lists = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n", maps = "b0: &b0 {x: 1}\n";
  for (int i = 1; i <= 9; ++i) {
    const std::string number = std::to_string(i), before = std::to_string(i - 1);
    lists += "a" + number + ": &a" + number + " [";
    maps += "b" + number + ": &b" + number + " {";
    for (int k = 0; k < 9; ++k) {
      lists += fmt::format("*a{}, ", before);
      maps += fmt::format("k{}: *b{}, ", k, before);
    }
    lists += "1]\n";
    maps += "x: 1}\n";
  }
  for (const std::string& text : {lists, maps}) {
    EXPECT_THAT(std::string(ToStd(ParseCalibration(text, "f").status().message())),
                HasSubstr("f: with its aliases written out it has more than"));
  }
  // Entities that would grow without bound.
  const std::string bomb =
      "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY x \"xxxxxxxxxx\">"
      "<!ENTITY y \"&x;&x;&x;&x;\">]><opencv_storage><M1>&y;</M1></opencv_storage>";
  EXPECT_THAT(std::string(ToStd(ParseCalibration(bomb, "f").status().message())),
              HasSubstr("not XML"));
}

}  // namespace
}  // namespace parallax
