// Cameras before rectification: a lens with distortion, and a rotation relative to the rectified
// camera. Camera frame: x right, y down, z forward. Pixel centres are at integer coordinates + 0.5.
// Pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/math/types.h"

namespace parallax {

// A pinhole camera: focal lengths and principal point in pixels. x = 0 is the left edge of the
// image, y = 0 its top edge.
struct Intrinsics {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
};

// The lens distortion of one camera, in OpenCV's models.
// Source: OpenCV's calib3d, cv::projectPoints (rational model) and cv::fisheye::projectPoints.
struct LensDistortion {
  enum class Model { kNone, kBrownConrady, kKannalaBrandt };
  Model model = Model::kNone;
  // Brown-Conrady: k1 k2 p1 p2 k3 k4 k5 k6. Kannala-Brandt: k1 k2 k3 k4.
  std::array<double, 8> c{};

  // Returns the image point of the direction (x, y, z), relative to the principal point, in units
  // of the focal length. Returns nothing if the lens does not see the direction: it points
  // backwards, or lies beyond `reach`, which is the value of Reach().
  std::optional<Vec2d> Project(const Vec3d& direction, double reach) const;
  // Returns the unit direction that the lens maps to `point`; nothing for a point beyond the lens's
  // reach. The error of Project(Unproject(p)) is below 1e-12.
  std::optional<Vec3d> Unproject(const Vec2d& point, double reach) const;
  // Returns how far from the axis the lens model is one-to-one, as a tangent (Brown-Conrady) or an
  // angle in radians (Kannala-Brandt). Beyond it, one image point would belong to two directions.
  double Reach() const;

  bool operator==(const LensDistortion&) const = default;

 private:
  // Returns the radial factor of Brown-Conrady at the squared tangent r2.
  double Radial(double r2) const {
    return (1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]))) /
           (1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7])));
  }
  Vec2d Brown(const Vec2d& p) const {
    const double r2 = p.squaredNorm(), xy = 2 * p.x() * p.y(), radial = Radial(r2);
    return {p.x() * radial + c[2] * xy + c[3] * (r2 + 2 * p.x() * p.x()),
            p.y() * radial + c[2] * (r2 + 2 * p.y() * p.y()) + c[3] * xy};
  }
  double Fisheye(double angle) const {
    const double a2 = angle * angle;
    return angle * (1 + a2 * (c[0] + a2 * (c[1] + a2 * (c[2] + a2 * c[3]))));
  }
};

// One camera of a pair before rectification. Its centre of projection is that of the rectified
// camera.
struct RawIntrinsics {
  Intrinsics k;
  int width_px = 0, height_px = 0;
  LensDistortion lens;
  Eigen::Matrix3d rectified_from_raw = Eigen::Matrix3d::Identity();  // Rotation.
};

// The rotation of a raw camera relative to the rectified one, in radians: yaw to the right, pitch
// upwards, roll clockwise as seen from behind the camera. Applied in the order roll, pitch, yaw.
struct CameraTurn {
  double yaw_rad = 0, pitch_rad = 0, roll_rad = 0;
};

inline Eigen::Matrix3d RotationOfTurn(const CameraTurn& turn) {
  return (Eigen::AngleAxisd(turn.yaw_rad, Vec3d::UnitY()) *
          Eigen::AngleAxisd(turn.pitch_rad, Vec3d::UnitX()) *
          Eigen::AngleAxisd(turn.roll_rad, Vec3d::UnitZ()))
      .toRotationMatrix();
}

// Returns the turn of a rotation: RotationOfTurn(TurnOfRotation(r)) = r.
inline CameraTurn TurnOfRotation(const Eigen::Matrix3d& r) {
  return {std::atan2(r(0, 2), r(2, 2)), std::asin(std::clamp(-r(1, 2), -1.0, 1.0)),
          std::atan2(r(1, 0), r(1, 1))};
}

inline double LensDistortion::Reach() const {
  constexpr int kSteps = 4000;
  if (model == Model::kNone) return 1e3;
  // Brown-Conrady in tangents, up to 84 degrees from the axis; Kannala-Brandt in angles.
  const double most = model == Model::kBrownConrady ? 10.0 : std::numbers::pi;
  double before = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = most * i / kSteps;
    const double image = model == Model::kBrownConrady ? r * Radial(r * r) : Fisheye(r);
    if (!(image > before)) return most * (i - 1) / kSteps;
    before = image;
  }
  return most;
}

inline std::optional<Vec2d> LensDistortion::Project(const Vec3d& direction, double reach) const {
  if (model == Model::kKannalaBrandt) {
    const double side = direction.head<2>().norm(), angle = std::atan2(side, direction.z());
    if (angle > reach) return std::nullopt;
    if (side == 0) return Vec2d(0, 0);
    return Vec2d(Fisheye(angle) / side * direction.head<2>());
  }
  if (!(direction.z() > 0)) return std::nullopt;
  const Vec2d p = direction.head<2>() / direction.z();
  if (p.norm() > reach) return std::nullopt;
  return model == Model::kNone ? p : Brown(p);
}

inline std::optional<Vec3d> LensDistortion::Unproject(const Vec2d& point, double reach) const {
  constexpr int kMost = 60;
  constexpr double kExact = 1e-14;
  if (model == Model::kNone) return Vec3d(point.x(), point.y(), 1).normalized();
  if (model == Model::kKannalaBrandt) {
    const double radius = point.norm();
    if (radius == 0) return Vec3d(0, 0, 1);
    if (radius > Fisheye(reach)) return std::nullopt;
    // The image grows over [0, reach]: Newton's method within a bracket.
    double low = 0, high = reach, angle = std::min(radius, reach);
    for (int i = 0; i < kMost; ++i) {
      const double off = Fisheye(angle) - radius;
      (off > 0 ? high : low) = angle;
      const double a2 = angle * angle;
      const double slope = 1 + a2 * (3 * c[0] + a2 * (5 * c[1] + a2 * (7 * c[2] + a2 * 9 * c[3])));
      double next = slope > 0 ? angle - off / slope : high;
      if (!(next > low && next < high)) next = (low + high) / 2;
      if (std::abs(next - angle) <= kExact) break;
      angle = next;
    }
    const Vec2d side = std::sin(angle) / radius * point;
    return Vec3d(side.x(), side.y(), std::cos(angle));
  }
  // Newton's method in the plane from the undistorted radius, which leads to the inner branch.
  double low = 0, high = reach;
  const double radius = point.norm();
  for (int i = 0; i < kMost; ++i) {
    const double middle = (low + high) / 2;
    (middle * Radial(middle * middle) > radius ? high : low) = middle;
  }
  Vec2d p = radius > 0 ? Vec2d((low + high) / 2 / radius * point) : Vec2d(0, 0);
  for (int i = 0; i < kMost; ++i) {
    const Vec2d off = Brown(p) - point;
    if (off.squaredNorm() <= kExact * kExact) break;
    constexpr double kStep = 1e-6;
    Eigen::Matrix2d slope;
    slope.col(0) = (Brown(p + Vec2d(kStep, 0)) - Brown(p - Vec2d(kStep, 0))) / (2 * kStep);
    slope.col(1) = (Brown(p + Vec2d(0, kStep)) - Brown(p - Vec2d(0, kStep))) / (2 * kStep);
    const Vec2d step = slope.inverse() * off;
    p -= step;
    if (!p.allFinite()) return std::nullopt;
    if (step.norm() <= kExact) break;
  }
  if ((Brown(p) - point).norm() > 1e-12 || p.norm() > reach) return std::nullopt;
  return Vec3d(p.x(), p.y(), 1).normalized();
}

}  // namespace parallax
