// The surface and material of a landscape's water.
#pragma once

#include <memory>

#include "parallax/v1/scene.pb.h"
#include "worker/materials/kernel/material.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Returns the material of a recipe's water: a smooth dielectric over a body that absorbs light,
// with the bed below it, and foam. The surface is opaque: the bed is painted on it, vertically
// above its place, so that pictures agree with ground truth, which is the surface. `bed` is the
// ground's material. Requires a terrain with water.
std::shared_ptr<const Material> MakeWaterSurface(const v1::Water& water,
                                                 std::shared_ptr<const Terrain> terrain,
                                                 std::shared_ptr<const Material> bed);

}  // namespace parallax
