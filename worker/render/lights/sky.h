// The background of every scene: an analytic sky over a plain ground, and the sun as a small disk.
//
// Radiance is in the renderer's units, where a lamp of P watts emits P: strength 1 is an overcast
// noon with kZenithRadiance at the zenith. `sun_strength` s makes the sky clear and adds s *
// kSunIrradiance, weakened and reddened by the air, on a surface that faces the sun. The weight of
// the clear sky is s / (s + 0.5), as under a veil of thin cloud; where `turbidity`, the amount of
// haze, is given, it is s / (s + 0.1). `cloud_cover` adds clouds, which also weaken the sun behind
// them. Constant; thread-safe.
//
// Source of the overcast gradient: Moon and Spencer, 1942; of the clear sky and the sun's colour:
// Preetham, Shirley and Smits, "A practical analytic model for daylight", 1999, whose y is replaced
// by that of the CIE's daylight of the same x: no real sky is pink or green.
#pragma once

#include <memory>

#include "parallax/v1/scene.pb.h"
#include "worker/render/lights/clouds.h"
#include "worker/render/lights/environment.h"
#include "worker/render/surface/sampling.h"

namespace parallax {

// The sky, sun and ground of one recipe.
class SkyModel {
 public:
  static constexpr float kZenithRadiance = 10.0f;  // W / (m^2 sr)
  static constexpr float kSunIrradiance = 90.0f;   // W / m^2
  // The usual one: a clear day of temperate summers.
  static constexpr float kTurbidity = 3.0f;
  static constexpr float kSunRadius = 0.0087f;  // Radians; twice the real one, as haze does.

  SkyModel() : SkyModel(v1::Sky()) {}
  // With `ground`, a flat lit ground is seen below the horizon; otherwise the horizon's radiance
  // continues there. `environment` replaces sky, sun and ground, turned as the recipe says and
  // scaled so that it lights a horizontal plane as strongly as they would.
  explicit SkyModel(const v1::Sky& sky, bool ground = true,
                    std::shared_ptr<const Environment> environment = nullptr);

  // Returns the radiance from unit `direction` (world), without the sun's disk.
  Vec3x8 Radiance(const Vec3x8& directions) const;
  Vec3f Radiance(const Vec3f& direction) const { return Radiance(Vec3x8(direction)).Get(0); }
  // Returns the radiance of air so thick that nothing behind it is seen: the sky at the horizon in
  // that direction, or higher where the direction is. Clouds and surroundings count with their mean
  // over all horizontal directions, because air hides their shapes.
  Vec3x8 AirRadiance(const Vec3x8& directions) const;
  // Returns the radiance of the sun's disk.
  const Vec3f& SunRadiance() const { return sun_radiance_; }
  bool InSun(const Vec3f& direction) const {
    return has_sun_ && direction.dot(sun_direction_) > cos_sun_;
  }

  bool has_sky() const { return has_sky_; }
  bool has_sun() const { return has_sun_; }
  // With an environment only: samples a direction in proportion to its light, and the density of
  // that, per solid angle.
  bool has_environment() const { return environment_ != nullptr; }
  Vec3f SampleEnvironment(float u, float v) const { return turn_ * environment_->Sample(u, v); }
  float EnvironmentPdf(const Vec3f& direction) const {
    return environment_->Pdf(turn_.transpose() * direction);
  }

  const Vec3f& sun_direction() const { return sun_direction_; }
  float cos_sun() const { return cos_sun_; }
  // Returns the solid angle of the sun's disk.
  float sun_solid_angle() const { return 2.0f * kPi * (1.0f - cos_sun_); }
  float mean_luminance() const { return mean_luminance_; }  // Mean over the upper hemisphere.
  float turbidity() const { return turbidity_; }
  float ground_luminance() const { return Luminance(ground_); }

 private:
  // Perez's distribution of a quantity over a clear sky, relative to the zenith.
  struct Perez {
    float a = 0, b = 0, c = 0, d = 0, e = 0, zenith = 0;
    Float8 At(Float8 cos_theta, Float8 gamma, Float8 cos_gamma) const {
      return zenith * (1.0f + a * Exp(b / cos_theta)) *
             (1.0f + c * Exp(d * gamma) + e * cos_gamma * cos_gamma);
    }
  };

  void SetClearSky(float sun_elevation);
  void SetSun(float elevation, float strength, const Vec3f& tint);
  void AddClouds(const v1::Sky& sky);
  void UseEnvironment(std::shared_ptr<const Environment> environment, double turn_rad,
                      const Vec3f& tint, float ground_irradiance);
  Vec3x8 ClearSky(const Vec3x8& directions) const;
  Vec3x8 Flattened(const Vec3x8& radiance) const {
    return radiance * (1.0f - flat_share_) + Vec3x8(flat_) * flat_share_;
  }
  // The dome without clouds, and with them.
  Vec3x8 OpenDome(const Vec3x8& directions) const;
  Vec3x8 Dome(const Vec3x8& directions) const;
  Vec3f MeanAtHorizon() const;
  void SetAir();

  bool has_ground_ = true;
  bool has_sky_ = false, has_sun_ = false;
  float turbidity_ = kTurbidity;
  std::shared_ptr<const Clouds> clouds_;            // None: a sky without.
  std::shared_ptr<const Environment> environment_;  // Likewise.
  Mat3f turn_ = Mat3f::Identity();                  // World from environment.
  Vec3f environment_scale_ = Vec3f::Zero();
  float clear_ = 0;  // [0, 1]
  Perez perez_[2];   // CIE x; luminance in kcd/m^2.
  Vec3f scale_ = Vec3f::Zero();
  Vec3f flat_ = Vec3f::Zero();    // One colour, which has a share of the sky.
  float flat_share_ = 0;          // [0, 1]
  Vec3f ground_ = Vec3f::Zero();  // Radiance below the horizon.
  Vec3f sun_radiance_ = Vec3f::Zero();
  Vec3f sun_direction_ = Vec3f::UnitZ();
  Vec3f air_glow_ = Vec3f::Zero();  // Mean radiance of clouds or environment at the horizon,
  float air_kept_ = 1;              // and the mean share of the open dome that they leave.
  float cos_sun_ = 1;
  float mean_luminance_ = 0;
};

}  // namespace parallax
