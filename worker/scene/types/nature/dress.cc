// Stage scene: light and air, then what everything is made of and the hash of what the rules make.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "common/math/sun.h"
#include "worker/scene/types/nature/ground/land_materials.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/scene/types/nature/walk/sight.h"

namespace parallax {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// The most optical depth of haze between an eye and half of the ground that it sees: half of the
// light is left.
constexpr double kMostDepth = 0.7;
constexpr double kOvercast = 0.12;  // Share of the days on which no sun shines.

class LandDresser {
 public:
  LandDresser(const v1::SceneConfig& config, SceneInProgress& scene)
      : config_(config),
        recipe_(scene.recipe),
        land_(*scene.recipe.mutable_place()->mutable_terrain()),
        root_(scene.seed, "dress/nature") {}

  absl::Status Run() {
    RETURN_IF_ERROR(ChooseLight());
    if (land_.has_roof()) RETURN_IF_ERROR(HangLamps());
    RETURN_IF_ERROR(ChooseLandMaterials(config_.nature(), root_, recipe_, land_));
    return CountLand(recipe_, recipe_.rigs(), land_);
  }

 private:
  // Turns the sun so that most of what the frames see is not in the shade of a mountain or a wall:
  // to the first direction that lights kSunlit of it, else to the best.
  static void TurnSunToSight(const Sight& sight, v1::Sky& sky) {
    constexpr double kSunlit = 0.7, kTurn_rad = 2.39996;  // The golden angle.
    constexpr int kTurns = 8;
    v1::Sky turned = sky;
    double most = -1, best = sky.sun_azimuth_rad();
    for (int k = 0; k < kTurns && most < kSunlit; ++k) {
      turned.set_sun_azimuth_rad(sky.sun_azimuth_rad() + k * kTurn_rad);
      const double lit = sight.SunlitShare(SunDirection(turned));
      if (lit <= most) continue;
      most = lit;
      best = turned.sun_azimuth_rad();
    }
    sky.set_sun_azimuth_rad(best);
  }

  absl::Status ChooseLight() {
    ASSIGN_OR_RETURN(const auto terrain, TerrainOf(land_));
    const std::vector<float>& heights = terrain->region().values;
    const double low_m = *std::min_element(heights.begin(), heights.end());
    const v1::NatureConfig& nature = config_.nature();
    v1::Sky& sky = *recipe_.mutable_sky();
    ChooseSky(config_.lighting(), root_, sky);
    const auto draw = [&](const v1::Distribution& from, const char* name) {
      return Draw(from, root_.Child(name).Uniform());
    };
    // Shadows of things are half of what a landscape shows: most days are sunny, and the sun
    // strong.
    Rng day = root_.Child("day");
    const bool overcast = day.Bernoulli(kOvercast);
    sky.set_sun_strength(overcast ? 0 : day.Uniform(0.75, 1));
    sky.set_sun_elevation_rad(draw(nature.sun_elevation_deg(), "sun elevation") * kDegree);
    const Sight sight(*terrain, recipe_.rigs());
    if (!overcast) TurnSunToSight(sight, sky);
    sky.set_turbidity(draw(nature.turbidity(), "turbidity"));
    sky.set_cloud_cover(draw(nature.cloud_cover(), "cloud cover"));
    sky.set_cloud_seed(root_.Child("clouds").Seed());
    v1::Air& air = *recipe_.mutable_air();
    // At the eye, the haze is as thick as drawn, at any height, and never more than e times as
    // thick in the valleys below: no fog hides all that a mountain shows.
    const double eye_m = recipe_.rigs(0).world_from_left().tz();
    air.set_scale_height_m(std::max(root_.Child("haze height").Uniform(120, 900), eye_m - low_m));
    const double clearest = kMostDepth / sight.median_m();
    air.set_haze_per_m(std::min(draw(nature.haze_per_m(), "haze"), clearest) *
                       std::exp(std::clamp(eye_m / air.scale_height_m(), -6.0, 6.0)));
    air.set_forward(0.5);
    // Air under crowns is in their shade.
    const v1::Biome* biome = FindBiome(config_.nature(), land_.biome());
    const double lit = biome != nullptr && biome->woods() ? 0.4 : 1;
    *air.mutable_tint() = ToProto(Vec3d(lit * Vec3d(0.97, 0.99, 1.04)));
    return absl::OkStatus();
  }

  // A cave's lamps, as those that show people around have: on ledges beside the way, warm or pale.
  absl::Status HangLamps() {
    ASSIGN_OR_RETURN(const auto terrain, TerrainOf(land_));
    const TerrainTerm& gorge = terrain->spec().cover.front();
    const double half = land_.roof().half_length_m() - 4;
    Rng rng = root_.Child("lamps");
    const double warm = rng.Uniform(), power_w = rng.Uniform(350, 1100);
    for (double along = -half + rng.Uniform(0, 8); along < half; along += rng.Uniform(9, 15)) {
      const auto at = static_cast<float>(along);
      const Vec2f middle = GorgeMiddle(gorge, at);
      const float away =
          PlaceInGorge(gorge, middle).half_m * static_cast<float>(rng.Uniform(0.55, 0.9));
      const Vec2f ahead = (GorgeMiddle(gorge, at + 1) - middle).normalized();
      const float side = rng.Bernoulli(0.5) ? away : -away;
      const Vec2f p = middle + side * Vec2f(-ahead.y(), ahead.x());
      const double up = rng.Uniform(1.6, 0.6 * land_.roof().rise_m());
      v1::Light& lamp = *recipe_.add_lights();
      lamp.set_kind(v1::Light::KIND_POINT);
      lamp.set_name(fmt::format("Lamp_{}", recipe_.lights_size()));
      *lamp.mutable_position_m() =
          ToProto(Vec3d(p.x(), p.y(), static_cast<double>(terrain->Height(p, 1)) + up));
      lamp.set_radius_m(0.12);
      const Vec3d color(1.0, 0.9 - 0.2 * warm, 0.8 - 0.45 * warm);
      *lamp.mutable_power_w() =
          ToProto(Vec3d(color / color.mean() * power_w * rng.Uniform(0.6, 1.4)));
    }
    return absl::OkStatus();
  }

  const v1::SceneConfig& config_;
  v1::Scene& recipe_;
  v1::Terrain& land_;
  const Rng root_;
};

}  // namespace

absl::Status DressLand(const v1::SceneConfig& config, const CancelToken& cancel,
                       SceneInProgress& scene) {
  if (cancel.cancelled()) return Cancelled("solve: cancelled");
  return LandDresser(config, scene).Run();
}

}  // namespace parallax
