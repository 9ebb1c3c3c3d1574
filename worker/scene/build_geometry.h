// From a recipe to meshes and materials.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/materials/kernel/material.h"

namespace parallax {

// Regenerates the meshes and materials of `scene`, which UpgradeScene must have upgraded, and asks
// its type for the surroundings. Equal recipes give equal bytes on every machine.
// Errors: kNotFound for an unknown class or part, kInvalidArgument for an unknown type, a place
// that is not the type's or a binding to a missing material, kResourceExhausted when the meshes
// outgrow MemoryLimit(), each naming the object.
absl::StatusOr<SceneGeometry> BuildSceneGeometry(const v1::Scene& scene);

}  // namespace parallax
