#include "worker/layout/loss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace parallax {
namespace {

constexpr double kHeadHeight_m = 1.9;
constexpr double kCell_m = 0.16;  // Of the grid on which reach is measured.
constexpr double kBodyRadius_m = 0.2;

bool OnFloor(const Arrangement& a, const Item& item) {
  return item.bottom_m < kHeadHeight_m - 1.2 && !a.IsRug(item);
}

bool InRoom(const v1::Room& room, const Vec2d& p) {
  return p.x() > 0 && p.y() > 0 && p.x() < room.width_m() && p.y() < room.depth_m();
}

double Missing(const Arrangement& a) {
  double loss = 0;
  for (size_t r = 0; r < a.problem().rows.size(); ++r) {
    const WantedRow& wanted = a.problem().rows[r];
    const int lacking = wanted.wanted - a.CountOf(static_cast<int>(r));
    loss += wanted.row.weight * std::abs(lacking);
  }
  return loss;
}

// Share of the rectangle before the item that is taken by others or by walls; its own seats do not
// count.
double FrontTaken(const Arrangement& a, int index) {
  const Item& item = a.at(index);
  const double deep = static_cast<double>(item.asset->asset_class->front_clearance_m);
  if (deep <= 0) return 0;
  constexpr int kAcross = 4, kDeep = 3;
  int taken = 0;
  for (int i = 0; i < kAcross; ++i) {
    for (int j = 0; j < kDeep; ++j) {
      const Vec2d p =
          item.footprint.center +
          item.footprint.AxisX() * item.footprint.half.x() * (2 * (i + 0.5) / kAcross - 1) * 0.9 +
          item.footprint.AxisY() * (item.footprint.half.y() + deep * (j + 0.5) / kDeep);
      bool blocked = !InRoom(a.problem().room, p);
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

// How many things stand in the way between two that look at each other.
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

// Seats turn to what they look at, at a distance that suits it.
double LooksAt(const Arrangement& a) {
  double loss = 0;
  for (int i = 0; i < a.size(); ++i) {
    const RoomRow* row = a.RowOf(a.at(i));
    if (row == nullptr || row->looks_at.empty()) continue;
    const Item& item = a.at(i);
    double nearest = std::numeric_limits<double>::infinity(), cost = 0;
    for (int k = 0; k < a.size(); ++k) {
      const RoomRow* other = a.RowOf(a.at(k));
      if (other == nullptr || other->group != row->looks_at) continue;
      const Vec2d to = a.at(k).footprint.center - item.footprint.center;
      const double distance = to.norm();
      if (distance >= nearest || distance < 1e-6) continue;
      nearest = distance;
      const double cosine = to.dot(item.Front()) / distance;
      // A screen wants two to four metres, a table is within reach.
      const bool screen = row->stand != Stand::kFree;
      const double least = screen ? 1.8 : 0.8, most = screen ? 4.2 : 1.5;
      cost = 4.0 * (1 - cosine) + 1.5 * std::max(0.0, least - distance) +
             1.0 * std::max(0.0, distance - most) + (screen ? 1.5 * InTheWay(a, i, k) : 0.0);
    }
    loss += cost;
  }
  return loss;
}

double Seats(const Arrangement& a) {
  double loss = 0;
  // Seats of each table by side.
  std::map<int, std::array<std::vector<double>, 4>> tables;
  for (const Item& item : a.items()) {
    const RoomRow* row = a.RowOf(item);
    if (row == nullptr || row->stand != Stand::kAround) continue;
    tables[item.anchor][static_cast<size_t>(item.side)].push_back(item.u);
  }
  for (auto& [table, sides] : tables) {
    for (auto& side : sides) {
      std::sort(side.begin(), side.end());
      const double n = static_cast<double>(side.size());
      for (size_t i = 0; i < side.size(); ++i) {
        const double ideal = n == 1 ? 0.5 : static_cast<double>(i) / (n - 1);
        loss += 1.6 * std::abs(side[i] - ideal);
      }
    }
    loss +=
        0.5 * std::abs(static_cast<double>(sides[0].size()) - static_cast<double>(sides[2].size()));
    loss +=
        0.5 * std::abs(static_cast<double>(sides[1].size()) - static_cast<double>(sides[3].size()));
  }
  return loss;
}

// Tables that people sit around stand off the walls; low free things keep a little.
double TableSpace(const Arrangement& a) {
  double loss = 0;
  for (const Item& item : a.items()) {
    const RoomRow* row = a.RowOf(item);
    if (row == nullptr || row->stand != Stand::kFree) continue;
    const double wanted = row->looks_at.empty() ? 0.85 : 0.25;
    const Vec2d extent = item.footprint.Extent(), c = item.footprint.center;
    const v1::Room& room = a.problem().room;
    for (const double gap : {c.x() - extent.x(), room.width_m() - c.x() - extent.x(),
                             c.y() - extent.y(), room.depth_m() - c.y() - extent.y()}) {
      loss += 2.5 * std::max(0.0, wanted - gap);
    }
    if (!row->looks_at.empty()) continue;
    for (const Item& other : a.items()) {
      if (&other == &item || other.anchor >= 0 || !OnFloor(a, other)) continue;
      // Two footprints nearer than the pull-out depth.
      if (Overlap(item.footprint, other.footprint, 0.55)) loss += 0.8;
    }
  }
  return loss;
}

double Besides(const Arrangement& a) {
  double loss = 0;
  for (int i = 0; i < a.size(); ++i) {
    const RoomRow* row = a.RowOf(a.at(i));
    if (row == nullptr || row->group != "bed") continue;
    const Item& bed = a.at(i);
    // One can get in from both sides, or at least from one.
    double worst = 0, best = 1;
    for (const double side : {-1.0, 1.0}) {
      int blocked = 0;
      for (int k = 0; k < 6; ++k) {
        const Vec2d p = bed.footprint.center +
                        bed.footprint.AxisX() * side * (bed.footprint.half.x() + 0.35) +
                        bed.footprint.AxisY() * bed.footprint.half.y() * (k / 5.0 * 1.6 - 0.6);
        bool taken = !InRoom(a.problem().room, p);
        for (int j = 0; j < a.size() && !taken; ++j) {
          if (j != i && OnFloor(a, a.at(j)) && a.at(j).anchor != i) {
            taken = a.at(j).footprint.Contains(p);
          }
        }
        blocked += taken;
      }
      worst = std::max(worst, blocked / 6.0);
      best = std::min(best, blocked / 6.0);
    }
    loss += 1.5 * worst + 3.0 * best;
  }
  return loss;
}

// Share of the free floor that a person who comes in by the doors cannot get to.
double Unreached(const Arrangement& a) {
  const v1::Room& room = a.problem().room;
  const int nx = static_cast<int>(room.width_m() / kCell_m),
            ny = static_cast<int>(room.depth_m() / kCell_m);
  std::vector<uint8_t> state(static_cast<size_t>(nx * ny), 0);  // 0 free, 1 taken, 2 reached
  const auto center = [&](int x, int y) {
    return Vec2d((x + 0.5) * room.width_m() / nx, (y + 0.5) * room.depth_m() / ny);
  };
  for (const Item& item : a.items()) {
    if (!OnFloor(a, item)) continue;
    const RoomRow* row = a.RowOf(item);
    if (row != nullptr && row->stand == Stand::kAround) continue;  // Chairs can be moved.
    const Vec2d reach = item.footprint.Extent() + Vec2d::Constant(kBodyRadius_m);
    const Vec2d low = item.footprint.center - reach, high = item.footprint.center + reach;
    const int x0 = std::max(0, static_cast<int>(low.x() / room.width_m() * nx));
    const int x1 = std::min(nx - 1, static_cast<int>(high.x() / room.width_m() * nx));
    const int y0 = std::max(0, static_cast<int>(low.y() / room.depth_m() * ny));
    const int y1 = std::min(ny - 1, static_cast<int>(high.y() / room.depth_m() * ny));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        if (item.footprint.Contains(center(x, y), kBodyRadius_m))
          state[static_cast<size_t>(y * nx + x)] = 1;
      }
    }
  }
  std::vector<int> stack;
  for (const WallStrip& strip : a.problem().strips) {
    if (!strip.door) continue;
    const Vec2d p = a.problem().walls[static_cast<size_t>(strip.wall)].At(
        (strip.low_m + strip.high_m) / 2, 0.5);
    const int x = std::clamp(static_cast<int>(p.x() / room.width_m() * nx), 0, nx - 1);
    const int y = std::clamp(static_cast<int>(p.y() / room.depth_m() * ny), 0, ny - 1);
    stack.push_back(y * nx + x);
  }
  if (stack.empty()) return 0;
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    if (state[static_cast<size_t>(c)] != 0) continue;
    state[static_cast<size_t>(c)] = 2;
    const int x = c % nx, y = c / nx;
    if (x > 0) stack.push_back(c - 1);
    if (x + 1 < nx) stack.push_back(c + 1);
    if (y > 0) stack.push_back(c - nx);
    if (y + 1 < ny) stack.push_back(c + nx);
  }
  const auto left = std::count(state.begin(), state.end(), 0);
  return 12.0 * static_cast<double>(left) / static_cast<double>(nx * ny);
}

double Walls(const Arrangement& a) {
  double loss = 0;
  for (int i = 0; i < a.size(); ++i) {
    const RoomRow* row = a.RowOf(a.at(i));
    if (row == nullptr || row->stand != Stand::kOnWall) continue;
    for (int k = 0; k < i; ++k) {
      const RoomRow* other = a.RowOf(a.at(k));
      if (other == nullptr || other->stand != Stand::kOnWall) continue;
      const double apart = (a.at(i).footprint.center - a.at(k).footprint.center).norm();
      loss += 0.4 * std::max(0.0, 1.0 - apart);
    }
  }
  return loss;
}

}  // namespace

std::string_view NameOf(LossTerm term) {
  switch (term) {
    case kLossMissing:
      return "furniture wanted";
    case kLossFrontSpace:
      return "space in front";
    case kLossLooksAt:
      return "seats look at their target";
    case kLossSeats:
      return "seats even around tables";
    case kLossTableSpace:
      return "space around tables";
    case kLossBesides:
      return "beds free at the sides";
    case kLossReach:
      return "floor reached from doors";
    case kLossWalls:
      return "pictures spread";
    case kLossTerms:
      break;
  }
  return "";
}

Loss Evaluate(const Arrangement& arrangement) {
  Loss loss;
  loss.terms[kLossMissing] = Missing(arrangement);
  for (int i = 0; i < arrangement.size(); ++i) {
    loss.terms[kLossFrontSpace] += 2.0 * FrontTaken(arrangement, i);
  }
  loss.terms[kLossLooksAt] = LooksAt(arrangement);
  loss.terms[kLossSeats] = Seats(arrangement);
  loss.terms[kLossTableSpace] = TableSpace(arrangement);
  loss.terms[kLossBesides] = Besides(arrangement);
  loss.terms[kLossReach] = Unreached(arrangement);
  loss.terms[kLossWalls] = Walls(arrangement);
  return loss;
}

}  // namespace parallax
