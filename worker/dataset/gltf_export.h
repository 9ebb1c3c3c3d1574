// A recipe as a .glb that any viewer opens: meshes, lights and all cameras.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// One node an object, named as in the recipe; materials as constant metallic-roughness values
// (averages over points of the surface: glTF has no procedural textures); lights by
// KHR_lights_punctual; cameras "rig_000_left", "rig_000_right" and so on. glTF's y is up: a root
// node turns our z up into it. Errors: as BuildSceneGeometry; writing as WriteFile.
absl::Status ExportGltf(const v1::Scene& scene, const std::string& glb_path);

}  // namespace parallax
