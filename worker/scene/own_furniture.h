// Own meshes in place of the catalogue's furniture. Private to worker/scene.
#pragma once

#include "common/base/status.h"
#include "worker/scene/dress.h"

namespace parallax {

// Replaces furniture of a class C by a mesh of "own:C", where there is one, with chance
// `config.include_p`; each object draws from its own address. The mesh is turned as what it
// replaces and scaled as a whole, so that it fills that one's box as far as it goes: on the floor
// in the middle of its footprint, or at its wall. What carries or lights something stays. Errors:
// those of MakeAsset.
absl::Status PutOwnFurniture(const v1::AssetConfig& config, SceneInProgress& scene);

}  // namespace parallax
