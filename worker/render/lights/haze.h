// Haze between the eye and surfaces, which thins out with height; in closed form along straight
// rays. It never changes ground truth. Constant; thread-safe.
//
// A camera ray keeps exp(-optical depth) of the radiance that it sees, and gains the rest in the
// colour of the sky at the horizon in its direction, without the shapes of clouds: far land fades
// into the sky behind it.
#pragma once

#include "common/math/lanes.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/lights/sky.h"
#include "worker/render/surface/sampling.h"

namespace parallax {

// Participating air with an exponential profile of density over z.
class Haze {
 public:
  Haze() = default;  // No haze.
  explicit Haze(const v1::Air& air);

  // Returns whether there is no haze.
  bool clear() const { return per_m_ <= 0; }
  // Returns the transmittance along unit `direction` over `distance` metres, in [0, 1].
  Float8 Transmittance(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const;
  // Returns the radiance of air so thick that nothing behind it is seen.
  Vec3x8 Glow(const SkyModel& sky, const Vec3x8& direction) const;

 private:
  float per_m_ = 0;       // Extinction at z = 0.
  float scale_m_ = 1000;  // Height over which it falls to 1/e.
  Vec3f tint_ = Vec3f::Ones();
};

}  // namespace parallax
