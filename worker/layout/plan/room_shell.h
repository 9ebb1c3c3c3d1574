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

// Returns the names of all parts of this room in a fixed order: "floor", "ceiling", "walls",
// "skirting", those of "cornice", "pillars", "stairs" that it has, then "door_0", "window_0",
// "passage_0"... A door between two rooms is a part of only one of them (Opening.mated).
std::vector<std::string> RoomParts(const v1::Room& room);

// Returns the mesh of one part, world frame. Errors: kNotFound for a part that the room does not
// have.
absl::StatusOr<Mesh> MakeRoomPart(const v1::Room& room, std::string_view part);

// Classes of the catalogue that are used for parts: leaves of doors, windows, stairs.
std::vector<std::string> BuildingClasses();
// Returns the class by which a part is known: "PanelDoor", "Window", "UShapedStaircase", "Walls"...
std::string ClassOfPart(const v1::Room& room, std::string_view part);

// Returns the index of the room in the house to which an object belongs, by SceneObject.index.
int RoomIndexOf(const v1::House& house, uint32_t object_index);
// Returns the mesh of an object that is a part of a room. Errors: those above.
absl::StatusOr<Mesh> MakeRoomPart(const v1::House& house, const v1::SceneObject& object);

}  // namespace parallax
