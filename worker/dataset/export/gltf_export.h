// Exports a recipe as a .glb for any viewer: meshes, lights and all cameras.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Contents of an exported file beside the recipe's objects.
struct GltfContents {
  int64_t instances = 0;   // Things that the place's rules make.
  int64_t prototypes = 0;  // Their different meshes.
  int64_t triangles = 0;   // Different ones: an instance adds none.
};

// Writes one node an object, named as in the recipe; one node for each prototype of what grows and
// lies about, "prototype_000" and so on, placed by EXT_mesh_gpu_instancing with the object indices
// as the attribute _OBJECT_INDEX; materials as constant metallic-roughness values (averages over
// points of the surface, because glTF has no procedural textures; a landscape's ground has colours
// at its vertices); lights by KHR_lights_punctual; cameras "rig_000_left", "rig_000_right" and so
// on. A root node turns our z up into glTF's y up. Errors: as BuildSceneGeometry; writing as
// WriteFile.
absl::StatusOr<GltfContents> ExportGltf(const v1::Scene& scene, const std::string& glb_path);

}  // namespace parallax
