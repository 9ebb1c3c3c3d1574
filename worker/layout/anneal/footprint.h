// Rotated rectangles on the floor: the plan view of furniture. Pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/types.h"

namespace parallax {

// A rectangle with its front along AxisY().
struct Footprint {
  Vec2d center = Vec2d::Zero();
  Vec2d half = Vec2d::Zero();
  double yaw_rad = 0;

  Vec2d AxisX() const { return {std::cos(yaw_rad), std::sin(yaw_rad)}; }
  Vec2d AxisY() const { return {-std::sin(yaw_rad), std::cos(yaw_rad)}; }
  std::array<Vec2d, 4> Corners() const {
    const Vec2d x = AxisX() * half.x(), y = AxisY() * half.y();
    return {Vec2d(center - x - y), Vec2d(center + x - y), Vec2d(center + x + y),
            Vec2d(center - x + y)};
  }
  // Returns the half extents of the axis-aligned box around the footprint.
  Vec2d Extent() const {
    return {std::abs(AxisX().x()) * half.x() + std::abs(AxisY().x()) * half.y(),
            std::abs(AxisX().y()) * half.x() + std::abs(AxisY().y()) * half.y()};
  }
  bool Contains(const Vec2d& p, double margin_m = 0) const {
    const Vec2d d = p - center;
    return std::abs(d.dot(AxisX())) <= half.x() + margin_m &&
           std::abs(d.dot(AxisY())) <= half.y() + margin_m;
  }
};

// Returns whether two footprints overlap or are nearer than `gap_m` (by separating axes).
inline bool Overlap(const Footprint& a, const Footprint& b, double gap_m) {
  const Vec2d between = b.center - a.center;
  for (const Vec2d& axis : {a.AxisX(), a.AxisY(), b.AxisX(), b.AxisY()}) {
    const double reach_a =
        a.half.x() * std::abs(a.AxisX().dot(axis)) + a.half.y() * std::abs(a.AxisY().dot(axis));
    const double reach_b =
        b.half.x() * std::abs(b.AxisX().dot(axis)) + b.half.y() * std::abs(b.AxisY().dot(axis));
    if (std::abs(between.dot(axis)) >= reach_a + reach_b + gap_m) return false;
  }
  return true;
}

}  // namespace parallax
