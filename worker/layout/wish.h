// The language of wishes: what makes an arrangement of furniture good, as small values that are
// combined. Private to worker/layout.
//
//   Facing("sofa", "tv stand").Weight(4) + Distance("sofa", "tv stand", 1.8, 4.2)
//   Worst(SidesFree("bed"), Reachable())
//
// A wish costs 0 where it is fulfilled and grows with how far it is from that. It says what it
// depends on (groups, and the part of the floor that it looked at), so that a move has only those
// worked out anew that it touches (score.h). Wishes are constant: thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/math/types.h"
#include "worker/layout/footprint.h"

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

// The part of the floor that a wish looked at.
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

class Wish {
 public:
  // `seen` is to be grown by whatever part of the floor the cost depends on.
  using Cost = std::function<double(const Arrangement&, FloorRegion& seen)>;

  // `groups`: whose items the cost depends on wherever they are; empty = on all.
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

// Both; the dearer of two; nothing unless the room has an item of the group.
Wish operator+(const Wish& a, const Wish& b);
Wish Worst(const Wish& a, const Wish& b);
Wish If(const std::string& group, const Wish& wish);

// ---- Relations between groups. Each item is held to the nearest of the other group.
// Its front (+y) turned to the target: 0 ahead .. 2 behind.
Wish Facing(const std::string& group, const std::string& target);
// Metres outside of [least, most], between middles.
Wish Distance(const std::string& group, const std::string& target, double least_m, double most_m);
// Metres lacking between edges.
Wish AwayFrom(const std::string& group, const std::string& target, double gap_m);
Wish AwayFromDoors(const std::string& group, double gap_m);
// How many things stand in the line of sight.
Wish InView(const std::string& group, const std::string& target);
// 1 for each item whose back is before a window.
Wish NotBeforeWindow(const std::string& group);
// Metres along the wall to the nearest window's middle, up to 2.
Wish NearWindow(const std::string& group);
// 1 for each item at another wall than the nearest of the target.
Wish SameWall(const std::string& group, const std::string& target);

// ---- Accessibility.
// Share of the floor that people need before each item (AssetClass::front_clearance_m) that is
// taken.
Wish FrontFree(const std::string& group);
// Share of both long sides that is taken; the freer side counts twice.
Wish SidesFree(const std::string& group);
// Metres lacking between each item and the walls, and from other things.
Wish SpaceAround(const std::string& group, double wall_m, double thing_m);
// Share of the floor that cannot be reached from the doors, on a grid, and far more for each door
// that cannot be reached from the others.
Wish Reachable();

// ---- Order.
// Seats evenly along the sides of what they stand around, as many on opposite sides.
Wish EvenlyAround(const std::string& seats);
// Items beside the anchor: one on each side rather than two on one.
Wish Symmetric(const std::string& group);
// Metres from the middle of the room's longest free axis: tables that stand central.
Wish Central(const std::string& group);
// Items on one wall stand edge to edge or well apart: no slits that gather dust.
Wish NoSlits();
// Hanging things keep this distance.
Wish Apart(const std::string& group, double apart_m);
// Middles of hanging things at one height.
Wish LevelHeights(const std::string& group);

// ---- Fullness.
// Share of the floor under furniture outside of [least, most].
Wish FloorShare(double least, double most);
// Metres of wall beyond `most_m` in one stretch without furniture, art or openings.
Wish BareWalls(double most_m);

}  // namespace parallax
