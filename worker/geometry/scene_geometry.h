// A recipe's geometry: every object's mesh, placed, with its materials, and the surroundings. Plain
// data; BuildSceneGeometry (worker/scene) makes it.
#pragma once

#include <memory>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"
#include "worker/geometry/surroundings.h"

namespace parallax {

class Material;  // worker/materials

// One object of the recipe.
struct PlacedMesh {
  std::shared_ptr<const Mesh> mesh;  // Shared by objects of equal class and seed.
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
  uint32_t object_index = 0;               // SceneObject.index
  std::vector<uint32_t> material_of_slot;  // SceneMaterial.index by Mesh::slots; 0 = none bound.
};

// A mesh that is placed many times.
struct Prototype {
  std::shared_ptr<const Mesh> mesh;
  std::vector<uint32_t> material_of_slot;  // As PlacedMesh's.
};

// One placement of a prototype, in 56 bytes: landscapes have a hundred thousand.
struct Instance {
  Eigen::Matrix<float, 3, 4, Eigen::DontAlign> world_from_object;
  uint32_t prototype = 0;     // Into SceneGeometry::prototypes.
  uint32_t object_index = 0;  // The value of objects_*.png.

  Eigen::Affine3f Affine() const {
    Eigen::Affine3f affine = Eigen::Affine3f::Identity();
    affine.matrix().topRows<3>() = world_from_object;
    return affine;
  }
};
static_assert(sizeof(Instance) == 56);

// Constant once made; shared by everything that reads a scene.
struct SceneGeometry {
  std::vector<PlacedMesh> meshes;  // In order of the recipe's objects.
  // In addition: geometry made by the place's rules.
  std::vector<Prototype> prototypes;
  std::vector<Instance> instances;
  std::vector<std::shared_ptr<const Material>> materials;  // By SceneMaterial.index; [0] is null.
  Surroundings surroundings;
};

}  // namespace parallax
