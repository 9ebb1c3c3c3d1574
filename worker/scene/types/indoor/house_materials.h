// Materials of a house. Private to this folder.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/scene/palettes.h"

namespace parallax {

// Returns the material of a slot of a part: walls, floor and so on. A room has one material for
// each slot name; joinery is the same in the whole house, walls and floors depend on the kind of
// room. Returns SceneMaterial.index.
uint32_t HousePartMaterial(const v1::House& house, const v1::SceneObject& object,
                           const MaterialSlot& slot, Palettes& palettes);

}  // namespace parallax
