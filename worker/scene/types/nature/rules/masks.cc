#include "worker/scene/types/nature/rules/masks.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/noise.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

// Standard deviation of the patches' noise, and the scale that turns a logit into a normal
// quantile.
constexpr double kNoiseDeviation = 0.24, kLogitOverNormal = 1.702;
constexpr float kHeightFootprint_m = 3;

// The noise above which a share `cover` of the ground lies.
float ThresholdOf(double cover) {
  const double c = std::clamp(cover, 0.002, 0.998);
  return static_cast<float>(-kNoiseDeviation * std::log(c / (1 - c)) / kLogitOverNormal);
}

}  // namespace

MaskOnGround::Range::Range(const v1::SoftRange& range)
    : low(static_cast<float>(range.low())),
      high(static_cast<float>(range.high())),
      soft(static_cast<float>(std::max(range.soft(), 1e-6))),
      everywhere(range.low() == 0 && range.high() == 0) {}

float MaskOnGround::Range::At(float x) const {
  if (everywhere) return 1;
  return noise::SmoothStep(low - soft, low, x) * (1 - noise::SmoothStep(high, high + soft, x));
}

MaskOnGround::MaskOnGround(const v1::GroundMask& mask)
    : slope_(mask.slope()),
      height_(mask.height_m()),
      above_water_(mask.above_water_m()),
      wetness_(mask.wetness()),
      deposit_(mask.deposit_m()),
      shade_(mask.shade()),
      snow_(mask.snow_m()),
      noise_m_(static_cast<float>(mask.noise_m())),
      threshold_(ThresholdOf(mask.noise_cover())),
      noise_soft_(static_cast<float>(std::max(mask.noise_soft(), 1e-3))),
      noise_seed_(mask.noise_seed()),
      rows_m_(static_cast<float>(mask.rows_m())),
      half_row_m_(static_cast<float>(0.5 * mask.row_width_m())),
      across_(static_cast<float>(-std::sin(mask.row_direction_rad())),
              static_cast<float>(std::cos(mask.row_direction_rad()))) {}

float MaskOnGround::NoiseAt(const Vec2f& p) const {
  float sum = 0, wavelength_m = noise_m_, weight = 0.8f;
  for (uint32_t octave = 0; octave < 3; ++octave) {
    sum += weight * PlaneNoise(p / wavelength_m, noise_seed_ + 77u * octave);
    wavelength_m *= 0.41f;
    weight *= 0.5f;
  }
  return sum;
}

bool MaskOnGround::IsInRow(const Vec2f& p) const {
  const float rows = across_.dot(p) / rows_m_;
  return std::abs(rows - std::round(rows)) * rows_m_ <= half_row_m_;
}

float MaskOnGround::At(const Terrain& terrain, const Vec2f& p) const {
  if (rows_m_ > 0 && !IsInRow(p)) return 0;
  float mask = 1;
  if (noise_m_ > 0) {
    mask = noise::SmoothStep(threshold_ - noise_soft_, threshold_ + noise_soft_, NoiseAt(p));
    if (mask <= 0) return 0;
  }
  if (!slope_.everywhere) mask *= slope_.At(terrain.Steepness(p));
  if (mask > 0 && !wetness_.everywhere) mask *= wetness_.At(terrain.Wetness(p));
  if (mask > 0 && !deposit_.everywhere) mask *= deposit_.At(terrain.Deposit(p));
  if (mask > 0 && !above_water_.everywhere) mask *= above_water_.At(terrain.AboveWater(p));
  if (mask > 0 && !height_.everywhere) mask *= height_.At(terrain.Height(p, kHeightFootprint_m));
  if (mask > 0 && !snow_.everywhere) mask *= snow_.At(terrain.SnowDepth(p));
  return mask;
}

}  // namespace parallax
