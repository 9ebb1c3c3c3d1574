#include "worker/render/lights/haze.h"

#include "common/math/proto.h"

namespace parallax {
Haze::Haze(const v1::Air& air)
    : per_m_(static_cast<float>(std::clamp(air.haze_per_m(), 0.0, 10.0))),
      scale_m_(static_cast<float>(std::clamp(air.scale_height_m(), 1.0, 1e6))) {
  if (air.has_tint()) tint_ = FromProto(air.tint()).cast<float>().cwiseMax(0.0f);
}

// The integral of per_m exp(-z / scale) along the ray.
Float8 Haze::Transmittance(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const {
  const Float8 at_origin = per_m_ * Exp(Clamp(origin.z / -scale_m_, -40.0f, 40.0f));
  const Float8 fall = Clamp(direction.z * distance / scale_m_, -40.0f, 40.0f);
  // (1 - exp(-x)) / x, which is 1 - x / 2 near 0.
  const Mask8 level = Abs(fall) < 1e-3f;
  const Float8 mean = level ? 1.0f - 0.5f * fall : (1.0f - Exp(-fall)) / (level ? Splat(1) : fall);
  return Exp(-Min(at_origin * mean * distance, 80.0f));
}

Vec3x8 Haze::Glow(const SkyModel& sky, const Vec3x8& direction) const {
  return sky.AirRadiance(direction) * tint_;
}

}  // namespace parallax
