// Sampling tools of light transport: orthonormal frames, maps from the unit square to directions
// and triangles, MIS. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/color.h"
#include "common/math/lanes.h"
#include "common/math/types.h"

namespace parallax {

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 0.31830988618379067154f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

inline float Square(float x) { return x * x; }
// Returns whether no channel is above 0.
inline bool IsBlack(const Vec3f& rgb) { return !(rgb.maxCoeff() > 0.0f); }

// A right-handed frame around the unit vector z.
// Source: Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
struct ShadingFrame {
  Vec3f x, y, z;

  explicit ShadingFrame(const Vec3f& normal) : z(normal) {
    const float sign = std::copysign(1.0f, z.z());
    const float a = -1.0f / (sign + z.z());
    const float b = z.x() * z.y() * a;
    x = Vec3f(1.0f + sign * Square(z.x()) * a, sign * b, -sign * z.x());
    y = Vec3f(b, sign + Square(z.y()) * a, -z.y());
  }
  Vec3f ToWorld(const Vec3f& local) const { return x * local.x() + y * local.y() + z * local.z(); }
  Vec3f ToLocal(const Vec3f& world) const { return {x.dot(world), y.dot(world), z.dot(world)}; }
};

// The same around eight normals.
struct Frame8 {
  Vec3x8 x, y, z;

  explicit Frame8(const Vec3x8& normal) : z(normal) {
    const Float8 sign = CopySign(1.0f, z.z);
    const Float8 a = -1.0f / (sign + z.z);
    const Float8 b = z.x * z.y * a;
    x = {1.0f + sign * Square(z.x) * a, sign * b, -sign * z.x};
    y = {b, sign + Square(z.y) * a, -z.y};
  }
  Vec3x8 ToWorld(const Vec3x8& local) const { return x * local.x + y * local.y + z * local.z; }
  Vec3x8 ToLocal(const Vec3x8& world) const {
    return {Dot(x, world), Dot(y, world), Dot(z, world)};
  }
};

// Returns the unit direction with this cosine to +z and this azimuth, radians.
inline Vec3f DirectionAt(float cos_theta, float phi) {
  const float sin_theta = std::sqrt(std::max(0.0f, 1.0f - Square(cos_theta)));
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta};
}

// A sine and cosine for each lane.
struct Turn8 {
  Float8 sine, cosine;
  explicit Turn8(Float8 angle) : sine(Sin(angle)), cosine(Cos(angle)) {}
};

// Returns the MIS weight of the strategy with density `a` against one with density `b`: the power
// heuristic.
inline float PowerHeuristic(float a, float b) {
  if (!std::isfinite(a)) return 1.0f;
  const float a2 = a * a;
  const float b2 = b * b;
  if (!std::isfinite(a2)) return 1.0f;
  return a2 > 0.0f ? a2 / (a2 + b2) : 0.0f;
}

}  // namespace parallax
