// Wishes: costs of an arrangement of furniture as small values that can be combined. Private to
// worker/layout.
//
//   Facing("sofa", "tv stand").Weight(4) + Distance("sofa", "tv stand", 1.8, 4.2)
//   Worst(SidesFree("bed"), Reachable())
//
// A wish costs 0 where it is fulfilled, and more the farther the arrangement is from that. The
// comment of each function that makes a wish says what it costs. It declares its dependencies
// (groups, and the part of the floor that it read), so that after a move only affected wishes are
// evaluated again (score.h). Wishes are constant: thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/math/types.h"
#include "worker/layout/anneal/footprint.h"

namespace parallax {

class Arrangement;

// The kinds of wishes, by which reports sum them.
enum class WishKind {
  kRelation,       // Distances, facing, sight.
  kFullness,       // Counts, how much of floor and walls is used.
  kAlignment,      // In line, square, centred.
  kFocus,          // Seats look at what the room is about.
  kAccessibility,  // People get to things and use them.
  kSymmetry,       // Pairs, seats around tables.
  kClutter,        // Slits, heaps, things before windows.
};
std::string_view NameOf(WishKind kind);

// The part of the floor that a wish read.
struct FloorRegion {
  Vec2d low = Vec2d::Constant(1e9), high = Vec2d::Constant(-1e9);
  void Add(const Vec2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void Add(const Footprint& f) {
    Add(f.center - f.Extent());
    Add(f.center + f.Extent());
  }
  bool Meets(const FloorRegion& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

// A named cost with a weight.
class Wish {
 public:
  // Computes the cost, and must add the part of the floor on which it depends to `seen`.
  using Cost = std::function<double(const Arrangement&, FloorRegion& seen)>;

  // `groups`: groups whose items affect the cost wherever they are; empty: all.
  Wish(std::string name, WishKind kind, std::vector<std::string> groups, Cost cost)
      : name_(std::move(name)), kind_(kind), groups_(std::move(groups)), cost_(std::move(cost)) {}

  Wish Weight(double weight) const {
    Wish wish = *this;
    wish.weight_ *= weight;
    return wish;
  }
  Wish Named(std::string name) const {
    Wish wish = *this;
    wish.name_ = std::move(name);
    return wish;
  }

  const std::string& name() const { return name_; }
  WishKind kind() const { return kind_; }
  const std::vector<std::string>& groups() const { return groups_; }
  double Of(const Arrangement& arrangement, FloorRegion& seen) const {
    return weight_ * cost_(arrangement, seen);
  }

 private:
  std::string name_;
  WishKind kind_;
  std::vector<std::string> groups_;
  Cost cost_;
  double weight_ = 1;
};

// Return a wish whose cost is the sum of both costs, the larger of both costs, and the cost of
// `wish` if the room has an item of the group, else 0.
Wish operator+(const Wish& a, const Wish& b);
Wish Worst(const Wish& a, const Wish& b);
Wish If(const std::string& group, const Wish& wish);

// ---- Relations between groups. Each item is related to the nearest of the other group.
// Angle between the item's front (+y) and the target, as 1 - cosine: 0 ahead, 2 behind.
Wish Facing(const std::string& group, const std::string& target);
// Amount by which the distance of the middles lies outside [least, most], metres.
Wish Distance(const std::string& group, const std::string& target, double least_m, double most_m);
// Shortfall of the gap between edges, metres.
Wish AwayFrom(const std::string& group, const std::string& target, double gap_m);
Wish AwayFromDoors(const std::string& group, double gap_m);
// Number of items that stand in the line of sight to the target.
Wish InView(const std::string& group, const std::string& target);
// 1 for each item whose back is before a window.
Wish NotBeforeWindow(const std::string& group);
// Metres along the wall to the nearest window's middle, up to 2.
Wish NearWindow(const std::string& group);
// 1 for each item at another wall than the nearest of the target.
Wish SameWall(const std::string& group, const std::string& target);

// ---- Accessibility.
// Occupied share of the floor that people need before each item (AssetClass::front_clearance_m).
Wish FrontFree(const std::string& group);
// Occupied share of the floor along both long sides; the freer side counts twice.
Wish SidesFree(const std::string& group);
// Shortfall of space between each item and the walls, and other things, metres.
Wish SpaceAround(const std::string& group, double wall_m, double thing_m);
// Share of the floor, on a grid, that can't be reached from the doors, and much more for each door
// that can't be reached from the others.
Wish Reachable();

// ---- Order.
// Seats should be even along the sides of their table, with equal numbers on opposite sides.
Wish EvenlyAround(const std::string& seats);
// Items beside the anchor: better one on each side than two on one.
Wish Symmetric(const std::string& group);
// Distance from the middle of the room's longest free axis, metres: for central tables.
Wish Central(const std::string& group);
// Items on one wall should touch or be well apart: no slits that gather dust.
Wish NoSlits();
// Hanging objects should be this far apart.
Wish Apart(const std::string& group, double apart_m);
// Sum of the differences in height between the middles of objects that hang on one wall, metres.
Wish LevelHeights(const std::string& group);

// ---- Fullness.
// Excess of the floor's furnished share outside [least, most].
Wish FloorShare(double least, double most);
// Length of wall beyond `most_m` in one stretch without furniture, art or openings, metres.
Wish BareWalls(double most_m);

}  // namespace parallax
