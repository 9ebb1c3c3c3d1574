// Snow on the ground: its depth by slope, height and wind, and its smooth surface.
#pragma once

#include <cstdint>

#include "worker/terrain/field.h"

namespace parallax {

// The snow of a landscape.
struct SnowSpec {
  float depth_m = 0;  // On level ground out of the wind; 0: no snow.
  float line_m = 0;   // World z: all of it above, none below line_m - line_soft_m.
  float line_soft_m = 1;
  float slope = 0.7f;  // Rise over run up to which it holds; none lies on twice that.
  float wind_rad = 0;  // Direction to which the wind blows.
  uint32_t seed = 0;
};

// Returns the depth of the snow at each sample of `ground`, metres, >= 0. It fills hollows, and
// lies thick in the lee, thin to windward and on crests.
// Source: Fearing, "Computer modelling of fallen snow", SIGGRAPH 2000, for the idea that what is
// too steep moves on until it holds; here by diffusion of the surface.
Field SnowOn(const Field& ground, const SnowSpec& spec);

}  // namespace parallax
