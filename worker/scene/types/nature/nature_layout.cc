// Stage layout: which land, and the rules for what grows on it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

absl::StatusOr<const v1::Biome*> DrawBiome(const v1::NatureConfig& nature, const Rng& root) {
  const std::vector<WeightedBiome> biomes = BiomesOf(nature);
  double sum = 0;
  for (const WeightedBiome& row : biomes) sum += row.weight;
  if (!(sum > 0)) {
    return InvalidArgument("nature.biomes: all weights are 0; one must be larger");
  }
  double left = root.Child("biome").Uniform() * sum;
  const v1::Biome* drawn = nullptr;
  for (const auto& [biome, weight] : biomes) {
    if (weight <= 0) continue;
    drawn = biome;
    if (left < weight) break;
    left -= weight;
  }
  return drawn;
}

// Heights of the middle of the site, where the walk goes and what is near stands.
SiteHeights HeightsOf(const Terrain& terrain) {
  return {Quantile(terrain.surface(), 0.05f), Quantile(terrain.surface(), 0.5f),
          Quantile(terrain.surface(), 0.95f)};
}

void AddPart(uint32_t index, const char* name, const char* asset_class, const char* part,
             v1::ObjectRole role, v1::Layout& layout) {
  v1::SceneObject& object = *layout.add_objects();
  object.set_index(index);
  object.set_name(name);
  object.set_asset_class(asset_class);
  object.set_part(part);
  object.set_role(role);
  object.mutable_world_from_object()->set_qw(1);
  object.mutable_world_from_object()->set_scale(1);
}

// Wind, clarity and colour of the land's water.
void ChooseWater(const v1::WaterConfig& config, const v1::BiomeWater& own, const Rng& rng,
                 v1::Water& water) {
  water.set_wind_mps((own.has_wind() ? own.wind() : 1) *
                     Draw(config.wind_mps(), rng.Child("wind").Uniform()));
  // Wind mostly blows towards the land, as waves bend towards a shore.
  water.set_wind_rad(std::remainder(
      water.direction_rad() + std::numbers::pi + rng.Child("wind from").Normal(0, 0.7),
      2 * std::numbers::pi));
  const double clarity = std::clamp((own.has_clarity() ? own.clarity() : 1) *
                                        Draw(config.clarity_m(), rng.Child("clarity").Uniform()),
                                    0.02, 40.0);
  water.set_clarity_m(clarity);
  const double murky = 1 / (1 + clarity / 0.7);
  Vec3d tint;
  for (int k = 0; k < 3; ++k) {
    // The built-in colours were written with the precision of floats.
    const auto color = [k](const auto& given, std::array<float, 3> absent) {
      return static_cast<double>(given.size() == 3 ? static_cast<float>(given[k])
                                                   : absent[static_cast<size_t>(k)]);
    };
    const double clear = color(own.clear_color(), {0.006f, 0.026f, 0.034f});
    tint[k] = clear + murky * (color(own.murky_color(), {0.05f, 0.085f, 0.07f}) - clear);
  }
  *water.mutable_tint() = ToProto(tint);
}

}  // namespace

absl::StatusOr<std::variant<v1::Layout, Rejected>> LayOutLand(const v1::SceneConfig& config,
                                                              SceneSeed seed,
                                                              const CancelToken& cancel) {
  const Rng root(seed, "nature");
  const v1::NatureConfig& nature = config.nature();
  ASSIGN_OR_RETURN(const v1::Biome* biome, DrawBiome(nature, root));
  ASSIGN_OR_RETURN(const TerrainSpec spec,
                   DrawLandform(biome->landform(), root.Child("land").Child(biome->name())));
  v1::Layout layout;
  v1::Terrain& recipe = *layout.mutable_place()->mutable_terrain();
  recipe.set_biome(biome->name());
  SetTerrainSpec(spec, recipe);
  if (recipe.has_water()) {
    ChooseWater(nature.water(), biome->water(), root.Child("water").Child(biome->name()),
                *recipe.mutable_water());
  }
  if (cancel.cancelled()) return Cancelled("layout: cancelled");
  ASSIGN_OR_RETURN(const std::shared_ptr<const Terrain> terrain, TerrainOf(recipe));

  Rng season = root.Child("season");
  recipe.set_season(nature.seasons().empty() ? "summer" : season.Pick(nature.seasons()));
  const Rng rules = root.Child("rules").Child(biome->name());
  BiomeDraft draft{rules, recipe.season(), Draw(nature.density(), root.Child("density").Uniform()),
                   HeightsOf(*terrain), recipe};
  RETURN_IF_ERROR(WriteRules(*biome, draft));
  recipe.set_ground_object_index(kGroundIndex);
  RETURN_IF_ERROR(CheckRules(recipe));

  AddPart(kGroundIndex, "Ground", "Terrain", "ground", v1::OBJECT_ROLE_TERRAIN, layout);
  if (recipe.has_water()) {
    recipe.mutable_water()->set_object_index(kGroundIndex + 1);
    AddPart(kGroundIndex + 1, "Water", "Water", "water", v1::OBJECT_ROLE_WATER, layout);
  }
  if (recipe.has_roof()) {
    AddPart(kRoofIndex, "Roof", "CaveRoof", "roof", v1::OBJECT_ROLE_ROCK, layout);
  }
  return std::variant<v1::Layout, Rejected>(std::move(layout));
}

}  // namespace parallax
