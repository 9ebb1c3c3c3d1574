// Noise over the ground. Pure; thread-safe.
#pragma once

#include <cstdint>

#include "common/math/types.h"
#include "worker/materials/kernel/noise.h"

namespace parallax {

// Returns gradient noise at `p`, in wavelengths, about [-0.6, 0.6]. It is a tilted slice of solid
// noise: noise of the plane has visible axes, a tilted slice has not.
inline float PlaneNoise(const Vec2f& p, uint32_t seed) {
  return noise::Gradient3(p.x(), p.y(), 0.31f * p.x() - 0.23f * p.y(), seed);
}

}  // namespace parallax
