// Measures of an arrangement, for wishes. Pure functions. Private to worker/layout.
#pragma once

#include <string>

#include "worker/layout/anneal/arrangement.h"
#include "worker/layout/anneal/wish.h"

namespace parallax {

// Calls visit(index, item) for each item of the group.
template <typename Visit>
void ForGroup(const Arrangement& a, const std::string& group, Visit visit) {
  for (int i = 0; i < a.size(); ++i) {
    const RoomRow* row = a.RowOf(a.at(i));
    if (row != nullptr && row->group == group) visit(i, a.at(i));
  }
}

// Returns whether people must walk around the item: it neither hangs above their reach nor is a
// rug.
bool OnFloor(const Arrangement& a, const Item& item);

// Returns the nearest item of a group; -1 without any.
int Nearest(const Arrangement& a, const std::string& group, const Vec2d& to, int except);

// Sums cost(index, item, target item) over the group, each with its nearest of the target group.
template <typename Cost>
double OverPairs(const Arrangement& a, const std::string& group, const std::string& target,
                 Cost cost) {
  double sum = 0;
  ForGroup(a, group, [&](int i, const Item& item) {
    const int k = Nearest(a, target, item.footprint.center, i);
    if (k >= 0) sum += cost(i, item, k, a.at(k));
  });
  return sum;
}

// Returns the distance of the footprints' axis-aligned bounds, an approximation of their own; below
// 0 where these overlap.
double GapBetween(const Footprint& a, const Footprint& b);

// Returns the share of the rectangle before the item that other items or walls take; its own seats
// do not count.
double FrontTaken(const Arrangement& a, int index, FloorRegion& seen);

// Returns the number of items that stand between two items.
int InTheWay(const Arrangement& a, int from, int to);

// Returns the occupied share of the strip beside the item, on its side -1 or 1.
double SideTaken(const Arrangement& a, int index, double side, FloorRegion& seen);

// The floor on a grid, walked from the doors.
struct Reach {
  double unreached_share = 0;  // Share of the floor's free cells that nobody can walk to.
  int doors_cut_off = 0;       // Doors that nobody can walk to from the others.
};
Reach WalkFromDoors(const Arrangement& a);

// Unevenness of seats around their tables; 0: even.
double EvenSeats(const Arrangement& a, const std::string& seats);

// Metres of bare wall beyond `most_m` in one stretch.
double BareStretches(const Arrangement& a, double most_m);

// Gaps between items at one wall, from a few centimetres to a forearm's length.
double Slits(const Arrangement& a);

}  // namespace parallax
