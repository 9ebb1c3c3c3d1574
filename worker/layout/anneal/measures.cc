#include "worker/layout/anneal/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace parallax {
namespace {

constexpr double kHeadHeight_m = 1.9;
constexpr double kCell_m = 0.16;        // Cell of the grid on which reach is measured.
constexpr double kBodyRadius_m = 0.24;  // Ways are 48 cm wide at least.

bool InRoom(const v1::Room& room, const Vec2d& p) {
  return p.x() > 0 && p.y() > 0 && p.x() < room.width_m() && p.y() < room.depth_m();
}

bool TakenByRoom(const Arrangement& a, const Vec2d& p) {
  if (!InRoom(a.problem().room, p)) return true;
  return std::any_of(a.problem().obstacles.begin(), a.problem().obstacles.end(),
                     [&](const Obstacle& o) { return o.bottom_m < 1 && o.footprint.Contains(p); });
}

// The floor as cells: 0 free, 1 taken, 2 reached from a door.
class ReachGrid {
 public:
  explicit ReachGrid(const Arrangement& a)
      : room_(a.problem().room),
        nx_(std::max(1, static_cast<int>(room_.width_m() / kCell_m))),
        ny_(std::max(1, static_cast<int>(room_.depth_m() / kCell_m))),
        state_(static_cast<size_t>(nx_ * ny_), 0) {
    for (const Obstacle& o : a.problem().obstacles) {
      if (o.bottom_m < 1.5) Take(o.footprint);
    }
    for (const Item& item : a.items()) {
      if (!OnFloor(a, item)) continue;
      const RoomRow* row = a.RowOf(item);
      if (row != nullptr && row->stand == Stand::kAround) continue;  // Chairs can be moved.
      Take(item.footprint);
    }
    for (const WallStrip& strip : a.problem().strips) {
      if (!strip.door || strip.sill_m > 0.1) continue;
      const Vec2d p = a.problem().walls[static_cast<size_t>(strip.wall)].At(
          (strip.low_m + strip.high_m) / 2, 0.5);
      const int cell =
          Cell(p.y() / room_.depth_m(), ny_) * nx_ + Cell(p.x() / room_.width_m(), nx_);
      // Reached from an earlier door, or the first.
      const uint8_t found = state_[static_cast<size_t>(cell)];
      cut_off_ += found == kTaken || (any_door_ && found == kFree);
      Flood(cell);
      any_door_ = true;
    }
  }
  Reach Walked() const {
    if (!any_door_) return {};
    const auto left = std::count(state_.begin(), state_.end(), kFree);
    return {static_cast<double>(left) / static_cast<double>(nx_ * ny_), cut_off_};
  }

 private:
  static constexpr uint8_t kFree = 0, kTaken = 1, kReached = 2;

  static int Cell(double share, int n) { return std::clamp(static_cast<int>(share * n), 0, n - 1); }

  void Take(const Footprint& footprint) {
    // Things askew take more than their own extent and the body's: their grown corners reach out.
    Footprint grown = footprint;
    grown.half += Vec2d::Constant(kBodyRadius_m);
    const Vec2d reach = grown.Extent();
    const Vec2d low = footprint.center - reach, high = footprint.center + reach;
    const int x0 = std::max(0, static_cast<int>(low.x() / room_.width_m() * nx_));
    const int x1 = std::min(nx_ - 1, static_cast<int>(high.x() / room_.width_m() * nx_));
    const int y0 = std::max(0, static_cast<int>(low.y() / room_.depth_m() * ny_));
    const int y1 = std::min(ny_ - 1, static_cast<int>(high.y() / room_.depth_m() * ny_));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Vec2d center((x + 0.5) * room_.width_m() / nx_, (y + 0.5) * room_.depth_m() / ny_);
        if (grown.Contains(center)) {
          state_[static_cast<size_t>(y * nx_ + x)] = kTaken;
        }
      }
    }
  }

  void Flood(int from) {
    std::vector<int> stack = {from};
    while (!stack.empty()) {
      const int c = stack.back();
      stack.pop_back();
      if (state_[static_cast<size_t>(c)] != kFree) continue;
      state_[static_cast<size_t>(c)] = kReached;
      if (c % nx_ > 0) stack.push_back(c - 1);
      if (c % nx_ + 1 < nx_) stack.push_back(c + 1);
      if (c / nx_ > 0) stack.push_back(c - nx_);
      if (c / nx_ + 1 < ny_) stack.push_back(c + nx_);
    }
  }

  const v1::Room& room_;
  int nx_, ny_;
  bool any_door_ = false;
  int cut_off_ = 0;
  std::vector<uint8_t> state_;
};

}  // namespace

bool OnFloor(const Arrangement& a, const Item& item) {
  return item.bottom_m < kHeadHeight_m - 1.2 && !a.IsRug(item);
}

int Nearest(const Arrangement& a, const std::string& group, const Vec2d& to, int except) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  ForGroup(a, group, [&](int i, const Item& item) {
    const double distance = (item.footprint.center - to).norm();
    if (i != except && distance < least) least = distance, nearest = i;
  });
  return nearest;
}

double GapBetween(const Footprint& a, const Footprint& b) {
  const Vec2d apart = (a.center - b.center).cwiseAbs() - a.Extent() - b.Extent();
  return apart.cwiseMax(0.0).norm() + std::min(0.0, apart.maxCoeff());
}

double FrontTaken(const Arrangement& a, int index, FloorRegion& seen) {
  const Item& item = a.at(index);
  const double deep = static_cast<double>(item.asset->asset_class->front_clearance_m);
  if (deep <= 0) return 0;
  constexpr int kAcross = 4, kDeep = 3;
  int taken = 0;
  seen.Add(item.footprint);
  for (int i = 0; i < kAcross; ++i) {
    for (int j = 0; j < kDeep; ++j) {
      const Vec2d p =
          item.footprint.center +
          item.footprint.AxisX() * item.footprint.half.x() * (2 * (i + 0.5) / kAcross - 1) * 0.9 +
          item.footprint.AxisY() * (item.footprint.half.y() + deep * (j + 0.5) / kDeep);
      seen.Add(p);
      bool blocked = TakenByRoom(a, p);
      for (int k = 0; k < a.size() && !blocked; ++k) {
        const Item& other = a.at(k);
        if (k == index || other.anchor == index || item.anchor == k || !OnFloor(a, other)) continue;
        blocked = other.footprint.Contains(p);
      }
      taken += blocked;
    }
  }
  return static_cast<double>(taken) / (kAcross * kDeep);
}

int InTheWay(const Arrangement& a, int from, int to) {
  const Vec2d start = a.at(from).footprint.center, end = a.at(to).footprint.center;
  int count = 0;
  for (int k = 0; k < a.size(); ++k) {
    const Item& item = a.at(k);
    if (k == from || k == to || item.top_m < 0.7 || item.anchor == to || !OnFloor(a, item))
      continue;
    bool met = false;
    for (int s = 1; s < 12 && !met; ++s) {
      met = item.footprint.Contains(start + (end - start) * (s / 12.0), 0.1);
    }
    count += met;
  }
  return count;
}

double SideTaken(const Arrangement& a, int index, double side, FloorRegion& seen) {
  const Item& item = a.at(index);
  int blocked = 0;
  for (int k = 0; k < 6; ++k) {
    const Vec2d p = item.footprint.center +
                    item.footprint.AxisX() * side * (item.footprint.half.x() + 0.35) +
                    item.footprint.AxisY() * item.footprint.half.y() * (k / 5.0 * 1.6 - 0.6);
    seen.Add(p);
    bool taken = TakenByRoom(a, p);
    for (int j = 0; j < a.size() && !taken; ++j) {
      if (j != index && OnFloor(a, a.at(j)) && a.at(j).anchor != index) {
        taken = a.at(j).footprint.Contains(p);
      }
    }
    blocked += taken;
  }
  return blocked / 6.0;
}

Reach WalkFromDoors(const Arrangement& a) { return ReachGrid(a).Walked(); }

double EvenSeats(const Arrangement& a, const std::string& seats) {
  // Seats of each table by side.
  std::map<int, std::array<std::vector<double>, 4>> tables;
  ForGroup(a, seats, [&](int, const Item& item) {
    if (item.anchor < 0) return;  // It stands at a wall, or its row has no table.
    tables[item.anchor][static_cast<size_t>(item.side)].push_back(item.u);
  });
  double cost = 0;
  for (auto& [table, sides] : tables) {
    for (auto& side : sides) {
      std::sort(side.begin(), side.end());
      const double n = static_cast<double>(side.size());
      for (size_t i = 0; i < side.size(); ++i) {
        const double ideal = n == 1 ? 0.5 : static_cast<double>(i) / (n - 1);
        cost += 1.6 * std::abs(side[i] - ideal);
      }
    }
    const auto uneven = [&sides = sides](size_t p, size_t q) {
      return std::abs(static_cast<double>(sides[p].size()) - static_cast<double>(sides[q].size()));
    };
    cost += 0.5 * (uneven(0, 2) + uneven(1, 3));
    // Heads of tables are taken after their sides, and one at a time.
    const Item& own = a.at(table);
    const bool wide = own.footprint.half.x() >= own.footprint.half.y();
    const size_t ends = sides[wide ? 1 : 0].size() + sides[wide ? 3 : 2].size();
    const size_t long_sides = sides[wide ? 0 : 1].size() + sides[wide ? 2 : 3].size();
    if (ends > long_sides) cost += 0.4 * static_cast<double>(ends - long_sides);
  }
  return cost;
}

// Stretches of each wall that something stands at or hangs on, or that is an opening.
double BareStretches(const Arrangement& a, double most_m) {
  double cost = 0;
  for (size_t w = 0; w < a.problem().walls.size(); ++w) {
    const WallFrame& wall = a.problem().walls[w];
    std::vector<std::pair<double, double>> taken;
    for (const WallStrip& strip : a.problem().strips) {
      if (strip.wall == static_cast<int>(w)) taken.push_back({strip.low_m, strip.high_m});
    }
    for (const Item& item : a.items()) {
      if (a.IsRug(item)) continue;
      const Vec2d to = item.footprint.center - wall.origin;
      const double y = to.dot(wall.inward), x = to.dot(wall.along);
      const Vec2d extent = item.footprint.Extent();
      const double reach_x =
          std::abs(wall.along.x()) * extent.x() + std::abs(wall.along.y()) * extent.y();
      const double reach_y =
          std::abs(wall.inward.x()) * extent.x() + std::abs(wall.inward.y()) * extent.y();
      if (y - reach_y < 0.35) taken.push_back({x - reach_x, x + reach_x});
    }
    std::sort(taken.begin(), taken.end());
    double from = 0;
    for (const auto& [low, high] : taken) {
      cost += std::max(0.0, low - from - most_m);
      from = std::max(from, high);
    }
    cost += std::max(0.0, wall.length_m - from - most_m);
  }
  return cost;
}

double Slits(const Arrangement& a) {
  double cost = 0;
  for (int i = 0; i < a.size(); ++i) {
    const Item& item = a.at(i);
    if (item.row < 0 || a.StandOf(item) != Stand::kBackToWall) continue;
    const WallFrame& wall = a.problem().walls[static_cast<size_t>(item.side)];
    const auto cost_of = [](double gap) {
      return gap > 0.06 && gap < 0.4 ? std::min(gap - 0.06, 0.4 - gap) * 2 : 0.0;
    };
    const double x = (item.footprint.center - wall.origin).dot(wall.along);
    cost += cost_of(x - item.footprint.half.x());
    cost += cost_of(wall.length_m - x - item.footprint.half.x());
    for (int k = 0; k < i; ++k) {
      const Item& other = a.at(k);
      if (other.row < 0 || a.StandOf(other) != Stand::kBackToWall || other.side != item.side) {
        continue;
      }
      const double at = (other.footprint.center - wall.origin).dot(wall.along);
      cost += cost_of(std::abs(at - x) - item.footprint.half.x() - other.footprint.half.x());
    }
  }
  return cost;
}

}  // namespace parallax
