#include "worker/scene/types/nature/nature.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/status.h"
#include "worker/scene/types/nature/ground/expand.h"
#include "worker/scene/types/nature/ground/ground.h"
#include "worker/scene/types/nature/ground/prototypes.h"
#include "worker/scene/types/nature/ground/water_surface.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

absl::StatusOr<Mesh> LandPart(const v1::Scene& scene, const v1::SceneObject& object) {
  const v1::Terrain& land = scene.place().terrain();
  const bool water = object.part() == "water" && land.has_water();
  const bool roof = object.part() == "roof" && land.has_roof();
  if (object.part() != "ground" && !water && !roof) {
    return NotFound("a landscape has no part \"{}\"", object.part());
  }
  if (!water && !roof) return GroundPart(land, scene.rigs());
  ASSIGN_OR_RETURN(const auto expansion, ExpandTerrain(land, scene.rigs()));
  return water ? *expansion->water : expansion->roof->mesh();
}

// Its ground reaches the horizon.
Surroundings LandSurroundings(const v1::Place& place) {
  Surroundings around;
  around.ground_below_horizon = false;
  if (!place.terrain().has_roof() || !CheckRules(place.terrain()).ok()) return around;
  const auto terrain = TerrainOf(place.terrain());
  if (terrain.ok()) around.enclosures.push_back(EnclosureUnder(place.terrain(), **terrain));
  return around;
}

// Whether a material of the scene is snow or ice.
bool IsFrozen(const v1::Scene& scene, uint32_t index) {
  static constexpr std::array<std::string_view, 3> kFrozen = {"Snow", "PackedSnow", "SeaIce"};
  const auto is_frozen = [&](const v1::SceneMaterial& material) {
    return material.index() == index &&
           std::find(kFrozen.begin(), kFrozen.end(), material.material_class()) != kFrozen.end();
  };
  return std::any_of(scene.materials().begin(), scene.materials().end(), is_frozen);
}

std::string Hex(uint64_t number) { return fmt::format("{:016x}", number); }

absl::Status ExpandLand(const v1::Scene& scene, SceneGeometry& geometry) {
  return GrowLand(scene, scene.place().terrain(), scene.rigs(), geometry);
}

std::optional<v1::SceneObject> GrownObject(const v1::Scene& scene, uint32_t index) {
  return GrownThing(scene.place().terrain(), index);
}

// Returns the costs of an average scene of the config's mix of biomes. nature_table.py measured 3.0
// to 4.8 core-seconds for both stages together.
SceneCosts LandCosts(const v1::SceneConfig& config) {
  SceneCosts costs{.layout_s = 2, .dress_s = 2, .rigs_share_light = true, .build_s = 4};
  double sum = 0, times = 0;
  for (const WeightedBiome& row : BiomesOf(config.nature())) {
    sum += row.weight;
    times += row.weight * (row.biome->has_trace_times() ? row.biome->trace_times() : 1);
  }
  if (sum > 0) costs.trace_times = times / sum;
  return costs;
}

}  // namespace

absl::StatusOr<Mesh> GroundPart(const v1::Terrain& land,
                                const google::protobuf::RepeatedPtrField<v1::Rig>& views) {
  ASSIGN_OR_RETURN(const auto expansion, ExpandTerrain(land, views));
  Mesh mesh = expansion->ground.mesh();
  AssignGroundSlots(land, *expansion->terrain, mesh);
  return mesh;
}

absl::Status GrowLand(const v1::Scene& scene, const v1::Terrain& land,
                      const google::protobuf::RepeatedPtrField<v1::Rig>& views,
                      SceneGeometry& geometry) {
  ASSIGN_OR_RETURN(const auto expansion, ExpandTerrain(land, views));
  if (land.expansion_hash() != expansion->hash) {
    return Internal(
        "terrain: this worker's expansion is {}, the recipe was made with {}; it would show "
        "something else",
        Hex(expansion->hash), Hex(land.expansion_hash()));
  }
  std::vector<GroundCover> covers;
  for (const v1::GroundRule& rule : land.ground()) {
    const uint32_t index = rule.material_index();
    if (index >= geometry.materials.size() || geometry.materials[index] == nullptr) {
      return InvalidArgument("terrain: a ground rule has missing material {}", index);
    }
    covers.push_back({geometry.materials[index], IsFrozen(scene, index)});
  }
  const auto blend = MakeGroundMaterial(land, expansion->terrain, std::move(covers));
  for (const v1::GroundRule& rule : land.ground()) {
    geometry.materials[rule.material_index()] = blend;
  }
  if (land.has_water()) {
    const uint32_t index = land.water().material_index();
    if (index == 0 || index >= geometry.materials.size()) {
      return InvalidArgument("terrain: water has missing material {}", index);
    }
    geometry.materials[index] = MakeWaterSurface(land.water(), expansion->terrain, blend);
  }
  ASSIGN_OR_RETURN(const auto meshes, MeshesOf(land, expansion->shapes));
  for (size_t shape = 0; shape < meshes.size(); ++shape) {
    const v1::Prototype& prototype =
        land.prototypes(static_cast<int>(expansion->shapes[shape].prototype));
    Prototype& made = geometry.prototypes.emplace_back();
    made.mesh = meshes[shape];
    made.material_of_slot.resize(made.mesh->slots.size(), 0);
    for (const v1::MaterialBinding& binding : prototype.materials()) {
      for (size_t i = 0; i < made.mesh->slots.size(); ++i) {
        if (made.mesh->slots[i].name == binding.slot()) {
          made.material_of_slot[i] = binding.material_index();
        }
      }
    }
  }
  geometry.instances = expansion->instances;
  auto instance = geometry.instances.begin();
  for (int layer = 0; layer < land.layers_size(); ++layer) {
    const uint32_t first = land.layers(layer).first_object_index();
    for (uint32_t i = 0; i < expansion->of_layer[static_cast<size_t>(layer)]; ++i) {
      (instance++)->object_index += first;
    }
  }
  return absl::OkStatus();
}

std::optional<v1::SceneObject> GrownThing(const v1::Terrain& land, uint32_t index) {
  for (const v1::ScatterLayer& layer : land.layers()) {
    const uint32_t first = layer.first_object_index();
    if (index < first || index - first >= layer.indices()) continue;
    const uint32_t place = index - first;
    const int which = layer.index_each() ? 0 : static_cast<int>(place);
    if (which >= layer.prototypes_size()) return std::nullopt;
    const auto at = static_cast<int>(layer.prototypes(which));
    if (at >= land.prototypes_size()) return std::nullopt;
    const v1::Prototype& prototype = land.prototypes(at);
    v1::SceneObject object;
    object.set_index(index);
    object.set_name(fmt::format("{}_{}", layer.name(), place));
    object.set_asset_class(CatalogueClass(prototype));
    object.set_seed(prototype.seed());
    object.set_role(prototype.role());
    return object;
  }
  return std::nullopt;
}

const SceneType kNatureScenes = {
    .type = v1::SCENE_TYPE_NATURE,
    .place = v1::Place::kTerrain,
    .layout = &LayOutLand,
    .rigs = &PlaceWalkRigs,
    .dress = &DressLand,
    .part = &LandPart,
    .surroundings = &LandSurroundings,
    .costs = &LandCosts,
    .describe = &DescribeLand,
    .expand = &ExpandLand,
    .grown = &GrownObject,
    .map = &DescribeMap,
};

}  // namespace parallax
