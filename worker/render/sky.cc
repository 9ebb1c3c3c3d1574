#include "worker/render/sky.h"

#include "common/math/proto.h"

namespace parallax {

SkyModel::SkyModel(const v1::Sky& sky) {
  const float strength = static_cast<float>(std::max(0.0, sky.strength()));
  const float sun = static_cast<float>(std::max(0.0, sky.sun_strength()));
  const Vec3f tint =
      sky.has_tint() ? Vec3f(FromProto(sky.tint()).cast<float>().cwiseMax(0.0f)) : Vec3f::Ones();
  clear_ = sun / (sun + 0.5f);
  scale_ = tint * (strength * kZenithRadiance);
  has_sky_ = scale_.maxCoeff() > 0.0f;

  const auto elevation = static_cast<float>(sky.sun_elevation_rad());
  const auto azimuth = static_cast<float>(sky.sun_azimuth_rad());
  sun_direction_ = Vec3f(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  cos_sun_ = std::cos(kSunRadius);
  has_sun_ = sun > 0.0f && strength > 0.0f && sun_direction_.z() > 0.0f;
  // A low sun shines through more air: weaker and warmer.
  const float air = 1.0f / (std::max(sun_direction_.z(), 0.0f) + 0.15f);
  const Vec3f extinction(0.06f, 0.12f, 0.24f);
  const Vec3f passed = (-extinction * (air - 0.87f)).array().exp();
  if (has_sun_) {
    sun_radiance_ =
        tint.cwiseProduct(passed) * (strength * sun * kSunIrradiance / sun_solid_angle());
  }

  // Horizontal irradiance lights a ground of albedo 0.2.
  Vec3f irradiance = Vec3f::Zero();
  float luminance = 0;
  constexpr int kSide = 16;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                  (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const Vec3f radiance = Dome(DirectionAt(u.x(), 2.0f * kPi * u.y()));
    irradiance += radiance * (2.0f * kPi * u.x() / (kSide * kSide));
    luminance += Luminance(radiance) / (kSide * kSide);
  }
  mean_luminance_ = luminance;
  if (has_sun_) irradiance += sun_radiance_ * (sun_solid_angle() * sun_direction_.z());
  ground_ = irradiance.cwiseProduct(Vec3f(0.21f, 0.20f, 0.17f)) * kInvPi;
}

Vec3f SkyModel::Dome(const Vec3f& direction) const {
  const float up = std::max(direction.z(), 0.0f);
  const Vec3f overcast = Vec3f(0.97f, 1.0f, 1.05f) * ((1.0f + 2.0f * up) / 3.0f);
  if (clear_ <= 0.0f) return scale_.cwiseProduct(overcast);
  // Blue overhead, pale at the horizon, bright around the sun.
  const float haze = std::exp(-4.0f * up);
  Vec3f clear = Vec3f(0.20f, 0.38f, 0.80f) * (1.0f - haze) + Vec3f(0.72f, 0.82f, 0.95f) * haze;
  const float cos_sun = direction.dot(sun_direction_);
  const float glow =
      cos_sun > 0.0f ? 0.5f * std::pow(cos_sun, 8.0f) + 1.5f * std::pow(cos_sun, 96.0f) : 0.0f;
  clear += Vec3f(1.0f, 0.9f, 0.75f) * glow;
  return scale_.cwiseProduct(overcast + (clear - overcast) * clear_);
}

Vec3f SkyModel::Radiance(const Vec3f& direction) const {
  if (!has_sky_) return Vec3f::Zero();
  // The horizon is a soft edge 2 degrees wide.
  const float above = std::clamp(direction.z() / 0.035f + 0.5f, 0.0f, 1.0f);
  if (above <= 0.0f) return ground_;
  const Vec3f dome = Dome(direction);
  return above >= 1.0f ? dome : Vec3f(ground_ + (dome - ground_) * above);
}

}  // namespace parallax
