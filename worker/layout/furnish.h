// Furnishes one room: simulated annealing over the room's table, then small things on the
// furniture. Private to worker/layout.
#pragma once

#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/layout/anneal/arrangement.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/layout/anneal/fixtures.h"

namespace parallax {

// An object of the furnished room, world frame.
struct FurnishedObject {
  const PooledAsset* asset = nullptr;
  Vec3d position = Vec3d::Zero();
  double yaw_rad = 0;
  std::string relation;
  int parent = -1;  // Index of an earlier entry that carries it or to which it belongs.
  Vec3d lamp_power_w = Vec3d::Zero();
};

// Returns the problem that annealing solves: the room in its own frame and the rows of its table as
// this seed has them.
RoomProblem MakeRoomProblem(const v1::Room& room, const RoomTable& table,
                            const v1::AssetConfig& assets, SceneSeed seed);
// Returns the wishes of every household and of the table.
std::vector<Wish> WishesOf(const RoomTable& table);

// Returns all classes that rooms, fixtures or openings may use.
std::vector<std::string> PlacedClasses();

struct Furnishing {
  std::vector<FurnishedObject> objects;
  v1::SolveReport report;
};

// Furnishes `room`, which has its place in the house; results are in the world frame.
// Errors: kCancelled, those of the catalogue.
absl::StatusOr<Furnishing> Furnish(const v1::Room& room, const v1::SceneConfig& config,
                                   const std::vector<Fixture>& fixtures, SceneSeed seed,
                                   AssetPool& pool, const CancelToken& cancel);

}  // namespace parallax
