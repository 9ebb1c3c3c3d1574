// Own meshes that replace the catalogue's furniture. Private to worker/scene.
#pragma once

#include "common/base/status.h"
#include "worker/scene/dress.h"

namespace parallax {

// Replaces furniture of a class C by a mesh of "own:C", if there is one, with probability
// `config.include_p`; each object draws from its own address. The mesh keeps the direction of the
// replaced object and is scaled uniformly to fit its bounding box: centred over its footprint on
// the floor, or against its wall. Objects that carry others or give light stay. Errors: those of
// MakeAsset.
absl::Status PutOwnFurniture(const v1::AssetConfig& config, SceneInProgress& scene);

}  // namespace parallax
