// The direction of a recipe's sun. Pure.
#pragma once

#include <cmath>

#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Returns the unit direction towards the sun (world).
inline Vec3d SunDirection(const v1::Sky& sky) {
  const double level = std::cos(sky.sun_elevation_rad()), azimuth_rad = sky.sun_azimuth_rad();
  return {level * std::cos(azimuth_rad), level * std::sin(azimuth_rad),
          std::sin(sky.sun_elevation_rad())};
}

}  // namespace parallax
