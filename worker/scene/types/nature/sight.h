// How far the frames of a landscape see its ground.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Returns the median distance, in metres along rays through a grid of pixels of the first, middle
// and last rig, at which the bare ground is met; plants and stones are not looked at. Rays that
// meet nothing within 6 km are left out; returns 6 km if none is left. Requires at least one rig.
double MedianSight(const Terrain& terrain, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs);

}  // namespace parallax
