// Draws the empty house: the rooms with their places, the doors between them, the windows. Private
// to worker/layout.
//
// Rooms are rectangles that share walls. The main room (index 0) has exactly the size that the
// config draws and its inner corner at the world's origin; the others are placed around it by
// annealing over adjacency, areas, shapes and compactness (floor_plan.h).
#pragma once

#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// The rooms of a house, in world coordinates.
struct House {
  std::vector<v1::Room> rooms;  // The main room first.
  v1::SolveReport report;       // Solving the floor plan; empty for a single room.
};

// Draws a house. The result depends only on (config, seed). Openings that find no free stretch of
// wall are left out; every room can be reached from the main one.
// Errors: kInvalidArgument for an unknown kind of room, or for a room smaller than 1.5 m x 1.5 m x
// 1.9 m.
absl::StatusOr<House> DrawHouse(const v1::RoomConfig& config, SceneSeed seed);

}  // namespace parallax
