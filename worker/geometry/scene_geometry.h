// A recipe made solid: every object's mesh, placed, with its materials, and what surrounds them.
// Plain data; BuildSceneGeometry (worker/scene) makes it.
#pragma once

#include <memory>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"
#include "worker/geometry/surroundings.h"

namespace parallax {

class Material;  // worker/materials

struct PlacedMesh {
  std::shared_ptr<const Mesh> mesh;  // Shared by objects of equal class and seed.
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
  uint32_t object_index = 0;               // SceneObject.index
  std::vector<uint32_t> material_of_slot;  // SceneMaterial.index by Mesh::slots; 0 = none bound.
};

// Constant once made; shared by everything that reads a scene.
struct SceneGeometry {
  std::vector<PlacedMesh> meshes;                          // In order of the recipe's objects.
  std::vector<std::shared_ptr<const Material>> materials;  // By SceneMaterial.index; [0] is null.
  Surroundings surroundings;
};

}  // namespace parallax
