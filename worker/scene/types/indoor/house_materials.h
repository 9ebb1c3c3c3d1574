// Materials of a house. Private to this folder.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/scene/palettes.h"

namespace parallax {

// Walls, floor and so on: one material for each slot name in a room. Joinery is alike in the whole
// house; what walls and floors are made of goes by the kind of room. Returns SceneMaterial.index.
uint32_t HousePartMaterial(const v1::House& house, const v1::SceneObject& object,
                           const MaterialSlot& slot, Palettes& palettes);

}  // namespace parallax
