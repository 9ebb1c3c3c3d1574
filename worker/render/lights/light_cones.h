// Solid angles that sampling of lights and its densities share.
#pragma once

#include "common/math/lanes.h"

namespace parallax {

// The share of samples of the sky dome that go above the horizon.
inline constexpr float kUpperShare = 0.85f;

// 1 - cos of a sphere's angular radius, from the square of its sine; exact for small angles.
inline float ConeHeight(float sin2) {
  return sin2 / (1.0f + std::sqrt(std::max(0.0f, 1.0f - sin2)));
}
inline Float8 ConeHeight(Float8 sin2) { return sin2 / (1.0f + Sqrt(Max(1.0f - sin2, 0.0f))); }

}  // namespace parallax
