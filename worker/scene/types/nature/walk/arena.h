// The part of a land in which walks are looked for: its ground, trees, bushes and stones made
// solid.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/types/nature/ground/expand.h"

namespace parallax {

// Makes the ground with everything of the layers that have object indices, within sight of `middle`
// and coarser with distance. Body 0 is a coarse ground out to the horizon; body 1 is the water's
// surface, if there is water. Errors: as PrototypeMesh and Scatter::Place.
absl::StatusOr<std::unique_ptr<RayScene>> MakeArena(const v1::Terrain& recipe,
                                                    const Terrain& terrain, const Vec2f& middle);

// Makes everything of an expansion within `within_m` of the way of both eyes in plan, as it is
// rendered. The right eye is where the rigs have it and everywhere up to `baseline_m`. Errors: as
// PrototypeMesh.
absl::StatusOr<std::unique_ptr<RayScene>> MakeNearby(
    const v1::Terrain& recipe, const Expansion& expansion,
    const google::protobuf::RepeatedPtrField<v1::Rig>& rigs, float within_m, float baseline_m = 0);

}  // namespace parallax
