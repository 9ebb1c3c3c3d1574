#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <string>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/dress.h"

namespace parallax {
namespace {

// A lamp's light: white to warm by `whiteness` in [0, 1], of `power_w` in all.
Vec3d LampColor(double whiteness, double power_w) {
  const Vec3d color(1.0, 0.86 + 0.13 * whiteness, 0.72 + 0.28 * whiteness);
  return color / color.mean() * power_w;
}

}  // namespace

Vec3d TintOf(double hue_rad, double saturation) {
  Vec3d color;
  for (int c = 0; c < 3; ++c) {
    color[c] = 1 + saturation * std::cos(hue_rad - 2 * std::numbers::pi * c / 3);
  }
  return color / color.mean();
}

Vec3d RandomTint(Rng rng) {
  const double hue = rng.Uniform(0, 2 * std::numbers::pi), saturation = rng.Uniform(0.2, 0.8);
  return TintOf(hue, saturation);
}

void ChooseSky(const v1::LightingConfig& config, const Rng& root, v1::Sky& sky) {
  Rng rng = root.Child("sky");
  const bool dark = root.Child("dark sky").Bernoulli(config.dark_sky_p());
  sky.set_strength(Draw(dark ? config.dark_sky_strength() : config.sky_strength(),
                        root.Child("sky strength").Uniform()));
  const double warm = rng.Uniform(-1, 1);
  const double saturation = Draw(config.sky_saturation(), root.Child("sky saturation").Uniform());
  const double hue = root.Child("sky hue").Uniform(0, 2 * std::numbers::pi);
  const Vec3d natural(1 + 0.02 * warm, 1.0, 1 - 0.03 * warm);
  *sky.mutable_tint() = ToProto(Vec3d(natural.cwiseProduct(TintOf(hue, saturation))));
  // Latitudes where people live: mostly 15 to 60 degrees up, all around.
  sky.set_sun_elevation_rad(rng.Uniform(12, 62) * std::numbers::pi / 180);
  sky.set_sun_azimuth_rad(rng.Uniform(0, 2 * std::numbers::pi));
  const bool overcast = rng.Bernoulli(0.35);
  const double sun = rng.Uniform(0.3, 1.0);
  sky.set_sun_strength(config.has_sun_strength()
                           ? Draw(config.sun_strength(), root.Child("sun strength").Uniform())
                           : (overcast ? 0 : sun));
  sky.set_flat_share(Draw(config.flat_sky(), root.Child("flat sky").Uniform()));
  if (sky.flat_share() > 0) *sky.mutable_flat() = ToProto(RandomTint(root.Child("flat colour")));
}

void AddPointLights(const v1::LightingConfig& config, const Rng& root,
                    const std::function<std::optional<LightPlace>(Rng& rng, double ball_m)>& place,
                    google::protobuf::RepeatedPtrField<v1::Light>& lights) {
  const long count = std::lround(Draw(config.point_lights(), root.Child("points").Uniform()));
  const double total_w = Draw(config.point_power_w(), root.Child("power").Uniform());
  const bool each = config.point_split() == v1::LightingConfig::POINT_SPLIT_EACH;
  // Random shares: light i's weight does not depend on how many there are.
  double sum = 0;
  const int first = lights.size();
  for (long i = 0; i < count; ++i) {
    const auto number = static_cast<uint64_t>(i);
    const double share = root.Child("share", number).Uniform(each ? 0 : 0.1, 1.0);
    const bool large = root.Child("large", number).Bernoulli(config.point_large_p());
    const double radius_m = root.Child("radius", number).Uniform();
    Rng rng = root.Child("point", number);
    const std::optional<LightPlace> found =
        place(rng, large ? Draw(config.point_radius_m(), radius_m) : 0);
    if (!found) continue;
    v1::Light& light = *lights.Add();
    light.set_kind(v1::Light::KIND_POINT);
    light.set_name(fmt::format("Point_{}", i));
    *light.mutable_position_m() = ToProto(found->position);
    light.set_radius_m(found->radius_m);
    const bool colored = root.Child("colored", number).Bernoulli(config.point_colored_p());
    *light.mutable_power_w() =
        ToProto(colored ? Vec3d(RandomTint(root.Child("colour", number)) * share)
                        : LampColor(found->whiteness, share));
    sum += share;
  }
  if (each) sum = static_cast<double>(count);
  // A light that found no place leaves its power to the others: the total is what was drawn.
  for (int i = first; i < lights.size(); ++i) {
    v1::Light& light = *lights.Mutable(i);
    *light.mutable_power_w() = ToProto(Vec3d(FromProto(light.power_w()) * (total_w / sum)));
  }
}

}  // namespace parallax
