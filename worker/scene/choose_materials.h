// The dressing step that chooses all materials. Private to worker/scene and worker/catalogue.
#pragma once

#include <functional>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"
#include "worker/scene/palettes.h"

namespace parallax {

// Returns the SceneMaterial.index for a slot of a part of the place.
using PartMaterialFn = std::function<uint32_t(const v1::SceneObject& part, const MaterialSlot& slot,
                                              Palettes& palettes)>;

// Binds a material to every slot of every object as the config says, except for parts of the place,
// whose materials `part_material` chooses (never called for places without parts). Errors:
// kInvalidArgument for an unknown material.
absl::Status ChooseMaterials(const v1::MaterialConfig& config, const PartMaterialFn& part_material,
                             SceneInProgress& scene);

}  // namespace parallax
