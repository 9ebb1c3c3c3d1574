#include "worker/render/lights/sky.h"

#include "common/math/proto.h"
#include "common/math/sun.h"

namespace parallax {
namespace {

constexpr float kAirHorizon = 0.045f;  // Sine of the elevation that gives thick air its colour.
constexpr float kRadiancePerKilocandela = 0.9f;  // Balances sun and overcast sky as in nature.
// Extinction of red, green, blue (610, 550, 465 nm) in air and haze of kTurbidity, one air mass.
const Vec3f kExtinction(0.241f, 0.301f, 0.448f);
// Haze adds this for each unit of turbidity: 0.04608 lambda^-1.3, lambda in micrometres.
const Vec3f kHazeExtinction(0.0876f, 0.1002f, 0.1247f);
constexpr float kPaleHaze = 0.5f;  // Share of the horizon's colour that haze takes.
// The colour that haze gives the horizon: the model alone leaves it beige in clear air.
const Vec3f kHazeColor(0.88f, 1.0f, 1.2f);
constexpr float kVeil = 0.5f, kVeilOfSaidAir = 0.1f;             // Weight of the overcast sky.
constexpr float kLeastTurbidity = 1.8f, kMostTurbidity = 10.0f;  // The model's range.

// CIE x of the zenith: a polynomial in (T^2, T, 1) x (theta^3, theta^2, theta, 1).
float ZenithX(float theta, float t) {
  constexpr float kTerms[3][4] = {{0.00166f, -0.00375f, 0.00209f, 0.0f},
                                  {-0.02903f, 0.06377f, -0.03202f, 0.00394f},
                                  {0.11693f, -0.21196f, 0.06052f, 0.25886f}};
  const float powers[4] = {theta * theta * theta, theta * theta, theta, 1.0f};
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    sum += powers[k] * (t * t * kTerms[0][k] + t * kTerms[1][k] + kTerms[2][k]);
  }
  return sum;
}

}  // namespace

SkyModel::SkyModel(const v1::Sky& sky, bool ground, std::shared_ptr<const Environment> environment)
    : has_ground_(ground) {
  const float strength = static_cast<float>(std::max(0.0, sky.strength()));
  const float sun = static_cast<float>(std::max(0.0, sky.sun_strength()));
  const Vec3f tint =
      sky.has_tint() ? Vec3f(FromProto(sky.tint()).cast<float>().cwiseMax(0.0f)) : Vec3f::Ones();
  clear_ = sun / (sun + (sky.turbidity() > 0 ? kVeilOfSaidAir : kVeil));
  if (sky.turbidity() > 0) {
    turbidity_ = std::clamp(static_cast<float>(sky.turbidity()), kLeastTurbidity, kMostTurbidity);
  }
  scale_ = tint * (strength * kZenithRadiance);
  has_sky_ = scale_.maxCoeff() > 0.0f;
  flat_share_ = std::clamp(static_cast<float>(sky.flat_share()), 0.0f, 1.0f);
  flat_ = FromProto(sky.flat()).cast<float>().cwiseMax(0.0f) * (strength * kZenithRadiance);

  const auto elevation = static_cast<float>(sky.sun_elevation_rad());
  sun_direction_ = SunDirection(sky).cast<float>();
  cos_sun_ = std::cos(kSunRadius);
  has_sun_ = sun > 0.0f && strength > 0.0f && sun_direction_.z() > 0.0f;
  SetClearSky(elevation);
  if (has_sun_) SetSun(elevation, strength * sun, tint);
  if (has_sky_ && sky.cloud_cover() > 0) AddClouds(sky);

  // A ground of albedo 0.2, lit by the horizontal irradiance.
  Vec3f irradiance = Vec3f::Zero();
  float luminance = 0;
  constexpr int kSide = 16;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                  (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const Vec3f radiance = Dome(Vec3x8(DirectionAt(u.x(), 2.0f * kPi * u.y()))).Get(0);
    irradiance += radiance * (2.0f * kPi * u.x() / (kSide * kSide));
    luminance += Luminance(radiance) / (kSide * kSide);
  }
  mean_luminance_ = luminance;
  if (has_sun_) irradiance += sun_radiance_ * (sun_solid_angle() * sun_direction_.z());
  ground_ = ground ? Vec3f(irradiance.cwiseProduct(Vec3f(0.21f, 0.20f, 0.17f)) * kInvPi)
                   : MeanAtHorizon();
  if (ground && flat_share_ > 0) ground_ = Flattened(Vec3x8(ground_)).Get(0);
  if (environment && has_sky_) {
    UseEnvironment(std::move(environment), sky.environment_turn_rad(), tint, Luminance(irradiance));
  }
  SetAir();
}

void SkyModel::UseEnvironment(std::shared_ptr<const Environment> environment, double turn_rad,
                              const Vec3f& tint, float ground_irradiance) {
  environment_ = std::move(environment);
  turn_ = Eigen::AngleAxisf(static_cast<float>(turn_rad), Vec3f::UnitZ()).toRotationMatrix();
  const float scale = ground_irradiance / environment_->ground_irradiance();
  environment_scale_ = tint * (scale / Luminance(tint));
  mean_luminance_ = scale * environment_->mean_luminance();
  has_sun_ = false;
}

// A low sun shines through more air: weaker and warmer. Full strength at the zenith in usual haze.
void SkyModel::SetSun(float elevation, float strength, const Vec3f& tint) {
  const float degrees = 90.0f - elevation * (180.0f / kPi);
  const float air = 1.0f / (sun_direction_.z() + 0.15f * std::pow(93.885f - degrees, -1.253f));
  const Vec3f haze = kHazeExtinction * ((turbidity_ - kTurbidity) * air);
  const Vec3f passed = (-kExtinction * (air - 1.0f) - haze).array().exp();
  sun_radiance_ = tint.cwiseProduct(passed) * (strength * kSunIrradiance / sun_solid_angle());
}

void SkyModel::AddClouds(const v1::Sky& sky) {
  CloudLight light;
  light.sun_direction = sun_direction_;
  if (has_sun_) light.sun_irradiance = sun_radiance_ * sun_solid_angle();
  light.sky = Vec3f::Zero();
  constexpr int kDirections = 64;
  for (int i = 0; i < kDirections; ++i) {
    const float z = (static_cast<float>(i) + 0.5f) / kDirections;
    light.sky +=
        Dome(Vec3x8(DirectionAt(z, 2.39996f * static_cast<float>(i)))).Get(0) / kDirections;
  }
  const Vec3f down = light.sun_irradiance * std::max(0.0f, sun_direction_.z()) + kPi * light.sky;
  light.ground = down * (0.2f * kInvPi);
  clouds_ = Clouds::Bake(std::min(sky.cloud_cover(), 1.0), sky.cloud_seed(), light);
  sun_radiance_ *= clouds_->sun_kept();
  has_sun_ = has_sun_ && sun_radiance_.maxCoeff() > 0.0f;
}

Vec3f SkyModel::MeanAtHorizon() const {
  constexpr int kDirections = 64;
  Vec3f sum = Vec3f::Zero();
  for (int i = 0; i < kDirections; ++i) {
    const float azimuth = 2.0f * kPi * static_cast<float>(i) / kDirections;
    sum += Dome(Vec3x8(DirectionAt(0.0f, azimuth))).Get(0);
  }
  return sum / kDirections;
}

Vec3x8 SkyModel::OpenDome(const Vec3x8& directions) const {
  const Float8 up = Max(directions.z, 0.0f);
  const Vec3x8 overcast = Vec3f(0.97f, 1.0f, 1.05f) * ((1.0f + 2.0f * up) / 3.0f);
  const Vec3x8 scale(scale_);
  const Vec3x8 open =
      clear_ <= 0.0f ? overcast : overcast + (ClearSky(directions) - overcast) * clear_;
  return flat_share_ == 0 ? scale * open : Flattened(scale * open);
}

Vec3x8 SkyModel::Dome(const Vec3x8& directions) const {
  const Vec3x8 open = OpenDome(directions);
  if (!clouds_) return open;
  const Clouds::Layer8 clouds = clouds_->At(directions);
  return open * clouds.kept + clouds.radiance;
}

Vec3x8 SkyModel::AirRadiance(const Vec3x8& directions) const {
  const Vec3x8 at(directions.x, directions.y, Clamp(directions.z, kAirHorizon, 1.0f));
  return OpenDome(at / Norm(at)) * air_kept_ + Vec3x8(air_glow_);
}

void SkyModel::SetAir() {
  if (!has_sky_ || (!clouds_ && !environment_)) return;
  constexpr int kDirections = 256;
  air_kept_ = 0;
  for (int i = 0; i < kDirections; ++i) {
    const float azimuth = 2.0f * kPi * static_cast<float>(i) / kDirections;
    const Vec3x8 direction(DirectionAt(kAirHorizon, azimuth));
    if (environment_) {
      air_glow_ += Radiance(direction).Get(0) / kDirections;
      continue;
    }
    const Clouds::Layer8 clouds = clouds_->At(direction);
    air_glow_ += clouds.radiance.Get(0) / kDirections;
    air_kept_ += clouds.kept[0] / kDirections;
  }
}

void SkyModel::SetClearSky(float sun_elevation) {
  const float t = turbidity_;
  perez_[0] = {-0.0193f * t - 0.2592f, -0.0665f * t + 0.0008f, -0.0004f * t + 0.2125f,
               -0.0641f * t - 0.8989f, -0.0033f * t + 0.0452f, 0.0f};
  perez_[1] = {0.1787f * t - 1.4630f, -0.3554f * t + 0.4275f, -0.0227f * t + 5.3251f,
               0.1206f * t - 2.5771f, -0.0670f * t + 0.3703f, 0.0f};
  // The model is for daytime: a sun below 5 degrees gets the sky of 5 degrees.
  const float theta = std::clamp(0.5f * kPi - sun_elevation, 0.0f, 85.0f * kPi / 180.0f);
  const float chi = (4.0f / 9.0f - t / 120.0f) * (kPi - 2.0f * theta);
  const float zenith[2] = {ZenithX(theta, t),
                           (4.0453f * t - 4.9710f) * std::tan(chi) - 0.2155f * t + 2.4192f};
  for (int k = 0; k < 2; ++k) {
    perez_[k].zenith = 1.0f;
    perez_[k].zenith = zenith[k] / perez_[k].At(Splat(1), Splat(theta), Splat(std::cos(theta)))[0];
  }
}

// Radiance relative to the overcast zenith.
Vec3x8 SkyModel::ClearSky(const Vec3x8& directions) const {
  const Float8 up = Max(directions.z, 0.01f);
  const Float8 cos_gamma = Clamp(Inner(directions, Vec3x8(sun_direction_)), -1.0f, 1.0f);
  const Float8 gamma = Acos(cos_gamma);
  // Chromaticity of daylight from 25000 to 4000 K (CIE 15).
  const Float8 x = Clamp(perez_[0].At(up, gamma, cos_gamma), 0.25f, 0.3823f);
  const Float8 y = (2.87f - 3.0f * x) * x - 0.275f;
  const Float8 luminance = perez_[1].At(up, gamma, cos_gamma);
  const Float8 big_x = x / y, big_z = (1.0f - x - y) / y;
  const Vec3x8 rgb(3.2406f * big_x - 1.5372f - 0.4986f * big_z,
                   -0.9689f * big_x + 1.8758f + 0.0415f * big_z,
                   0.0557f * big_x - 0.2040f + 1.0570f * big_z);
  const Vec3x8 color(Max(rgb.x, 0.0f), Max(rgb.y, 0.0f), Max(rgb.z, 0.0f));
  const Float8 low = (1.0f - up) * (1.0f - up);
  const Float8 pale = kPaleHaze * low * low * low;
  const Float8 scale = luminance * (kRadiancePerKilocandela / kZenithRadiance);
  return (color + (Vec3x8(kHazeColor) - color) * pale) * scale;
}

Vec3x8 SkyModel::Radiance(const Vec3x8& directions) const {
  if (!has_sky_) return Vec3x8::Zero();
  if (environment_) {
    const Mat3f& t = turn_;  // About z.
    const Vec3x8 seen(t(0, 0) * directions.x + t(1, 0) * directions.y,
                      t(0, 1) * directions.x + t(1, 1) * directions.y, directions.z);
    return environment_->Radiance(seen) * Vec3x8(environment_scale_);
  }
  if (!has_ground_) return Dome(directions);
  // The horizon is a soft edge 2 degrees wide.
  const Float8 above = Clamp(directions.z / 0.035f + 0.5f, 0.0f, 1.0f);
  const Vec3x8 ground(ground_);
  if (!Any(above > 0.0f)) return ground;
  const Vec3x8 dome = Dome(directions);
  return Select(above >= 1.0f, dome, ground + (dome - ground) * above);
}

}  // namespace parallax
