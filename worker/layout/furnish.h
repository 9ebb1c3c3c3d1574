// Furniture of one room: simulated annealing over the room's table, then small things on what
// stands there. Private to worker/layout.
#pragma once

#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/layout/arrangement.h"
#include "worker/layout/asset_pool.h"
#include "worker/layout/fixtures.h"

namespace parallax {

struct FurnishedObject {
  const PooledAsset* asset = nullptr;
  Vec3d position = Vec3d::Zero();
  double yaw_rad = 0;
  std::string relation;
  int parent = -1;  // Earlier entry that it stands on or belongs to.
  Vec3d lamp_power_w = Vec3d::Zero();
};

// The problem that annealing solves: the room in its own frame and the rows of its table as this
// seed has them.
RoomProblem MakeRoomProblem(const v1::Room& room, const RoomTable& table,
                            const v1::AssetConfig& assets, SceneSeed seed);
// HouseholdWishes and the table's own.
std::vector<Wish> WishesOf(const RoomTable& table);

// Every class that some room, fixture or opening has a place for.
std::vector<std::string> PlacedClasses();

struct Furnishing {
  std::vector<FurnishedObject> objects;
  v1::SolveReport report;
};

// `room` as it stands in the house; what comes back is placed in the world.
// Errors: kCancelled, those of the catalogue.
absl::StatusOr<Furnishing> Furnish(const v1::Room& room, const v1::SceneConfig& config,
                                   const std::vector<Fixture>& fixtures, SceneSeed seed,
                                   AssetPool& pool, const CancelToken& cancel);

}  // namespace parallax
