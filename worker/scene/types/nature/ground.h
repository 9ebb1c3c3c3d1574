// The ground's material: materials by rules, blended where their masks are soft.
#pragma once

#include <memory>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/materials/material.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Assigns slots "rule_0", "rule_1"... to the ground's triangles, by the strongest rule of each.
void AssignGroundSlots(const v1::Terrain& recipe, const Terrain& terrain, Mesh& mesh);

// Makes one material of all rules, in the order of recipe.ground(): each covers the ones before it
// as thickly as its mask says, with ragged borders. The last rule is bare rock, in ledges and beds.
std::shared_ptr<const Material> MakeGroundMaterial(
    const v1::Terrain& recipe, std::shared_ptr<const Terrain> terrain,
    std::vector<std::shared_ptr<const Material>> materials);

}  // namespace parallax
