// A recipe made solid: every object's mesh, placed, with its materials.
#pragma once

#include <memory>
#include <vector>

#include "common/base/status.h"
#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/materials/material.h"

namespace parallax {

struct PlacedMesh {
  std::shared_ptr<const Mesh> mesh;  // Shared by objects of equal class and seed.
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
  uint32_t object_index = 0;               // SceneObject.index
  std::vector<uint32_t> material_of_slot;  // SceneMaterial.index by Mesh::slots; 0 = none bound.
};

// Constant after BuildSceneGeometry; shared by everything that reads a scene.
struct SceneGeometry {
  std::vector<PlacedMesh> meshes;                          // In order of the recipe's objects.
  std::vector<std::shared_ptr<const Material>> materials;  // By SceneMaterial.index; [0] is null.
};

// Errors: kNotFound for an unknown class or room part, kInvalidArgument for a binding to a missing
// material, kResourceExhausted when the meshes outgrow MemoryLimit(), each naming the object.
absl::StatusOr<SceneGeometry> BuildSceneGeometry(const v1::Scene& scene);

}  // namespace parallax
