// Reads calibrations of stereo cameras: files of the common formats, and a table of known cameras.
//
// Results are in the project's units and frames: metres; camera x right, y down, z forward; the
// right camera is at +x of the left one. Intrinsics are the file's numbers, unchanged: a file whose
// pixel centres are at integers (OpenCV, KITTI, Middlebury) means a principal point half a pixel
// further right and down than the same numbers mean here.
//
// All functions are pure but for reading the file, and thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/math/raw_camera.h"

namespace parallax {

// A projector of dots between the eyes.
struct ProjectorFacts {
  double power_w = 0;
  int dots = 0;
  double horizontal_fov_deg = 0, vertical_fov_deg = 0;
};

struct StereoCalibration {
  // "middlebury", "kitti", "opencv", "kalibr", "ros", "orb-slam3", "realsense", "oak", "zed",
  // "preset".
  std::string format;
  int width_px = 0, height_px = 0;  // Size that `rectified` is for; 0: the file does not say.
  Intrinsics rectified;             // K of both eyes.
  std::optional<double> baseline_m;
  // Left and right camera before rectification; absent if the file describes a rectified pair.
  std::optional<std::array<RawIntrinsics, 2>> raw;
  std::optional<ProjectorFacts> projector;  // Set by presets.
};

// Choices for files that leave them open.
struct CalibrationOptions {
  std::string part;              // ZED: "2K", "FHD", "HD", "VGA"...; KITTI: "00" or "02".
  std::optional<double> unit_m;  // Length of the file's unit in metres; absent: the format's.
};

// Parses the text of a calibration file. The format is recognised by the content:
//   Middlebury, ETH3D   calib.txt: cam0=[...], baseline (mm), width, height; cam1 and doffs are
//                       not used, because pairs have one K
//   KITTI               calib_cam_to_cam.txt (KITTI-360: perspective.txt, 00 and 01): P_rect_02,
//   P_rect_03, S_rect_02, and of the raw pair
//                       K, D, S, R_rect; or calib.txt with P2 and P3, which does not say the size
//   OpenCV              YAML or XML of cv::FileStorage: M1 D1 M2 D2 with R T, or P1 P2, and their
//                       usual other names; image_width, image_height or imageSize
//   Kalibr              camchain.yaml: cam0 and cam1 (pinhole), cam1.T_cn_cnm1
//   ROS                 ost.txt of a pair, or the YAML of both eyes (ReadCalibrationFile); of the
//                       right eye alone the rectified pair
//   ORB-SLAM3           YAML with Camera1, Camera2 and Stereo.T_c1_c2
//   RealSense           JSON with rs2_intrinsics (width, height, fx, fy, ppx, ppy, model, coeffs)
//                       of `left` and `right` or `infrared1` and `infrared2`, and rs2_extrinsics
//                       (rotation, column by column; translation) or a baseline; of several
//                       extrinsics those whose name has both streams, never those to another sensor
//                       Short names (left.fx, fy, cx, cy; baseline) do as well
//   OAK                 JSON of an EEPROM: cameraData of the sockets in stereoRectificationData,
//                       lengths in centimetres
//   ZED                 SN*.conf: [LEFT_CAM_HD], [RIGHT_CAM_HD], [STEREO]; without k1 there, as a
//                       ZED X has it, [LEFT_DISTO], [RIGHT_DISTO]
// `file` is only for messages.
// Errors: kInvalidArgument, "file:line: field: what was seen, what is allowed".
absl::StatusOr<StereoCalibration> ParseCalibration(std::string_view text, const std::string& file,
                                                   const CalibrationOptions& options = {});

// Reads the text of a calibration file for ParseCalibration. ROS writes a file for each eye: with
// "left" or "right" in its name, the text is that of both, if the other one lies beside it. Errors:
// those of ReadFile.
absl::StatusOr<std::string> ReadCalibrationFile(const std::string& path, size_t most_bytes);

// Returns the names of the known cameras, in the order of config.proto.
const std::vector<std::string>& CameraPresets();
// Returns the camera of that name, or nothing. Sources: see presets.cc.
std::optional<StereoCalibration> FindCameraPreset(std::string_view name);

}  // namespace parallax
