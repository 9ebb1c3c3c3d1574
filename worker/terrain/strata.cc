#include "worker/terrain/strata.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/noise.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

// A random number of a bed, [0, 1).
float OfBed(float bed, uint32_t seed) {
  return noise::Unit(noise::Hash(static_cast<int32_t>(bed), seed));
}

}  // namespace

float Strata::Level(const Vec2f& p, float height_m) const {
  const float away =
      spec_.dip * (std::cos(spec_.dip_rad) * p.x() + std::sin(spec_.dip_rad) * p.y());
  const float folds = 0.5f * PlaneNoise(p / 160.0f, spec_.seed);
  const float level = (height_m - away) / spec_.bed_m + folds;
  // Beds are of uneven thickness. The slope of the noise is too small to turn the order around.
  return level + 0.4f * noise::Gradient3(0.43f * level, 0.5f, 0.5f, spec_.seed + 1);
}

float Strata::Stepped(const Vec2f& p, float height_m, float debris) const {
  const float level = Level(p, height_m), bed = std::floor(level), in_bed = level - bed;
  // The soft rock lies below, the hard one on it takes the last part of the run.
  const float follow =
      spec_.step * (1 - debris) * noise::Lerp(0.55f, 1.0f, OfBed(bed, spec_.seed + 2));
  const float hard = noise::Lerp(1.0f, 0.1f, follow), soft = 1 - hard;
  const float foot = soft * noise::Lerp(1.0f, 0.3f, follow);
  const float stepped =
      in_bed < soft ? in_bed * foot / soft : foot + (in_bed - soft) * (1 - foot) / hard;
  return height_m + spec_.bed_m * (stepped - in_bed);
}

float Strata::Ledge(const Vec3f& p) const {
  const float level = Level(p.head<2>(), p.z());
  // Each bed is cut into courses; blocks broke out of them.
  const float course = 3.7f * level, k = std::floor(course), t = course - k;
  const auto depth = [&](float at) {
    const Vec3f blocks(p.x() / 2.6f, p.y() / 2.6f, 0.6f * at);
    const float broken = noise::SmoothStep(-0.1f, 0.2f, noise::Gradient3(blocks, spec_.seed + 4));
    return 0.55f * OfBed(at, spec_.seed + 3) + 0.3f * broken;
  };
  const float out = noise::Lerp(depth(k), depth(k + 1), noise::SmoothStep(0.72f, 0.98f, t));
  const float rough = 0.5f + 0.5f * noise::Gradient3(p / 1.3f, spec_.seed + 5);
  return spec_.ledge_m * std::clamp(out + 0.15f * rough, 0.0f, 1.0f);
}

}  // namespace parallax
