#include "common/calibration/calibration.h"

#include <fmt/core.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "common/calibration/formats.h"

namespace parallax {
namespace {

using namespace calibration_internal;  // NOLINT: the formats of this library.

constexpr char kFormats[] =
    "allowed are calib.txt of Middlebury or ETH3D, calib_cam_to_cam.txt or calib.txt of KITTI, "
    "perspective.txt of KITTI-360, a stereo file of OpenCV (YAML, XML), Kalibr's camchain, ROS's "
    "left.yaml and right.yaml or ost.txt, ORB-SLAM3's YAML, RealSense and OAK JSON, a ZED's .conf";

// Files that lack what a pair needs, by words in them.
struct KnownFile {
  const char* word;
  const char* looks_like;
};
constexpr KnownFile kKnownFiles[] = {
    {"T_BS",
     "looks like EuRoC's sensor.yaml of one camera: write both cameras into a stereo file of "
     "OpenCV (K1 D1 K2 D2 R T)"},
    {"# Camera list with one line of data per camera",
     "looks like COLMAP's cameras.txt, which has no baseline: write fx_px, fy_px, cx_px, cy_px and "
     "rigs.baseline_m into the study"},
    {"SIMPLE_RADIAL",
     "looks like COLMAP's cameras.txt, which has no baseline: write fx_px, fy_px, "
     "cx_px, cy_px and rigs.baseline_m into the study"},
    {"Camera.bf",
     "looks like ORB-SLAM's YAML of one rectified camera: write fx_px, fy_px, cx_px, "
     "cy_px and rigs.baseline_m (bf divided by fx) into the study"},
    {"cam0:", "looks like Kalibr's camchain of one camera: cam1 is missing"},
    {"camera_matrix",
     "looks like the calibration of one camera: the other one and how they stand "
     "(R, T) are missing"},
};

std::string WhatItLooksLike(std::string_view text) {
  for (const KnownFile& known : kKnownFiles) {
    if (text.find(known.word) != text.npos) return std::string("it ") + known.looks_like + "; ";
  }
  return "";
}

bool Has(std::string_view text, std::string_view word) { return text.find(word) != text.npos; }

// Whether a line begins with `name` and a number, as in "P0: 7.188560e+02 0".
bool HasNumbersOf(std::string_view text, std::string_view name) {
  for (size_t at = text.find(name); at != text.npos; at = text.find(name, at + 1)) {
    if (at > 0 && text[at - 1] != '\n') continue;
    const size_t value = text.find_first_not_of(" \t", at + name.size());
    if (value != text.npos && std::string_view("+-.0123456789").find(text[value]) != text.npos) {
      return true;
    }
  }
  return false;
}

// Whether the text is XML, JSON or YAML of cv::FileStorage, whose fields may be named like those
// of other formats. `text` begins without blanks.
bool IsDocument(std::string_view text) {
  return text[0] == '<' || text[0] == '{' || text.substr(0, 5) == "%YAML" ||
         Has(text, "opencv-matrix");
}

absl::StatusOr<StereoCalibration> Parse(std::string_view text, const std::string& file,
                                        const CalibrationOptions& options) {
  const size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first == text.npos) {
    return InvalidArgument("{}: empty, {}", file, kFormats);
  }
  const auto has = [&](std::string_view word) { return Has(text, word); };
  if (has("# oST version") ||
      (has("projection_matrix:") && has("rectification_matrix:") && has("camera_matrix:"))) {
    return FromRos(text, file, options);
  }
  if (!IsDocument(text.substr(first))) {
    if (has("[LEFT_CAM_") || has("[STEREO]")) return FromZed(ReadLines(text, file, '='), options);
    if (has("cam0=") || has("cam0 =")) return FromMiddlebury(ReadLines(text, file, '='), options);
    const std::string_view body = text.substr(first);
    if (has("P_rect_0") || HasNumbersOf(body, "P0:") || HasNumbersOf(body, "P2:")) {
      return FromKitti(ReadLines(text, file, ':'), options);
    }
  }
  if (text[first] == '<') {
    ASSIGN_OR_RETURN(const Fields fields, ReadXml(text, file));
    return FromOpenCv(fields, options);
  }
  ASSIGN_OR_RETURN(const Fields fields, ReadYaml(text, file));
  if (fields.Has("cam0.intrinsics") && fields.Has("cam1.intrinsics")) {
    return FromKalibr(fields, options);
  }
  if (has("cameraData")) return FromOak(fields, options);
  if (fields.Has("Stereo.T_c1_c2")) return FromOrbSlam3(fields, options);
  if (has("ppx") || has("\"fx\"") || fields.Has("left.fx")) return FromRealSense(fields, options);
  if (fields.Names().size() < 2) {
    return InvalidArgument("{}: not a calibration, {}{}", file, WhatItLooksLike(text), kFormats);
  }
  Parsed calibration = FromOpenCv(fields, options);
  if (const std::string why = WhatItLooksLike(text); !calibration.ok() && !why.empty()) {
    return InvalidArgument("{}; {}{}", calibration.status().message(), why, kFormats);
  }
  return calibration;
}

absl::Status Wrong(const std::string& file, const std::string& what) {
  return InvalidArgument("{}: {}", file, what);
}

// Bounds that hold for every format; those of config.proto.
absl::Status CheckBounds(const StereoCalibration& calibration, const std::string& file) {
  const auto size_fits = [](int width, int height) {
    return width >= 16 && height >= 16 && width <= 16384 && height <= 16384;
  };
  if ((calibration.width_px != 0 || calibration.height_px != 0) &&
      !size_fits(calibration.width_px, calibration.height_px)) {
    return Wrong(file, fmt::format("a picture of {} x {} px, allowed are sides of 16 to 16384",
                                   calibration.width_px, calibration.height_px));
  }
  if (calibration.baseline_m &&
      !(*calibration.baseline_m >= 1e-3 && *calibration.baseline_m <= 2)) {
    return Wrong(file,
                 fmt::format("a baseline of {:f} m, allowed 0.001 to 2; camera.calibration_unit_m "
                             "says in which unit the file is, such as 0.001 for millimetres",
                             *calibration.baseline_m));
  }
  if (!calibration.raw) return absl::OkStatus();
  for (const RawIntrinsics& raw : *calibration.raw) {
    if (raw.width_px != 0 && !size_fits(raw.width_px, raw.height_px)) {
      return Wrong(file,
                   fmt::format("a raw picture of {} x {} px, allowed are sides of 16 to 16384",
                               raw.width_px, raw.height_px));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<StereoCalibration> ParseCalibration(std::string_view text, const std::string& file,
                                                   const CalibrationOptions& options) {
  if (text.find('\0') != text.npos) return Wrong(file, "holds a NUL byte: not a text file");
  ASSIGN_OR_RETURN(StereoCalibration calibration, Parse(text, file, options));
  RETURN_IF_ERROR(CheckBounds(calibration, file));
  return calibration;
}

absl::StatusOr<std::string> ReadCalibrationFile(const std::string& path, size_t most_bytes) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path, most_bytes));
  const std::filesystem::path full(path);
  std::string name = full.filename();
  const size_t left = name.rfind("left"), right = name.rfind("right");
  const bool is_left = left != name.npos;
  if (!Has(text, "projection_matrix:") || is_left == (right != name.npos)) return text;
  name.replace(is_left ? left : right, is_left ? 4 : 5, is_left ? "right" : "left");
  const std::string beside = full.parent_path() / name;
  std::error_code error;
  if (!std::filesystem::is_regular_file(beside, error)) return text;
  ASSIGN_OR_RETURN(const std::string other, ReadFile(beside, most_bytes));
  return (is_left ? text : other) + std::string(kNextEye) + (is_left ? other : text);
}

}  // namespace parallax
