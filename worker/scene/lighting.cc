#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/dress.h"

namespace parallax {
namespace {

constexpr double kLightGap_m = 0.12;
constexpr int kTries = 60;

// A colour of mean 1.
Vec3d Tint(double hue_rad, double saturation) {
  Vec3d color;
  for (int c = 0; c < 3; ++c) {
    color[c] = 1 + saturation * std::cos(hue_rad - 2 * std::numbers::pi * c / 3);
  }
  return color / color.mean();
}

}  // namespace

void ChooseSky(const v1::LightingConfig& config, const Rng& root, v1::Sky& sky) {
  Rng rng = root.Child("sky");
  sky.set_strength(Draw(config.sky_strength(), root.Child("sky strength").Uniform()));
  const double warm = rng.Uniform(-1, 1);
  const double saturation = Draw(config.sky_saturation(), root.Child("sky saturation").Uniform());
  const double hue = root.Child("sky hue").Uniform(0, 2 * std::numbers::pi);
  const Vec3d natural(1 + 0.06 * warm, 1.0, 1 - 0.08 * warm);
  *sky.mutable_tint() = ToProto(Vec3d(natural.cwiseProduct(Tint(hue, saturation))));
  // Latitudes where people live: mostly 15 to 60 degrees up, all around.
  sky.set_sun_elevation_rad(rng.Uniform(12, 62) * std::numbers::pi / 180);
  sky.set_sun_azimuth_rad(rng.Uniform(0, 2 * std::numbers::pi));
  const bool overcast = rng.Bernoulli(0.35);
  const double sun = rng.Uniform(0.3, 1.0);
  sky.set_sun_strength(overcast ? 0 : sun);
}

Vec3d LampColor(double whiteness, double power_w) {
  const Vec3d color(1.0, 0.86 + 0.13 * whiteness, 0.72 + 0.28 * whiteness);
  return color / color.mean() * power_w;
}

namespace {

void AddPointLights(const v1::LightingConfig& config, const Rng& root, SceneInProgress& scene) {
  const v1::Room& room = scene.recipe.room();
  const long count = std::lround(Draw(config.point_lights(), root.Child("points").Uniform()));
  const double total_w = Draw(config.point_power_w(), root.Child("power").Uniform());
  // Random shares: light i's weight does not depend on how many there are.
  double sum = 0;
  const int first = scene.recipe.lights_size();
  for (long i = 0; i < count; ++i) {
    const double share = root.Child("share", static_cast<uint64_t>(i)).Uniform(0.1, 1.0);
    Rng rng = root.Child("point", static_cast<uint64_t>(i));
    const double radius = rng.Uniform(0.04, 0.09), whiteness = rng.Uniform();
    for (int k = 0; k < kTries; ++k) {
      const Vec3d at(rng.Uniform(0, room.width_m()), rng.Uniform(0, room.depth_m()),
                     rng.Uniform(0.2, 1.0) * room.height_m());
      const float reach = static_cast<float>(radius + kLightGap_m);
      const Vec3f place = at.cast<float>();
      if (scene.solid.NearestDistance(place, reach) < reach || scene.solid.Inside(place)) continue;
      v1::Light& light = *scene.recipe.add_lights();
      light.set_kind(v1::Light::KIND_POINT);
      light.set_name("Point_" + std::to_string(i));
      *light.mutable_position_m() = ToProto(at);
      light.set_radius_m(radius);
      *light.mutable_power_w() = ToProto(LampColor(whiteness, share));
      sum += share;
      break;
    }
  }
  // A light that found no place leaves its power to the others: the total is what was drawn.
  for (int i = first; i < scene.recipe.lights_size(); ++i) {
    v1::Light& light = *scene.recipe.mutable_lights(i);
    *light.mutable_power_w() = ToProto(Vec3d(FromProto(light.power_w()) * (total_w / sum)));
  }
}

// Dims the ceiling lamps and gives them another colour.
void DimCeiling(Rng rng, v1::Scene& recipe) {
  const double factor = std::exp(rng.Uniform(std::log(0.04), std::log(0.5)));
  const double hue = rng.Uniform(0, 2 * std::numbers::pi), saturation = rng.Uniform(0.2, 0.8);
  const Vec3d color = Tint(hue, saturation);
  for (v1::Light& light : *recipe.mutable_lights()) {
    if (light.kind() != v1::Light::KIND_MESH) continue;
    const auto owner = std::find_if(
        recipe.objects().begin(), recipe.objects().end(),
        [&](const v1::SceneObject& object) { return object.index() == light.object_index(); });
    if (owner == recipe.objects().end() || owner->relation() != "on_ceiling") continue;
    const double power = FromProto(light.power_w()).mean() * factor;
    *light.mutable_power_w() = ToProto(Vec3d(color * power));
  }
}

}  // namespace

void ChooseLighting(const v1::LightingConfig& config, SceneInProgress& scene) {
  const Rng root(scene.seed, "dress/lighting");
  ChooseSky(config, root, *scene.recipe.mutable_sky());
  if (config.mode() != v1::LightingConfig::MODE_AUGMENTED) return;
  AddPointLights(config, root, scene);
  scene.recipe.set_ceiling_removed(
      root.Child("ceiling removed").Bernoulli(config.ceiling_removed_p()));
  if (root.Child("ceiling dimmed").Bernoulli(config.ceiling_dimmed_p())) {
    DimCeiling(root.Child("dimming"), scene.recipe);
  }
}

}  // namespace parallax
