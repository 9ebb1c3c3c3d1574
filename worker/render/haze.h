// Air between the eye and things: haze that thins out with height, in closed form along straight
// rays. It never touches ground truth. Constant; thread-safe.
//
// A camera ray keeps exp(-optical depth) of what it sees, and gains the rest in the colour that the
// sky has at the horizon in its direction: far land fades into the sky behind it.
#pragma once

#include "common/math/lanes.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/sampling.h"
#include "worker/render/sky.h"

namespace parallax {

class Haze {
 public:
  Haze() = default;  // None.
  explicit Haze(const v1::Air& air);

  bool clear() const { return per_m_ <= 0; }
  // Part of the light that passes along unit `direction` for `distance`, metres.
  Float8 Transmittance(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const;
  // Radiance that the air sends back along a ray of which nothing passes.
  Vec3x8 Glow(const SkyModel& sky, const Vec3x8& direction) const;

 private:
  float per_m_ = 0;       // Extinction at z = 0.
  float scale_m_ = 1000;  // Height over which it falls to 1/e.
  Vec3f tint_ = Vec3f::Ones();
};

}  // namespace parallax
