// Positions of a room's furniture, as variables that moves draw (wall, place along it) and values
// derived from them (positions, footprints); and the hard constraints: items lie in the room,
// overlap nothing, and leave doors and windows free.
//
// An Arrangement is a value: a move copies it, changes it, and keeps or drops the copy. Private to
// worker/layout.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/scene.pb.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/layout/anneal/fixtures.h"
#include "worker/layout/anneal/footprint.h"
#include "worker/layout/anneal/room_table.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {

// A row of the room's table, with what was drawn for this seed.
struct WantedRow {
  RoomRow row;
  int wanted = 0;                    // Drawn between least and most.
  std::vector<std::string> classes;  // The allowed ones that exist.
};

// A part of the building in the room: a pillar, the stairs.
struct Obstacle {
  Footprint footprint;
  double bottom_m = 0, top_m = 0;
};

// The inputs of solving a room, which moves do not change.
struct RoomProblem {
  v1::Room room;  // In its own frame: the inner corner is the origin.
  std::vector<WallStrip> strips;
  std::vector<Obstacle> obstacles;
  std::vector<WantedRow> rows;
  std::array<WallFrame, 4> walls;
};

constexpr int kFixtureRow = -1;

// One piece of furniture or a fixture.
struct Item {
  int row = kFixtureRow;  // Index into RoomProblem::rows.
  const PooledAsset* asset = nullptr;
  Stand stand = Stand::kFree;  // The row's, or one that the row allows instead.
  int anchor = -1;             // Index of the item that it stands by; -1: none.
  // Drawn: wall, corner, side of the anchor or quarter turn; place along and across, in [0, 1]; a
  // small turn.
  int side = 0;
  double u = 0.5, v = 0.5;
  double turn_rad = 0;
  // Derived by Place.
  Vec3d position = Vec3d::Zero();
  double yaw_rad = 0;
  Footprint footprint;
  double bottom_m = 0, top_m = 0;
  // Cached result of whether its mesh overlaps its anchor's: it depends only on drawn values, not
  // on the anchor's position.
  struct AnchorMeeting {
    const PooledAsset *own = nullptr, *anchor = nullptr;
    int side = 0;
    double u = 0, v = 0, turn_rad = 0;
    bool meets = false;
  };
  mutable AnchorMeeting meeting;

  Eigen::Affine3f WorldFromObject() const {
    return Pose{position, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vec3d::UnitZ())), 1.0}
        .Affine();
  }
  Vec2d Front() const { return footprint.AxisY(); }
};

// All items of a room, with copy semantics.
class Arrangement {
 public:
  Arrangement(const RoomProblem& problem, const std::vector<Fixture>& fixtures);

  const RoomProblem& problem() const { return *problem_; }
  const std::vector<Item>& items() const { return items_; }
  Item& at(int i) { return items_[static_cast<size_t>(i)]; }
  const Item& at(int i) const { return items_[static_cast<size_t>(i)]; }
  int size() const { return static_cast<int>(items_.size()); }
  const RoomRow* RowOf(const Item& item) const;
  Stand StandOf(const Item& item) const { return item.stand; }
  int CountOf(int row) const;
  bool HasChild(int item, int row) const;

  // Appends the item; it is not placed yet.
  int Add(const Item& item);
  // Returns the item and all items that stand by it, directly or not.
  std::vector<int> WithDependants(int item) const;
  // Removes the item and all items that stand by it.
  void Remove(int item);
  // Derives the places of the item and of all items that stand by it. Returns false if one of them
  // does not fit.
  bool Place(int item);
  // Returns whether the item and all items that stand by it keep the hard constraints.
  bool Allowed(int item) const;
  // Returns the other items that overlap the item's place; nothing if walls or openings are in the
  // way.
  std::optional<std::vector<int>> InTheWayOf(int item) const;
  // Returns whether two items may overlap in plan: rugs under things, an item on top of the other.
  bool Exempt(const Item& a, const Item& b) const;
  bool IsRug(const Item& item) const;
  // Returns whether an object between two heights leaves doors free, and leaves `window_depth_m`
  // free in front of windows whose height it reaches.
  bool ClearOfOpenings(const Footprint& footprint, double bottom_m, double top_m,
                       double window_depth_m) const;

 private:
  bool PlaceOne(Item& item) const;
  bool PlaceByWall(Item& item, const RoomRow& row) const;
  bool PlaceByAnchor(Item& item, const RoomRow& row) const;
  bool PlaceOnTop(Item& item) const;
  bool PlaceOnWall(Item& item, const RoomRow& row) const;
  void Settle(Item& item, const Vec2d& origin, double yaw_rad, double z_m) const;
  bool ClearOfRoom(const Item& item) const;
  bool ClearOf(const Item& item, const Item& other) const;
  bool MeetsAnchor(const Item& item) const;

  const RoomProblem* problem_;
  std::vector<Item> items_;
};

// Returns the support to be used first: the largest with room above it. Null if none exists.
const SupportSurface* MainSupport(const PooledAsset& asset);

}  // namespace parallax
