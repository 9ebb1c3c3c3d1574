// Exports a recipe as a .glb for any viewer: meshes, lights and all cameras.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Writes one node an object, named as in the recipe; materials as constant metallic-roughness
// values (averages over points of the surface, because glTF has no procedural textures); lights by
// KHR_lights_punctual; cameras "rig_000_left", "rig_000_right" and so on. A root node turns our z
// up into glTF's y up. Errors: as BuildSceneGeometry; writing as WriteFile.
absl::Status ExportGltf(const v1::Scene& scene, const std::string& glb_path);

}  // namespace parallax
