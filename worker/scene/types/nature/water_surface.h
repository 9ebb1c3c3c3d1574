// The surface and material of a landscape's water.
#pragma once

#include <memory>

#include "parallax/v1/scene.pb.h"
#include "worker/materials/material.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// The surface of a recipe's water: a smooth dielectric over a body that shows its bed as far as
// light comes back from there, and foam. Opaque: the bed is drawn on the surface, straight above
// where it lies, so that pictures agree with ground truth, which is the surface. `bed`: the
// ground's material. Requires that terrain has water.
std::shared_ptr<const Material> MakeWaterSurface(const v1::Water& water,
                                                 std::shared_ptr<const Terrain> terrain,
                                                 std::shared_ptr<const Material> bed);

}  // namespace parallax
