// Points, vectors, boxes and transforms. Lengths are metres. Geometry is float; poses and recipes
// are double. World frame: z up, right-handed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace parallax {

using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Vec2d = Eigen::Vector2d;
using Vec3d = Eigen::Vector3d;
using Mat3f = Eigen::Matrix3f;
using Box3f = Eigen::AlignedBox3f;
using Box2f = Eigen::AlignedBox2f;

// A similarity transform p_a = scale * (rotation * p_b) + translation, written a_from_b.
struct Pose {
  Vec3d translation = Vec3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double scale = 1.0;

  // Maps a point of frame b to frame a.
  Vec3d operator*(const Vec3d& point) const { return scale * (rotation * point) + translation; }
  // Composes transforms: a_from_b * b_from_c = a_from_c.
  Pose operator*(const Pose& b_from_c) const {
    return {*this * b_from_c.translation, (rotation * b_from_c.rotation).normalized(),
            scale * b_from_c.scale};
  }
  // Returns b_from_a. Requires scale != 0.
  Pose Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse * (-translation / scale), inverse, 1.0 / scale};
  }
  // Returns the same transform as a float matrix.
  Eigen::Affine3f Affine() const {
    Eigen::Affine3d affine = Eigen::Affine3d::Identity();
    affine.linear() = scale * rotation.toRotationMatrix();
    affine.translation() = translation;
    return affine.cast<float>();
  }
};

}  // namespace parallax
