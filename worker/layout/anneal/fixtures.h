// The room's own lamps, on the ceiling and on the floor. They do not depend on the furniture, so a
// room is lit equally with and without it. Private to worker/layout.
#pragma once

#include <string>
#include <vector>

#include "common/base/ids.h"
#include "common/math/types.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/layout/anneal/asset_pool.h"

namespace parallax {

// A lamp of the room.
struct Fixture {
  const PooledAsset* asset = nullptr;
  Vec3d position = Vec3d::Zero();  // World.
  double yaw_rad = 0;
  std::string relation;
  Vec3d power_w = Vec3d::Zero();  // Radiant flux, linear RGB.
};

// Draws and places the lamps. Errors: those of the catalogue.
absl::StatusOr<std::vector<Fixture>> PlaceFixtures(const v1::Room& room,
                                                   const v1::AssetConfig& assets, SceneSeed seed,
                                                   AssetPool& pool);

// Returns whether the catalogue has the class and the config allows it.
bool ClassAllowed(const v1::AssetConfig& assets, const std::string& class_name);

// Returns the linear colour of a lamp between a warm bulb (`whiteness` 0) and neutral white (1),
// scaled to a mean of 1.
Vec3d LampColor(double whiteness);

// The strip in front of a door or passage, or below a window, that tall objects must leave free: x
// along the wall, y into the room.
struct WallStrip {
  int wall = 0;
  double low_m = 0, high_m = 0;  // Wall frame.
  double sill_m = 0;
  double top_m = 0;
  bool door = false;
};
// Returns all strips of a room, wall by wall.
std::vector<WallStrip> StripsOf(const v1::Room& room);

}  // namespace parallax
