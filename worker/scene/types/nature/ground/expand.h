// Expands a recipe's rules into geometry: the ground's mesh and every instance on it.
//
// Pure: the same recipe (terrain and rigs) gives the same expansion on any number of threads. The
// recipe stores its hash.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/scene/types/nature/ground/roof.h"
#include "worker/scene/types/nature/ground/scatter.h"
#include "worker/terrain/ground_mesh.h"

namespace parallax {

// Identifies a mesh that instances use.
struct ShapeKey {
  uint32_t prototype = 0;  // Into v1::Terrain.prototypes.
  uint32_t shape = 0;
  PlantDetail detail = PlantDetail::kNear;
  auto operator<=>(const ShapeKey&) const = default;
};

// Everything that a recipe's rules make.
struct Expansion {
  std::shared_ptr<const Terrain> terrain;
  GroundMesh ground;
  std::shared_ptr<const Mesh> water;     // nullptr: none.
  std::shared_ptr<const CaveRoof> roof;  // Null: under the open sky.
  std::vector<ShapeKey> shapes;          // Instance::prototype is an index into them.
  // In order of layers; their object indices count from their layer's first.
  std::vector<Instance> instances;
  std::vector<uint32_t> of_layer;  // Number of instances by layer.
  std::vector<uint32_t> indices;   // Number of object indices by layer.
  uint64_t hash = 0;
};

// Expands a recipe that has its rigs. The process remembers the newest expansion. Thread-safe.
// Where the views want more than kMostInstances, things without an index each are thinned evenly.
// Errors: kInvalidArgument for a recipe that breaks the rules' bounds or has no rigs; kOutOfRange
// for more things with an index each than kMostInstances, for more than kMostWanted in all, and as
// Scatter::Place.
absl::StatusOr<std::shared_ptr<const Expansion>> ExpandTerrain(
    const v1::Terrain& recipe, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs);
inline constexpr size_t kMostInstances = 250'000, kMostWanted = 4'000'000;
// Things without an index each stay out of a tube about the way of both eyes: of this radius, or of
// Terrain.clearance_m where that is larger.
inline constexpr float kLeastTube_m = 0.4f;

// Makes the meshes of shapes, on several threads. Errors: as PrototypeMesh.
absl::StatusOr<std::vector<std::shared_ptr<const Mesh>>> MeshesOf(
    const v1::Terrain& recipe, const std::vector<ShapeKey>& shapes);

// The pose of an object on the ground: its base below the ground all around, turned, leaning with
// the slope. Floating objects lie level on still water where the ground is lower.
Eigen::Matrix<float, 3, 4> PlaceOf(const v1::ScatterLayer& layer, const Standing& thing,
                                   const GroundMesh& ground, const Terrain& terrain);

// The pose of an object that hangs from a roof, its base in the rock; nothing where there is no
// roof.
std::optional<Eigen::Matrix<float, 3, 4>> PlaceUnder(const v1::ScatterLayer& layer,
                                                     const Standing& thing, const CaveRoof& roof);

// The roof of a recipe, or null if it has none. `cell_m`: spacing of its vertices.
std::shared_ptr<const CaveRoof> RoofOf(const v1::Terrain& recipe, const Terrain& terrain,
                                       float cell_m);

// The level of detail of a layer's objects at this distance from the eyes.
PlantDetail DetailAt(const v1::ScatterLayer& layer, float distance_m, float focal_px);

// Numbers the layers' objects from `first` on, by the counts of the expansion.
void NumberLayers(const Expansion& expansion, uint32_t first, v1::Terrain& recipe);

}  // namespace parallax
