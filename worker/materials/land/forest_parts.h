// Parts that bark, stones and the forest's floor share. Private to worker/materials.
#pragma once

#include "worker/materials/kernel/surface.h"

namespace parallax {

inline const Vec3f kMossGreen(0.085f, 0.13f, 0.035f);

// Returns how far a face looks towards the direction `shade` (unit), in [0, 1]. Moss grows on the
// shady side.
inline Float8 Facing(const Vec3x8& normal, const Vec3f& shade) {
  return noise::Saturate(0.5f + 0.5f * Along(shade, normal));
}

}  // namespace parallax
