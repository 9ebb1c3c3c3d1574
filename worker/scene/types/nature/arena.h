// The part of a land in which walks are looked for: its ground, trees, bushes and stones made
// solid.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/types/nature/expand.h"

namespace parallax {

// Everything of the layers with indices of their own within sight of `middle`, coarser with
// distance, on a coarse ground that reaches the horizon, which is body 0; body 1 is the water's
// surface, where there is water. Errors: as PrototypeMesh.
absl::StatusOr<std::unique_ptr<RayScene>> MakeArena(const v1::Terrain& recipe,
                                                    const Terrain& terrain, const Vec2f& middle);

// Everything of an expansion within `within_m` of an eye, as it is rendered. Errors: as
// PrototypeMesh.
absl::StatusOr<std::unique_ptr<RayScene>> MakeNearby(
    const v1::Terrain& recipe, const Expansion& expansion,
    const google::protobuf::RepeatedPtrField<v1::Rig>& rigs, float within_m);

}  // namespace parallax
