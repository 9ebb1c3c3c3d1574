#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "common/math/sequence.h"
#include "worker/scene/types/indoor/dress_house.h"

namespace parallax {
namespace {

constexpr double kLightGap_m = 0.12;
constexpr int kLampTries = 60;
constexpr double kBallShrinks = 0.8;

// Whether something that moves comes nearer than `reach` in any frame, by its oriented box.
bool MeetsMover(const SceneInProgress& scene, const Vec3d& at, double reach) {
  return std::any_of(scene.movers.begin(), scene.movers.end(), [&](const Mover& mover) {
    const Eigen::AlignedBox3d box(mover.bounds.min().cast<double>(),
                                  mover.bounds.max().cast<double>());
    return std::any_of(scene.recipe.rigs().begin(), scene.recipe.rigs().end(),
                       [&](const v1::Rig& rig) {
                         const Pose pose = PoseAt(mover.object, rig.time_s());
                         return pose.scale * box.exteriorDistance(pose.Inverse() * at) < reach;
                       });
  });
}

// Anywhere in the first room above knee height, clear of everything at the time of every frame. A
// ball of radius `ball_m` shrinks until it is.
std::optional<LightPlace> FindPlace(const SceneInProgress& scene, double ball_m, Rng& rng) {
  const Eigen::AlignedBox3d& bounds = scene.surroundings.bounds;
  const Vec3d size = bounds.sizes();
  LightPlace light;
  light.radius_m = rng.Uniform(0.04, 0.09);
  light.whiteness = rng.Uniform();
  const auto reach = static_cast<float>(light.radius_m + kLightGap_m);
  for (int k = 0; k < kLampTries; ++k) {
    const double z = rng.Uniform(0.2, 1.0) * size.z();
    const double y = rng.Uniform(0, size.y()), x = rng.Uniform(0, size.x());
    light.position = bounds.min() + Vec3d(x, y, z);
    const Vec3f at = light.position.cast<float>();
    if (scene.solid.NearestDistance(at, reach) < reach || scene.solid.Inside(at)) continue;
    if (MeetsMover(scene, light.position, static_cast<double>(reach))) continue;
    if (ball_m == 0) return light;
    const auto wanted = static_cast<float>(ball_m + kLightGap_m);
    double radius = double{scene.solid.NearestDistance(at, wanted)} - kLightGap_m;
    while (radius > light.radius_m && MeetsMover(scene, light.position, radius + kLightGap_m)) {
      radius *= kBallShrinks;
    }
    light.radius_m = std::max(light.radius_m, radius);
    return light;
  }
  return std::nullopt;
}

// Scales the light of the ceiling's lamps, or of all lamps, and gives it another colour.
void TintLamps(bool ceiling_only, double factor, const std::optional<Vec3d>& color,
               v1::Scene& recipe) {
  for (v1::Light& light : *recipe.mutable_lights()) {
    if (light.kind() != v1::Light::KIND_MESH) continue;
    const auto owner = std::find_if(
        recipe.objects().begin(), recipe.objects().end(),
        [&](const v1::SceneObject& object) { return object.index() == light.object_index(); });
    if (owner == recipe.objects().end()) continue;
    if (ceiling_only && owner->relation() != "on_ceiling") continue;
    const Vec3d power_w = FromProto(light.power_w());
    *light.mutable_power_w() =
        ToProto(color ? Vec3d(*color * (power_w.mean() * factor)) : Vec3d(power_w * factor));
  }
}

}  // namespace

void ChooseHouseLighting(const v1::LightingConfig& config, SceneInProgress& scene) {
  const Rng root(scene.seed, "dress/lighting");
  ChooseSky(config, root, *scene.recipe.mutable_sky());
  if (config.mode() != v1::LightingConfig::MODE_AUGMENTED) return;
  AddPointLights(
      config, root, [&](Rng& rng, double ball_m) { return FindPlace(scene, ball_m, rng); },
      *scene.recipe.mutable_lights());
  scene.recipe.mutable_place()->mutable_house()->set_ceiling_removed(
      root.Child("ceiling removed").Bernoulli(config.ceiling_removed_p()));
  if (root.Child("ceiling dimmed").Bernoulli(config.ceiling_dimmed_p())) {
    Rng rng = root.Child("dimming");
    const double factor = std::exp(rng.Uniform(std::log(0.04), std::log(0.5)));
    TintLamps(true, factor, RandomTint(rng), scene.recipe);
  }
  const double lamps = root.Child("lamps").Uniform();
  if (lamps < config.lamps_colored_p()) {
    TintLamps(false, 1, RandomTint(root.Child("lamps colour")), scene.recipe);
  } else if (lamps < config.lamps_colored_p() + config.lamps_dimmed_p()) {
    const double kept = Draw(config.lamps_dimmed_to(), root.Child("lamps dimming").Uniform());
    TintLamps(false, kept, std::nullopt, scene.recipe);
  }
}

}  // namespace parallax
