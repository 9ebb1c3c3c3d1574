// Meshes of a room's architecture, made from the recipe's Room: walls with openings, floor,
// ceiling, skirting, door leaves, window frames. Each part is one object of the recipe
// (SceneObject.room_part).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Names of all parts of this room in a fixed order: "floor", "ceiling", "walls", "skirting",
// "door_0", "window_0"...
std::vector<std::string> RoomParts(const v1::Room& room);

// The mesh of one part, world frame. Errors: kNotFound for a part that the room does not have.
absl::StatusOr<Mesh> MakeRoomPart(const v1::Room& room, std::string_view part);

}  // namespace parallax
