// The wishes with which the tables of rooms are written.
#include <algorithm>
#include <cmath>
#include <map>

#include "worker/layout/anneal/measures.h"
#include "worker/layout/anneal/wish.h"

namespace parallax {

Wish Facing(const std::string& group, const std::string& target) {
  return Wish(group + " faces " + target, WishKind::kFocus, {group, target},
              [=](const Arrangement& a, FloorRegion&) {
                return OverPairs(a, group, target, [](int, const Item& p, int, const Item& q) {
                  const Vec2d to = q.footprint.center - p.footprint.center;
                  return to.norm() < 1e-6 ? 0.0 : 1 - to.dot(p.Front()) / to.norm();
                });
              });
}

Wish Distance(const std::string& group, const std::string& target, double least_m, double most_m) {
  return Wish(group + " at its distance from " + target, WishKind::kRelation, {group, target},
              [=](const Arrangement& a, FloorRegion&) {
                return OverPairs(a, group, target, [&](int, const Item& p, int, const Item& q) {
                  const double d = (q.footprint.center - p.footprint.center).norm();
                  return std::max(0.0, least_m - d) + std::max(0.0, d - most_m);
                });
              });
}

Wish AwayFrom(const std::string& group, const std::string& target, double gap_m) {
  return Wish(group + " away from " + target, WishKind::kRelation, {group, target},
              [=](const Arrangement& a, FloorRegion&) {
                return OverPairs(a, group, target, [&](int, const Item& p, int, const Item& q) {
                  return std::max(0.0, gap_m - GapBetween(p.footprint, q.footprint));
                });
              });
}

Wish AwayFromDoors(const std::string& group, double gap_m) {
  return Wish(group + " away from doors", WishKind::kAccessibility, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                ForGroup(a, group, [&](int, const Item& item) {
                  for (const WallStrip& strip : a.problem().strips) {
                    if (!strip.door) continue;
                    const WallFrame& wall = a.problem().walls[static_cast<size_t>(strip.wall)];
                    const Footprint zone = {wall.At((strip.low_m + strip.high_m) / 2, 0.1),
                                            {(strip.high_m - strip.low_m) / 2, 0.1},
                                            wall.yaw_rad};
                    cost += std::max(0.0, gap_m - GapBetween(item.footprint, zone));
                  }
                });
                return cost;
              });
}

Wish InView(const std::string& group, const std::string& target) {
  return Wish(group + " sees " + target, WishKind::kFocus, {group, target},
              [=](const Arrangement& a, FloorRegion& seen) {
                return OverPairs(a, group, target, [&](int i, const Item& p, int k, const Item& q) {
                  seen.Add(p.footprint);
                  seen.Add(q.footprint);
                  return static_cast<double>(InTheWay(a, i, k));
                });
              });
}

Wish NotBeforeWindow(const std::string& group) {
  return Wish(group + " not before a window", WishKind::kClutter, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                ForGroup(a, group, [&](int, const Item& item) {
                  for (const WallStrip& strip : a.problem().strips) {
                    if (strip.door) continue;
                    const WallFrame& wall = a.problem().walls[static_cast<size_t>(strip.wall)];
                    const Footprint zone = {wall.At((strip.low_m + strip.high_m) / 2, 0.25),
                                            {(strip.high_m - strip.low_m) / 2, 0.25},
                                            wall.yaw_rad};
                    cost += Overlap(item.footprint, zone, 0.05);
                  }
                });
                return cost;
              });
}

Wish NearWindow(const std::string& group) {
  return Wish(group + " near a window", WishKind::kRelation, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                ForGroup(a, group, [&](int, const Item& item) {
                  double nearest = 2;
                  for (const WallStrip& strip : a.problem().strips) {
                    if (strip.door) continue;
                    const WallFrame& wall = a.problem().walls[static_cast<size_t>(strip.wall)];
                    const Vec2d at = wall.At((strip.low_m + strip.high_m) / 2, 0.3);
                    nearest = std::min(nearest, (item.footprint.center - at).norm());
                  }
                  cost += nearest;
                });
                return cost;
              });
}

Wish SameWall(const std::string& group, const std::string& target) {
  return Wish(group + " at the wall of " + target, WishKind::kAlignment, {group, target},
              [=](const Arrangement& a, FloorRegion&) {
                return OverPairs(a, group, target, [](int, const Item& p, int, const Item& q) {
                  return p.side == q.side ? 0.0 : 1.0;
                });
              });
}

Wish FrontFree(const std::string& group) {
  return Wish("space in front of " + group, WishKind::kAccessibility, {group},
              [=](const Arrangement& a, FloorRegion& seen) {
                double cost = 0;
                ForGroup(a, group, [&](int i, const Item&) { cost += FrontTaken(a, i, seen); });
                return cost;
              });
}

Wish SidesFree(const std::string& group) {
  return Wish("sides of " + group + " free", WishKind::kAccessibility, {group},
              [=](const Arrangement& a, FloorRegion& seen) {
                double cost = 0;
                ForGroup(a, group, [&](int i, const Item& item) {
                  seen.Add(item.footprint);
                  const double left = SideTaken(a, i, -1, seen), right = SideTaken(a, i, 1, seen);
                  cost += std::max(left, right) + 2 * std::min(left, right);
                });
                return cost;
              });
}

Wish SpaceAround(const std::string& group, double wall_m, double thing_m) {
  return Wish(
      "space around " + group, WishKind::kAccessibility, {group},
      [=](const Arrangement& a, FloorRegion& seen) {
        double cost = 0;
        const v1::Room& room = a.problem().room;
        ForGroup(a, group, [&](int i, const Item& item) {
          const Vec2d extent = item.footprint.Extent(), c = item.footprint.center;
          for (const double gap : {c.x() - extent.x(), room.width_m() - c.x() - extent.x(),
                                   c.y() - extent.y(), room.depth_m() - c.y() - extent.y()}) {
            cost += 2.5 * std::max(0.0, wall_m - gap);
          }
          if (thing_m <= 0) return;
          seen.Add(c - extent - Vec2d::Constant(thing_m));
          seen.Add(c + extent + Vec2d::Constant(thing_m));
          for (int k = 0; k < a.size(); ++k) {
            const Item& other = a.at(k);
            if (k == i || other.anchor >= 0 || !OnFloor(a, other)) continue;
            cost += 1.5 * std::max(0.0, thing_m - GapBetween(item.footprint, other.footprint));
          }
          for (const Obstacle& o : a.problem().obstacles) {
            cost += 1.5 * std::max(0.0, thing_m - GapBetween(item.footprint, o.footprint));
          }
        });
        return cost;
      });
}

Wish Reachable() {
  // So expensive that no wish is worth a door that is cut off; a room without furniture has none of
  // these.
  constexpr double kDoorWorth = 3;
  return Wish("floor and doors reached from doors", WishKind::kAccessibility, {},
              [](const Arrangement& a, FloorRegion&) {
                const Reach reach = WalkFromDoors(a);
                return reach.unreached_share + kDoorWorth * reach.doors_cut_off;
              });
}

Wish EvenlyAround(const std::string& seats) {
  // The table's own group is not named: its seats follow it.
  return Wish(seats + " even around tables", WishKind::kSymmetry, {seats},
              [=](const Arrangement& a, FloorRegion&) { return EvenSeats(a, seats); });
}

Wish Symmetric(const std::string& group) {
  return Wish(group + " on both sides", WishKind::kSymmetry, {group},
              [=](const Arrangement& a, FloorRegion&) {
                std::map<std::pair<int, int>, int> sides;
                ForGroup(a, group, [&](int, const Item& i) { ++sides[{i.anchor, i.side % 2}]; });
                double cost = 0;
                for (const auto& [side, count] : sides) cost += count - 1;
                return cost;
              });
}

Wish Central(const std::string& group) {
  return Wish(group + " in the middle", WishKind::kAlignment, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                const v1::Room& room = a.problem().room;
                ForGroup(a, group, [&](int, const Item& item) {
                  cost += std::abs(item.footprint.center.x() / room.width_m() - 0.5) +
                          std::abs(item.footprint.center.y() / room.depth_m() - 0.5);
                });
                return cost;
              });
}

Wish NoSlits() {
  return Wish("no slits between things", WishKind::kClutter, {},
              [](const Arrangement& a, FloorRegion&) { return Slits(a); });
}

Wish Apart(const std::string& group, double apart_m) {
  return Wish(group + " spread", WishKind::kClutter, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                ForGroup(a, group, [&](int i, const Item& p) {
                  ForGroup(a, group, [&](int k, const Item& q) {
                    if (k >= i) return;
                    const double apart = (p.footprint.center - q.footprint.center).norm();
                    cost += std::max(0.0, apart_m - apart);
                  });
                });
                return cost;
              });
}

Wish LevelHeights(const std::string& group) {
  return Wish(group + " at one height", WishKind::kAlignment, {group},
              [=](const Arrangement& a, FloorRegion&) {
                double cost = 0;
                ForGroup(a, group, [&](int i, const Item& p) {
                  ForGroup(a, group, [&](int k, const Item& q) {
                    if (k >= i || p.side != q.side) return;
                    cost += std::abs(p.bottom_m + p.top_m - q.bottom_m - q.top_m) / 2;
                  });
                });
                return cost;
              });
}

Wish FloorShare(double least, double most) {
  return Wish(
      "share of the floor", WishKind::kFullness, {}, [=](const Arrangement& a, FloorRegion&) {
        double taken = 0;
        for (const Item& item : a.items()) {
          if (item.row < 0 || !OnFloor(a, item) || item.bottom_m > 0.1) continue;
          taken += 4 * item.footprint.half.prod();
        }
        const double share = taken / (a.problem().room.width_m() * a.problem().room.depth_m());
        return std::max(0.0, least - share) + std::max(0.0, share - most);
      });
}

Wish BareWalls(double most_m) {
  return Wish("no bare walls", WishKind::kFullness, {},
              [=](const Arrangement& a, FloorRegion&) { return BareStretches(a, most_m); });
}

}  // namespace parallax
