// Files of robotics tools: Kalibr, ROS, ORB-SLAM3, and OAK cameras. Each is brought to the names of
// OpenCV's stereo files, whose reader does the rest.
#include <fmt/core.h>

#include <array>
#include <sstream>
#include <tuple>

#include "common/base/names.h"
#include "common/calibration/formats.h"

namespace parallax::calibration_internal {
namespace {

constexpr double kCentimetre_m = 1e-2;

// Maps the left camera's points to the right one's: X_right = rotation X_left + translation.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Pose Inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
  Pose After(const Pose& first) const {
    return {rotation * first.rotation, rotation * first.translation + translation};
  }
};

// One camera, in OpenCV's terms.
struct Eye {
  std::vector<double> k, d;
  std::string model;  // "" or "fisheye".
  int width = 0, height = 0;
};

std::string TextOf(const double* values, size_t count) {
  std::string text;
  for (size_t i = 0; i < count; ++i) text += fmt::format("{} ", values[i]);
  return text;
}
std::string TextOf(const std::vector<double>& values) {
  return TextOf(values.data(), values.size());
}

// Makes a calibration of two cameras and how they stand. Errors: those of FromOpenCv;
// kInvalidArgument, naming `name`, for cameras of two models or sizes.
Parsed FromEyes(const Fields& fields, const std::string& name, const char* format,
                const std::array<Eye, 2>& eyes, const Pose& pose) {
  if (eyes[0].model != eyes[1].model) {
    return fields.Error(name, "the cameras have two models of distortion, allowed is one");
  }
  if (eyes[0].width != eyes[1].width || eyes[0].height != eyes[1].height) {
    return fields.Error(name, "the cameras have two sizes of picture, allowed is one");
  }
  Fields stereo = fields.Empty();
  for (size_t i = 0; i < 2; ++i) {
    stereo.Add(i == 0 ? "K1" : "K2", TextOf(eyes[i].k), 0);
    if (!eyes[i].d.empty()) stereo.Add(i == 0 ? "D1" : "D2", TextOf(eyes[i].d), 0);
  }
  stereo.Add("distortion_model", eyes[0].model, 0);
  if (eyes[0].width > 0) {
    stereo.Add("imageSize", fmt::format("{} {}", eyes[0].width, eyes[0].height), 0);
  }
  const Eigen::Matrix3d rows = pose.rotation.transpose();  // Eigen's matrices lie by columns.
  stereo.Add("R", TextOf(rows.data(), 9), 0);
  stereo.Add("T", TextOf(pose.translation.data(), 3), 0);
  Parsed calibration = FromOpenCv(stereo, {.part = "", .unit_m = 1});
  if (calibration.ok()) calibration->format = format;
  return calibration;
}

std::vector<double> MatrixWith(double fx, double fy, double cx, double cy) {
  return {fx, 0, cx, 0, fy, cy, 0, 0, 1};
}

// The pose in sixteen numbers, row by row.
absl::StatusOr<Pose> PoseOf(const Fields& fields, const std::string& name) {
  ASSIGN_OR_RETURN(const std::vector<double> m, fields.Numbers(name, 16));
  Pose pose;
  for (int row = 0; row < 3; ++row) {
    const auto at = static_cast<size_t>(4 * row);
    for (int c = 0; c < 3; ++c) pose.rotation(row, c) = m[at + static_cast<size_t>(c)];
    pose.translation[row] = m[at + 3];
  }
  ASSIGN_OR_RETURN(pose.rotation, RotationOf(fields, name, pose.rotation));
  return pose;
}

absl::StatusOr<Eye> KalibrEye(const Fields& fields, const std::string& at) {
  Eye eye;
  if (const std::string model = fields.Text(at + "camera_model"); model != "pinhole") {
    return fields.Error(at + "camera_model", Quoted(model) + ", allowed is pinhole");
  }
  ASSIGN_OR_RETURN(const std::vector<double> k, fields.Numbers(at + "intrinsics", 4));
  eye.k = MatrixWith(k[0], k[1], k[2], k[3]);
  const std::string model = fields.Text(at + "distortion_model");
  if (model == "radtan" || model == "equidistant") {
    ASSIGN_OR_RETURN(eye.d, fields.Numbers(at + "distortion_coeffs", 4));
  } else if (model != "none") {
    return fields.Error(at + "distortion_model",
                        Quoted(model) + ", allowed are radtan, equidistant and none");
  }
  if (model == "equidistant") eye.model = "fisheye";
  ASSIGN_OR_RETURN(std::tie(eye.width, eye.height), fields.Size(at + "resolution"));
  return eye;
}

// The index of the entry of `cameraData` for a socket; -1 if none exists.
int OakEntry(const Fields& fields, const std::string& socket) {
  for (int i = 0; fields.Has(fmt::format("cameraData[{}][0]", i)); ++i) {
    if (fields.Text(fmt::format("cameraData[{}][0]", i)) == socket) return i;
  }
  return -1;
}

std::string OakName(int entry, std::string_view field) {
  return fmt::format("cameraData[{}][1].{}", entry, field);
}

absl::StatusOr<Eye> OakEye(const Fields& fields, int entry) {
  Eye eye;
  ASSIGN_OR_RETURN(eye.k, fields.Numbers(OakName(entry, "intrinsicMatrix"), 9));
  ASSIGN_OR_RETURN(eye.d, fields.Numbers(OakName(entry, "distortionCoeff"), 0));
  if (fields.Text(OakName(entry, "cameraType")) == "1") {
    eye.model = "fisheye";
    eye.d.resize(4);
  }
  ASSIGN_OR_RETURN(eye.width, fields.Pixels(OakName(entry, "width")));
  ASSIGN_OR_RETURN(eye.height, fields.Pixels(OakName(entry, "height")));
  return eye;
}

// The pose of an entry's camera towards the one that `toCameraSocket` names.
absl::StatusOr<Pose> OakPose(const Fields& fields, int entry) {
  const std::string name = OakName(entry, "extrinsics.rotationMatrix");
  ASSIGN_OR_RETURN(const std::vector<double> r, fields.Numbers(name, 9));
  Pose pose;
  ASSIGN_OR_RETURN(pose.rotation, RotationOf(fields, name, MatrixOf(r)));
  for (int i = 0; i < 3; ++i) {
    const std::string axis = fmt::format("extrinsics.translation.{}", "xyz"[i]);
    ASSIGN_OR_RETURN(pose.translation[i], fields.Number(OakName(entry, axis)));
  }
  return pose;
}

// From the left camera to the right one, directly or by a third camera that both name.
absl::StatusOr<Pose> OakPairPose(const Fields& fields, const std::array<int, 2>& entries,
                                 const std::array<std::string, 2>& sockets) {
  const auto target = [&](int entry) {
    return fields.Text(OakName(entry, "extrinsics.toCameraSocket"));
  };
  if (target(entries[0]) == sockets[1]) return OakPose(fields, entries[0]);
  ASSIGN_OR_RETURN(const Pose right, OakPose(fields, entries[1]));
  if (target(entries[1]) == sockets[0]) return right.Inverse();
  if (target(entries[0]) == target(entries[1])) {
    ASSIGN_OR_RETURN(const Pose left, OakPose(fields, entries[0]));
    return right.Inverse().After(left);
  }
  return fields.Error(OakName(entries[0], "extrinsics.toCameraSocket"),
                      "does not lead to the right camera");
}

// The lines after each heading of ost.txt, by "left.camera matrix" and its like.
Fields ReadOst(std::string_view text, const std::string& file) {
  Fields fields(file);
  std::istringstream lines{std::string(text)};
  std::string eye, heading, value;
  int number = 0, heading_line = 0;
  const auto finish = [&] {
    if (!heading.empty() && !value.empty()) fields.Add(eye + heading, value, heading_line);
    heading.clear();
    value.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line = line.substr(0, line.find_last_not_of(" \t\r") + 1);
    if (line.empty() || line[0] == '#') continue;
    if (std::string_view("+-.0123456789").find(line[0]) != std::string_view::npos) {
      value += line + " ";
      continue;
    }
    finish();
    heading = line;
    heading_line = number;
    if (line[0] != '[') continue;
    heading.clear();
    if (line == "[image]") eye = "";
    if (line.find("left") != std::string::npos) eye = "left.";
    if (line.find("right") != std::string::npos) eye = "right.";
  }
  finish();
  return fields;
}

// Names of the fields of ost.txt and of ROS's YAML, with the OpenCV names of both eyes.
struct RosName {
  const char *text, *yaml, *left, *right;
};
constexpr RosName kRosNames[] = {
    {"camera matrix", "camera_matrix", "K1", "K2"},
    {"distortion", "distortion_coefficients", "D1", "D2"},
    {"rectification", "rectification_matrix", "R1", "R2"},
    {"projection", "projection_matrix", "P1", "P2"},
};

}  // namespace

Parsed FromKalibr(const Fields& fields, const CalibrationOptions&) {
  std::array<Eye, 2> eyes;
  ASSIGN_OR_RETURN(eyes[0], KalibrEye(fields, "cam0."));
  ASSIGN_OR_RETURN(eyes[1], KalibrEye(fields, "cam1."));
  ASSIGN_OR_RETURN(const Pose pose, PoseOf(fields, "cam1.T_cn_cnm1"));
  if (pose.translation.x() >= 0) {
    return fields.Error("cam1.T_cn_cnm1",
                        "cam1 does not stand to the right of cam0: exchange their names");
  }
  return FromEyes(fields, "cam1", "kalibr", eyes, pose);
}

Parsed FromOak(const Fields& fields, const CalibrationOptions& options) {
  const std::array<std::string, 2> names = {"stereoRectificationData.leftCameraSocket",
                                            "stereoRectificationData.rightCameraSocket"};
  std::array<std::string, 2> sockets;
  std::array<int, 2> entries;
  std::array<Eye, 2> eyes;
  for (size_t i = 0; i < 2; ++i) {
    sockets[i] = fields.Has(names[i]) ? fields.Text(names[i]) : i == 0 ? "1" : "2";
    entries[i] = OakEntry(fields, sockets[i]);
    if (entries[i] < 0) {
      return fields.Error("cameraData", "has no camera at socket " + Quoted(sockets[i]));
    }
    ASSIGN_OR_RETURN(eyes[i], OakEye(fields, entries[i]));
  }
  ASSIGN_OR_RETURN(Pose pose, OakPairPose(fields, entries, sockets));
  // The sockets say which camera is the right one; devices differ in the sign of the translation.
  if (pose.translation.x() > 0) pose = pose.Inverse();
  pose.translation *= options.unit_m.value_or(kCentimetre_m);
  return FromEyes(fields, "cameraData", "oak", eyes, pose);
}

Parsed FromOrbSlam3(const Fields& fields, const CalibrationOptions&) {
  std::array<Eye, 2> eyes;
  for (size_t i = 0; i < 2; ++i) {
    const std::string at = i == 0 ? "Camera1." : "Camera2.";
    std::array<double, 4> k{};
    for (size_t j = 0; j < 4; ++j) {
      const char* const names[] = {"fx", "fy", "cx", "cy"};
      ASSIGN_OR_RETURN(k[j], fields.Number(at + names[j]));
    }
    eyes[i].k = MatrixWith(k[0], k[1], k[2], k[3]);
    const bool fisheye = fields.Text("Camera.type") == "KannalaBrandt8";
    if (fisheye) eyes[i].model = "fisheye";
    for (const char* name : {"k1", "k2", fisheye ? "k3" : "p1", fisheye ? "k4" : "p2"}) {
      ASSIGN_OR_RETURN(const double value, fields.NumberOr(at + name, 0));
      eyes[i].d.push_back(value);
    }
    for (const char* name : {"k3", "k4", "k5", "k6"}) {
      if (fisheye || !fields.Has(at + name)) continue;
      if (name[1] != '3') return fields.Error(at + name, "allowed with PinHole are k1 to k3");
      ASSIGN_OR_RETURN(const double k3, fields.Number(at + name));
      eyes[i].d.push_back(k3);
    }
    ASSIGN_OR_RETURN(eyes[i].width, fields.Pixels("Camera.width"));
    ASSIGN_OR_RETURN(eyes[i].height, fields.Pixels("Camera.height"));
  }
  ASSIGN_OR_RETURN(const Pose left_from_right, PoseOf(fields, "Stereo.T_c1_c2"));
  return FromEyes(fields, "Camera2", "orb-slam3", eyes, left_from_right.Inverse());
}

// Source: ROS, camera_calibration/calibrator.py and sensor_msgs/CameraInfo.
Parsed FromRos(std::string_view text, const std::string& file, const CalibrationOptions& options) {
  const bool yaml = text.find("projection_matrix") != text.npos;
  Fields stereo(file), found(file);
  if (!yaml) found = ReadOst(text, file);
  const size_t between = text.find(kNextEye);
  for (int eye = 0; eye < 2; ++eye) {
    if (yaml) {
      // Each eye's file is a document of its own; without the other eye the right one is enough.
      const size_t second = between == text.npos ? 0 : between + kNextEye.size();
      ASSIGN_OR_RETURN(found,
                       ReadYaml(eye == 0 ? text.substr(0, between) : text.substr(second), file));
    }
    const std::string side = yaml ? "" : eye == 0 ? "left." : "right.";
    for (const RosName& name : kRosNames) {
      const std::string from = side + (yaml ? name.yaml : name.text);
      ASSIGN_OR_RETURN(const std::vector<double> values, found.Numbers(from, 0));
      stereo.Add(eye == 0 ? name.left : name.right, TextOf(values), found.LineOf(from));
    }
    ASSIGN_OR_RETURN(const int width, found.Pixels(yaml ? "image_width" : "width"));
    ASSIGN_OR_RETURN(const int height, found.Pixels(yaml ? "image_height" : "height"));
    stereo.Add("imageSize", fmt::format("{} {}", width, height), 0);
    stereo.Add("distortion_model", found.Text("distortion_model"), 0);
  }
  Parsed calibration = FromOpenCv(stereo, options);
  if (!calibration.ok()) return calibration;
  calibration->format = "ros";
  if (yaml && between == text.npos) {
    calibration->raw.reset();  // It describes one eye only.
    if (calibration->baseline_m == 0.0) {
      return found.Error("projection_matrix",
                         "has no baseline: this is the left camera; name the right one's file, "
                         "called like this one with right for left");
    }
  }
  return calibration;
}

}  // namespace parallax::calibration_internal
