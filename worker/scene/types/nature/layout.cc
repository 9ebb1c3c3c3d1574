// Stage layout: which land, and the rules for what grows on it.
#include <algorithm>
#include <string>
#include <utility>

#include "common/config/config.h"
#include "worker/scene/types/nature/biomes.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/recipe.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

absl::StatusOr<const Biome*> DrawBiome(const v1::BiomeWeights& weights, const Rng& root) {
  double sum = 0;
  for (const Biome* biome : Biomes()) sum += std::max(0.0, biome->weight(weights));
  if (!(sum > 0)) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "nature.biomes: all weights are 0; one must be larger");
  }
  double left = root.Child("biome").Uniform() * sum;
  const Biome* drawn = nullptr;
  for (const Biome* biome : Biomes()) {
    const double weight = std::max(0.0, biome->weight(weights));
    if (weight <= 0) continue;
    drawn = biome;
    if (left < weight) break;
    left -= weight;
  }
  return drawn;
}

// Heights of the middle of the site, where the walk goes and what is near stands.
SiteHeights HeightsOf(const Terrain& terrain) {
  return {Quantile(terrain.site(), 0.05f), Quantile(terrain.site(), 0.5f),
          Quantile(terrain.site(), 0.95f)};
}

}  // namespace

absl::StatusOr<std::variant<v1::Layout, Rejected>> LayOutLand(const v1::SceneConfig& config,
                                                              SceneSeed seed,
                                                              const CancelToken& cancel) {
  const Rng root(seed, "nature");
  const v1::NatureConfig& nature = config.nature();
  ASSIGN_OR_RETURN(const Biome* biome, DrawBiome(nature.biomes(), root));
  ASSIGN_OR_RETURN(const TerrainSpec spec,
                   DrawLandform(biome->landform, root.Child("land").Child(biome->name)));
  v1::Layout layout;
  v1::Terrain& recipe = *layout.mutable_place()->mutable_terrain();
  recipe.set_biome(std::string(biome->name));
  SetTerrainSpec(spec, recipe);
  if (cancel.cancelled()) return absl::CancelledError("layout: cancelled");
  ASSIGN_OR_RETURN(const std::shared_ptr<const Terrain> terrain, TerrainOf(recipe));

  Rng season = root.Child("season");
  recipe.set_season(nature.seasons().empty() ? "summer" : season.Pick(nature.seasons()));
  const Rng rules = root.Child("rules").Child(biome->name);
  BiomeDraft draft{rules, recipe.season(), Draw(nature.density(), root.Child("density").Uniform()),
                   HeightsOf(*terrain), recipe};
  biome->write(draft);
  recipe.set_ground_object_index(kGroundIndex);
  RETURN_IF_ERROR(CheckRules(recipe));

  v1::SceneObject& ground = *layout.add_objects();
  ground.set_index(kGroundIndex);
  ground.set_name("Ground");
  ground.set_asset_class("Terrain");
  ground.set_part("ground");
  ground.set_role(v1::OBJECT_ROLE_TERRAIN);
  ground.mutable_world_from_object()->set_qw(1);
  ground.mutable_world_from_object()->set_scale(1);
  return std::variant<v1::Layout, Rejected>(std::move(layout));
}

}  // namespace parallax
