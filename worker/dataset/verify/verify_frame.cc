#include "worker/dataset/verify/verify_frame.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "common/math/types.h"
#include "worker/dataset/verify/checked_frame.h"
#include "worker/dataset/verify/verify_filters.h"
#include "worker/dataset/verify/verify_infrared.h"
#include "worker/dataset/verify/verify_layers.h"
#include "worker/dataset/verify/verify_occlusion.h"
#include "worker/dataset/verify/verify_raw.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDisparityTolerance = 1e-6;  // Relative, and half a float's last digit.
constexpr uint8_t kSky = 1, kKnownBits = 1 | 2 | 4 | 8 | 16 | 32;

void CheckPoses(const CheckedFrame& frame) {
  for (const CheckedEye& eye : frame.eyes) {
    const Eigen::Matrix4d& pose = eye.world_from_eye;
    const Eigen::Matrix3d r = pose.topLeftCorner<3, 3>();
    const double off = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    const double row = (pose.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff();
    if (!pose.allFinite() || off > 1e-6 || row > 1e-12 || r.determinant() < 0) {
      frame.Find("pose", "frame.json",
                 "world_from_" + eye.name + " is not a rotation and a translation");
      return;
    }
  }
  const Eigen::Matrix4d &left = frame.eyes[0].world_from_eye, &right = frame.eyes[1].world_from_eye;
  const double turned =
      (left.topLeftCorner<3, 3>() - right.topLeftCorner<3, 3>()).cwiseAbs().maxCoeff();
  if (turned > 1e-9) {
    frame.Find("pose", "frame.json", "the two cameras are turned against each other");
  }
  const Vec3d expected =
      left.topRightCorner<3, 1>() + frame.baseline_m * left.topLeftCorner<3, 1>();
  const double off = (expected - Vec3d(right.topRightCorner<3, 1>())).norm();
  if (off > 1e-6) {
    frame.Find(
        "pose", "frame.json",
        fmt::format(
            "the right camera is {:.9g} m from where the baseline ({:.9g} m along +x) puts it", off,
            frame.baseline_m));
  }
}

void CheckFinite(const CheckedFrame& frame, const ImageF& map, const std::string& file) {
  if (map.empty()) return;
  const auto value = [&](size_t i) { return double{map.values()[i]}; };
  frame.Pixels(
      "finite", file, [&](size_t i) { return !std::isfinite(value(i)) || value(i) < 0; },
      [&](size_t i) { return fmt::format("{:.9g}, wanted a number >= 0", value(i)); });
}

void CheckDepth(const CheckedFrame& frame, const CheckedEye& eye) {
  const std::string disparity_file = "disparity_" + eye.name + ".exr";
  CheckFinite(frame, eye.depth, "depth_" + eye.name + ".exr");
  CheckFinite(frame, eye.disparity, disparity_file);
  if (eye.disparity.empty() || eye.depth.empty()) return;
  const auto seen = [&](size_t i) { return double{eye.disparity.values()[i]}; };
  const auto expected = [&](size_t i) {
    const double z = double{eye.depth.values()[i]};
    return z > 0 ? frame.k.fx * frame.baseline_m / z : 0.0;
  };
  frame.Pixels(
      "disparity", disparity_file,
      [&](size_t i) {
        return !(std::abs(seen(i) - expected(i)) <= kDisparityTolerance * expected(i));
      },
      [&](size_t i) {
        return fmt::format("{:.9g}, fx * baseline / depth is {:.9g}", seen(i), expected(i));
      });
}

void CheckTables(const CheckedFrame& frame, const CheckedEye& eye, const ImageU16& indices,
                 const std::string& table) {
  if (indices.empty()) return;
  const std::string file = table + "_" + eye.name + ".png";
  if (!frame.json.contains(table) || !frame.json[table].is_object()) {
    frame.Find("tables", "frame.json", "no table \"" + table + "\"");
    return;
  }
  std::vector<bool> known(1 << 16);
  known[0] = true;
  for (const auto& [key, entry] : frame.json[table].items()) {
    const auto index = static_cast<uint32_t>(std::strtoul(key.c_str(), nullptr, 10));
    if (index < known.size()) known[index] = true;
    for (const char* field : {"class", "name", "seed"}) {
      if (!entry.is_object() || !entry.contains(field)) {
        frame.Find("tables", "frame.json", table + " " + key + " has no " + field);
        return;
      }
    }
    if (!SeedOf(entry["seed"])) {
      frame.Find("tables", "frame.json", table + " " + key + ": its seed is no number");
      return;
    }
  }
  frame.Pixels(
      "tables", file, [&](size_t i) { return !known[indices.values()[i]]; },
      [&](size_t i) { return fmt::format("index {} is not in the table", indices.values()[i]); });
  if (eye.depth.empty() || table != "objects") return;
  frame.Pixels(
      "tables", file,
      [&](size_t i) { return (indices.values()[i] != 0) != (eye.depth.values()[i] > 0); },
      [&](size_t i) {
        return fmt::format("object {} at depth {:.9g}", indices.values()[i],
                           double{eye.depth.values()[i]});
      });
}

void CheckMasks(const CheckedFrame& frame, const CheckedEye& eye) {
  if (eye.masks.empty()) return;
  const std::string file = "masks_" + eye.name + ".png";
  frame.Pixels(
      "masks", file, [&](size_t i) { return (eye.masks.values()[i] & ~kKnownBits) != 0; },
      [&](size_t i) { return fmt::format("unknown bits in {}", eye.masks.values()[i]); });
  if (eye.depth.empty()) return;
  frame.Pixels(
      "masks", file,
      [&](size_t i) {
        return ((eye.masks.values()[i] & kSky) != 0) != (eye.depth.values()[i] == 0);
      },
      [&](size_t i) {
        return fmt::format("{} at depth {:.9g}", (eye.masks.values()[i] & kSky) ? "sky" : "no sky",
                           double{eye.depth.values()[i]});
      });
}

void CheckNormals(const CheckedFrame& frame, const CheckedEye& eye) {
  if (eye.normals.empty()) return;
  const std::string file = "normals_" + eye.name + ".exr";
  const auto normal = [&](size_t i) {
    const float* n = &eye.normals.values()[3 * i];
    return Vec3d(double{n[0]}, double{n[1]}, double{n[2]});
  };
  const auto has_surface = [&](size_t i) {
    return eye.depth.empty() ? normal(i).norm() > 0 : eye.depth.values()[i] > 0;
  };
  // Half floats have eleven bits.
  frame.Pixels(
      "normals", file,
      [&](size_t i) {
        const double length = normal(i).norm();
        return has_surface(i) ? !(std::abs(length - 1) < 3e-3) : length != 0;
      },
      [&](size_t i) { return fmt::format("length {:.9g}", normal(i).norm()); });
  frame.Pixels(
      "normals", file,
      [&](size_t i) {
        const auto w = static_cast<size_t>(frame.k.width);
        const Vec3d ray((static_cast<double>(i % w) + 0.5 - frame.k.cx) / frame.k.fx,
                        (static_cast<double>(i / w) + 0.5 - frame.k.cy) / frame.k.fy, 1);
        return has_surface(i) && normal(i).dot(ray.normalized()) > 3e-3;
      },
      [&](size_t) { return std::string("turned away from the camera"); });
}

void Append(std::vector<Finding> found, std::vector<Finding>& findings) {
  for (Finding& finding : found) findings.push_back(std::move(finding));
}

void CheckFrame(const DatasetFrame& index, std::vector<Finding>& findings) {
  std::optional<CheckedFrame> frame = ReadNumbers(index, findings);
  if (!frame) return;
  CheckPoses(*frame);
  ReadMaps(*frame);
  for (const CheckedEye& eye : frame->eyes) {
    CheckDepth(*frame, eye);
    CheckTables(*frame, eye, eye.objects, "objects");
    CheckTables(*frame, eye, eye.materials, "materials");
    CheckMasks(*frame, eye);
    CheckNormals(*frame, eye);
  }
  CheckOcclusion(*frame);
  CheckLayers(*frame);
  CheckFilters(*frame);
  if (frame->json.contains("raw")) Append(CheckRawPair(index, frame->json), findings);
  if (frame->json.contains("infrared")) Append(CheckInfrared(index, frame->json), findings);
}

}  // namespace

void CheckGeometry(const DatasetFrame& frame, std::vector<Finding>& findings) {
  try {
    CheckFrame(frame, findings);
  } catch (const Json::exception& error) {
    findings.push_back({"index", frame.dir, error.what()});
  }
}

}  // namespace parallax
