// Meshes of a room's architecture, made from the recipe's Room: walls with openings, floor,
// ceiling, skirting, door leaves, window frames. Each part is one object of the recipe
// (SceneObject.part).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Names of all parts of this room in a fixed order: "floor", "ceiling", "walls", "skirting", what
// else it has of "cornice", "pillars", "stairs", then "door_0", "window_0", "passage_0"... A door
// between two rooms is a part of one of them (Opening.mated).
std::vector<std::string> RoomParts(const v1::Room& room);

// The mesh of one part, world frame. Errors: kNotFound for a part that the room does not have.
absl::StatusOr<Mesh> MakeRoomPart(const v1::Room& room, std::string_view part);

// Classes of the catalogue that parts are made of: leaves of doors, windows, stairs.
std::vector<std::string> BuildingClasses();
// The class that a part is shown as: "PanelDoor", "Window", "UShapedStaircase", "Walls"...
std::string ClassOfPart(const v1::Room& room, std::string_view part);

// Which room of the house an object of the recipe belongs to, by SceneObject.index.
int RoomIndexOf(const v1::House& house, uint32_t object_index);
// The mesh of the part that an object of the recipe is. Errors: those above.
absl::StatusOr<Mesh> MakeRoomPart(const v1::House& house, const v1::SceneObject& object);

}  // namespace parallax
