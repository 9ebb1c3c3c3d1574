// Materials of walls, floors and ceilings by kind of room. Private to this folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "worker/materials/kernel/material.h"

namespace parallax {

enum class RoomSurface { kWall, kFloor, kCeiling };

// Materials for a surface; more frequent ones are listed several times. Never empty: kinds without
// a table get all materials that the catalogue tags for the surface.
std::vector<const MaterialClass*> RoomMaterials(std::string_view room_kind, RoomSurface surface);

}  // namespace parallax
