// The step of dressing that says what everything is made of. Private to worker/scene and to
// worker/catalogue.
#pragma once

#include <functional>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"
#include "worker/scene/palettes.h"

namespace parallax {

// SceneMaterial.index for a slot of a part of the place.
using PartMaterialFn = std::function<uint32_t(const v1::SceneObject& part, const MaterialSlot& slot,
                                              Palettes& palettes)>;

// Binds a material to every slot of every object: as the config says, but for parts of the place,
// which `part_material` decides about (never called where there are none).
// Errors: kInvalidArgument for an unknown material.
absl::Status ChooseMaterials(const v1::MaterialConfig& config, const PartMaterialFn& part_material,
                             SceneInProgress& scene);

}  // namespace parallax
