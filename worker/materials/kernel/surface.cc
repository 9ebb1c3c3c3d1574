#include "worker/materials/kernel/surface.h"

#include <cmath>
#include <span>

namespace parallax {
namespace {

float LinearOf(double srgb) {
  return Float(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

}  // namespace

Vec3f SrgbColor(uint32_t hex) {
  return {LinearOf((hex >> 16 & 0xff) / 255.0), LinearOf((hex >> 8 & 0xff) / 255.0),
          LinearOf((hex & 0xff) / 255.0)};
}

Vec3f HsvColor(double hue, double saturation, double value) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue * 6.0, 6.0);
    return LinearOf(value - value * saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

Vec3f VaryColor(Rng& rng, const Vec3f& color, double value, double tint) {
  const double gain = std::exp(std::clamp(rng.Normal(0, value), -2 * value, 2 * value));
  Vec3f varied;
  for (int i = 0; i < 3; ++i) {
    varied[i] = color[i] * Float(gain * std::exp(rng.Uniform(-1.7, 1.7) * tint));
  }
  return Albedo(varied);
}

Vec3f PickColor(Rng& rng, std::initializer_list<uint32_t> hexes, double value, double tint) {
  return VaryColor(rng, SrgbColor(rng.Pick(std::span(hexes.begin(), hexes.size()))), value, tint);
}

Vec3f Desaturate(const Vec3f& color, float amount) {
  return Mix(color, Vec3f::Constant(Luminance(color)), amount);
}

}  // namespace parallax
