// The ground's material: materials by rules, blended where their masks are soft.
#pragma once

#include <memory>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/materials/kernel/material.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Assigns slots "rule_0", "rule_1"... to the ground's triangles, by the strongest rule of each.
void AssignGroundSlots(const v1::Terrain& recipe, const Terrain& terrain, Mesh& mesh);

// The patches that a rule of the ground lays.
struct GroundCover {
  std::shared_ptr<const Material> material;
  bool frozen = false;  // Snow or ice: it does not take the land's tone, which differs by place.
};

// Makes one material of all rules, in the order of recipe.ground(), `covers` one a rule: each
// covers the ones before it as thickly as its mask says, with ragged borders. The last rule is bare
// rock, in ledges and beds.
std::shared_ptr<const Material> MakeGroundMaterial(const v1::Terrain& recipe,
                                                   std::shared_ptr<const Terrain> terrain,
                                                   std::vector<GroundCover> covers);

}  // namespace parallax
