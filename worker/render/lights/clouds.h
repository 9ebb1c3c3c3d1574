// Clouds of a sky, baked once: for each direction of the upper hemisphere, their radiance and the
// share of the sky behind them that they let through. They are infinitely far away, as the sky is.
//
// There are two layers. Cumulus clouds between 1.2 and 2.4 km are ray-marched; they are lit by
// single scattering towards the sun, and by two terms with weaker extinction and wider lobes that
// stand for light scattered a few times and many times. Thin streaks lie at 8 km. Cover is the
// share of the layer's area that has cumulus. Constant; thread-safe. Source of the several
// extinctions: Wrenninge et al., "Oz: the great and volumetric", SIGGRAPH 2013.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/lanes.h"
#include "common/math/types.h"

namespace parallax {

// The light on the clouds.
struct CloudLight {
  Vec3f sun_direction = Vec3f::UnitZ();
  Vec3f sun_irradiance = Vec3f::Zero();  // On a surface that faces the sun; 0: no sun.
  Vec3f sky = Vec3f::Ones();             // Mean radiance of the clear dome.
  Vec3f ground = Vec3f::Zero();          // Radiance of the ground below.
};

// The baked table of one sky.
class Clouds {
 public:
  // Bakes the clouds. `cover` is in (0, 1]. Equal arguments give equal clouds. Where the sun shines
  // it does so between the clouds, if it can: else most of the scenes with sun would have none.
  static std::shared_ptr<const Clouds> Bake(double cover, uint64_t seed, const CloudLight& light);

  // The clouds in eight directions.
  struct Layer8 {
    Vec3x8 radiance;
    Float8 kept;  // Share of the light behind that passes, in [0, 1].
  };
  // Returns the clouds in eight directions (unit vectors, world frame). Directions below the
  // horizon are raised to it.
  Layer8 At(const Vec3x8& directions) const;
  // Returns the share of the sun's light that the clouds let through, in [0, 1].
  float sun_kept() const { return sun_kept_; }

 private:
  static constexpr int kSide = 1280;

  // Red, green, blue, kept; rows of a stereographic picture of the hemisphere, seen from below.
  std::vector<float> texels_;
  float sun_kept_ = 1;
};

}  // namespace parallax
