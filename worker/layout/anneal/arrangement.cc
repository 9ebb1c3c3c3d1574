#include "worker/layout/anneal/arrangement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace parallax {
namespace {

constexpr double kPi = std::numbers::pi;
// Height of objects above their support: touching must not count as overlap.
constexpr double kLift_m = 0.0005;
constexpr double kWallGap_m = 0.018;  // Skirting is 15 mm deep.
constexpr double kItemGap_m = 0.012;
constexpr double kDoorDepth_m = 0.85;   // Free floor before a door.
constexpr double kWindowDepth_m = 0.3;  // Kept by what is taller than the sill.
constexpr double kStripGap_m = 0.12;    // Casings and sill boards reach beside the opening.
constexpr double kArtDepth_m = 0.4;     // Nothing tall right before what hangs on a wall.
constexpr double kCeilingGap_m = 0.03;

double Mix(double low, double high, double t) { return low + (high - low) * t; }

// Bounds in the plan, object frame.
struct Plan {
  Vec2d low, high;
  Vec2d size() const { return high - low; }
  Vec2d center() const { return 0.5 * (low + high); }
};
Plan PlanOf(const PooledAsset& asset) {
  return {asset.bounds.min().head<2>().cast<double>(), asset.bounds.max().head<2>().cast<double>()};
}

Vec2d Turned(const Vec2d& p, double yaw) {
  return {std::cos(yaw) * p.x() - std::sin(yaw) * p.y(),
          std::sin(yaw) * p.x() + std::cos(yaw) * p.y()};
}

bool BoxesMeet(const Item& a, const Item& b, double gap_m) {
  return a.bottom_m < b.top_m && b.bottom_m < a.top_m && Overlap(a.footprint, b.footprint, gap_m);
}

bool MeshesMeet(const Item& a, const Item& b) {
  return Overlap(*a.asset->Tree(), a.WorldFromObject(), *b.asset->Tree(), b.WorldFromObject());
}

}  // namespace

const SupportSurface* MainSupport(const PooledAsset& asset) {
  const SupportSurface* best = nullptr;
  double best_value = 0;
  for (const SupportSurface& support : asset.supports) {
    if (support.area.isEmpty()) continue;
    const double value = static_cast<double>(support.area.sizes().prod()) *
                         std::min(1.0, static_cast<double>(support.clearance_m));
    if (value > best_value) {
      best_value = value;
      best = &support;
    }
  }
  return best;
}

Arrangement::Arrangement(const RoomProblem& problem, const std::vector<Fixture>& fixtures)
    : problem_(&problem) {
  for (const Fixture& fixture : fixtures) {
    Item item;
    item.asset = fixture.asset;
    const Vec2d origin = fixture.position.head<2>();
    Settle(item, origin, fixture.yaw_rad, 0);
    item.position = fixture.position;
    item.bottom_m = fixture.position.z() + static_cast<double>(fixture.asset->bounds.min().z());
    item.top_m = fixture.position.z() + static_cast<double>(fixture.asset->bounds.max().z());
    items_.push_back(item);
  }
}

const RoomRow* Arrangement::RowOf(const Item& item) const {
  return item.row < 0 ? nullptr : &problem_->rows[static_cast<size_t>(item.row)].row;
}

int Arrangement::CountOf(int row) const {
  return static_cast<int>(
      std::count_if(items_.begin(), items_.end(), [&](const Item& i) { return i.row == row; }));
}

bool Arrangement::HasChild(int item, int row) const {
  return std::any_of(items_.begin(), items_.end(),
                     [&](const Item& i) { return i.anchor == item && i.row == row; });
}

bool Arrangement::IsRug(const Item& item) const {
  const RoomRow* row = RowOf(item);
  return row != nullptr && item.stand == Stand::kUnder;
}

int Arrangement::Add(const Item& item) {
  items_.push_back(item);
  return size() - 1;
}

std::vector<int> Arrangement::WithDependants(int item) const {
  std::vector<int> all = {item};
  for (size_t k = 0; k < all.size(); ++k) {
    for (int i = 0; i < size(); ++i) {
      if (at(i).anchor == all[k]) all.push_back(i);
    }
  }
  return all;
}

void Arrangement::Remove(int item) {
  std::vector<int> gone = WithDependants(item);
  std::sort(gone.rbegin(), gone.rend());
  for (const int g : gone) {
    items_.erase(items_.begin() + g);
    for (Item& i : items_) {
      if (i.anchor > g) --i.anchor;
    }
  }
}

bool Arrangement::Place(int item) {
  for (const int i : WithDependants(item)) {
    if (!PlaceOne(at(i))) return false;
  }
  return true;
}

void Arrangement::Settle(Item& item, const Vec2d& origin, double yaw_rad, double z_m) const {
  const Plan plan = PlanOf(*item.asset);
  item.yaw_rad = yaw_rad;
  item.position = {origin.x(), origin.y(), z_m - static_cast<double>(item.asset->bounds.min().z())};
  item.footprint = {origin + Turned(plan.center(), yaw_rad), 0.5 * plan.size(), yaw_rad};
  item.bottom_m = z_m;
  item.top_m = z_m + static_cast<double>(item.asset->bounds.sizes().z());
}

bool Arrangement::PlaceOne(Item& item) const {
  const RoomRow* row = RowOf(item);
  if (row == nullptr) return true;
  switch (item.stand) {
    case Stand::kBackToWall:
    case Stand::kCorner:
      return PlaceByWall(item, *row);
    case Stand::kFree:
    case Stand::kCeiling: {
      const Plan plan = PlanOf(*item.asset);
      Vec2d middle(item.u * problem_->room.width_m(), item.v * problem_->room.depth_m());
      double yaw = item.side * kPi / 2 + item.turn_rad;
      if (row->rows_m > 0) {  // All along one direction, middles on a lattice about the room's.
        const Vec2d half(problem_->room.width_m() / 2, problem_->room.depth_m() / 2);
        middle = half + row->rows_m * ((middle - half) / row->rows_m).array().round().matrix();
        yaw = (item.side < 2 ? 0 : kPi) + item.turn_rad;
      }
      const double height = static_cast<double>(item.asset->bounds.sizes().z());
      const double z =
          item.stand == Stand::kFree ? kLift_m : problem_->room.height_m() - height - kLift_m;
      Settle(item, middle - Turned(plan.center(), yaw), yaw, z);
      return true;
    }
    case Stand::kOnTop:
      return PlaceOnTop(item);
    case Stand::kOnWall:
      return PlaceOnWall(item, *row);
    default:
      return PlaceByAnchor(item, *row);
  }
}

bool Arrangement::PlaceByWall(Item& item, const RoomRow& row) const {
  const WallFrame& wall = problem_->walls[static_cast<size_t>(item.side)];
  const Plan plan = PlanOf(*item.asset);
  if (item.stand == Stand::kCorner) {
    const double yaw = wall.yaw_rad - kPi / 4 + item.turn_rad;
    // Uses the true outline instead of the box, so that a corner shelf goes right into its corner.
    const Box2f box = item.asset->TurnedBounds(yaw - wall.yaw_rad);
    const double gap = kWallGap_m + (row.snug ? 0.004 : 0.02 + 0.25 * item.u);
    Settle(
        item,
        wall.At(gap - static_cast<double>(box.min().x()), gap - static_cast<double>(box.min().y())),
        yaw, kLift_m);
    return true;
  }
  const double reach = wall.length_m - plan.size().x() - 2 * kWallGap_m;
  if (reach < 0) return false;
  const double x = kWallGap_m + reach * item.u - plan.low.x();
  const double y = kWallGap_m + 0.025 * item.v - plan.low.y();
  Settle(item, wall.At(x, y), wall.yaw_rad, kLift_m);
  return true;
}

bool Arrangement::PlaceByAnchor(Item& item, const RoomRow& row) const {
  const Item& anchor = at(item.anchor);
  const Plan own = PlanOf(*item.asset), base = PlanOf(*anchor.asset);
  const double gap = Mix(row.near_m, row.far_m, item.v);
  Vec2d middle = base.center();  // Middle of the item's bounds, anchor frame.
  double yaw = item.turn_rad;
  switch (item.stand) {
    case Stand::kAround: {
      // Sides 0: -y, 1: +x, 2: +y, 3: -x; the front looks at the anchor.
      const bool across = item.side % 2 == 1;
      const double length = across ? base.size().y() : base.size().x();
      const double free = std::max(0.0, length - own.size().x());
      const double along = (item.u - 0.5) * free;
      const double off = gap + own.size().y() / 2;
      yaw += item.side * kPi / 2;
      if (item.side == 0) middle += Vec2d(along, -base.size().y() / 2 - off);
      if (item.side == 2) middle += Vec2d(along, base.size().y() / 2 + off);
      if (item.side == 1) middle += Vec2d(base.size().x() / 2 + off, along);
      if (item.side == 3) middle += Vec2d(-base.size().x() / 2 - off, along);
      break;
    }
    case Stand::kInFront: {
      const double slack = 0.15 * base.size().x();
      // A table is parallel to its sofa, whichever way it was modelled.
      const bool quarter = !row.faces_anchor && own.size().y() > own.size().x();
      yaw += row.faces_anchor ? kPi : (quarter ? kPi / 2 : 0);
      const double deep = quarter ? own.size().x() : own.size().y();
      middle += Vec2d((2 * item.u - 1) * slack, base.size().y() / 2 + gap + deep / 2);
      break;
    }
    case Stand::kBeside: {
      const double off = base.size().x() / 2 + gap + own.size().x() / 2;
      middle.x() += item.side % 2 == 0 ? -off : off;
      middle.y() = base.low.y() + own.size().y() / 2;
      break;
    }
    case Stand::kUnder: {
      // Long side along the anchor's long side; rugs lie before beds and sofas rather than below
      // them.
      const bool turn = (own.size().x() > own.size().y()) != (base.size().x() > base.size().y());
      yaw += turn ? kPi / 2 : 0;
      const bool large = base.size().minCoeff() > own.size().minCoeff();
      const double forward = large ? 0.3 * base.size().y() : 0;
      middle += Vec2d((item.u - 0.5) * 0.15, forward + (item.v - 0.5) * 0.15);
      break;
    }
    default:
      return false;
  }
  const double world_yaw = anchor.yaw_rad + yaw;
  const Vec2d world = anchor.position.head<2>() + Turned(middle, anchor.yaw_rad);
  Settle(item, world - Turned(own.center(), world_yaw), world_yaw, kLift_m);
  return true;
}

bool Arrangement::PlaceOnTop(Item& item) const {
  const Item& anchor = at(item.anchor);
  const SupportSurface* support = MainSupport(*anchor.asset);
  if (support == nullptr) return false;
  const Plan own = PlanOf(*item.asset);
  if (item.asset->bounds.sizes().z() > support->clearance_m - 0.01f) return false;
  const Vec2d low = support->area.min().cast<double>(), high = support->area.max().cast<double>();
  const Vec2d free = (high - low) - own.size();
  if (free.minCoeff() < 0) return false;
  const Vec2d middle = low + 0.5 * own.size() + Vec2d(item.u * free.x(), item.v * free.y());
  const double yaw = anchor.yaw_rad + item.turn_rad;
  const Vec2d world = anchor.position.head<2>() + Turned(middle, anchor.yaw_rad);
  Settle(item, world - Turned(own.center(), yaw), yaw,
         anchor.position.z() + static_cast<double>(support->z_m) + kLift_m);
  return true;
}

bool Arrangement::PlaceOnWall(Item& item, const RoomRow& row) const {
  const Plan plan = PlanOf(*item.asset);
  const double height = static_cast<double>(item.asset->bounds.sizes().z());
  int side = item.side;
  double middle_x = 0, bottom = 0;
  if (!row.anchor.empty()) {
    const Item& anchor = at(item.anchor);
    side = anchor.side;
    const WallFrame& wall = problem_->walls[static_cast<size_t>(side)];
    middle_x = (anchor.footprint.center - wall.origin).dot(wall.along) + (item.u - 0.5) * 0.2;
    bottom = std::max(anchor.top_m + Mix(0.12, 0.35, item.v), 1.5 - height / 2);
    const double half = plan.size().x() / 2 + 0.03;
    if (middle_x < half || middle_x > wall.length_m - half) return false;
  } else {
    const WallFrame& wall = problem_->walls[static_cast<size_t>(side)];
    const double reach = wall.length_m - plan.size().x() - 0.2;
    if (reach < 0) return false;
    middle_x = 0.1 + plan.size().x() / 2 + item.u * reach;
    bottom = row.hang_high_m > 0 ? Mix(row.hang_low_m, row.hang_high_m, item.v)
                                 : Mix(1.5, 1.65, item.v) - height / 2;
  }
  if (bottom + height > problem_->room.height_m() - 0.1) return false;
  const WallFrame& wall = problem_->walls[static_cast<size_t>(side)];
  Settle(item, wall.At(middle_x - plan.center().x(), 0.001 - plan.low.y()), wall.yaw_rad, bottom);
  return true;
}

bool Arrangement::Exempt(const Item& a, const Item& b) const {
  return (IsRug(a) && b.bottom_m < 0.1) || (IsRug(b) && a.bottom_m < 0.1);
}

bool Arrangement::ClearOfRoom(const Item& item) const {
  const v1::Room& room = problem_->room;
  const RoomRow* row = RowOf(item);
  const bool hung = row != nullptr && item.stand == Stand::kOnWall;
  const Box2f box = item.asset->TurnedBounds(item.yaw_rad);
  const Vec2d low = item.position.head<2>() + box.min().cast<double>();
  const Vec2d high = item.position.head<2>() + box.max().cast<double>();
  // Things that hang from the ceiling keep off the moulding around it.
  const double gap = hung                            ? 0
                     : item.stand == Stand::kCeiling ? room.cornice_m() + kCeilingGap_m
                                                     : kWallGap_m - 0.001;
  if (low.minCoeff() < gap || high.x() > room.width_m() - gap || high.y() > room.depth_m() - gap) {
    return false;
  }
  const double ceiling = room.height_m() - kCeilingGap_m - room.cornice_m();
  if (item.stand != Stand::kCeiling && item.top_m > ceiling) return false;
  for (const Obstacle& obstacle : problem_->obstacles) {
    if (item.bottom_m < obstacle.top_m && obstacle.bottom_m < item.top_m &&
        Overlap(item.footprint, obstacle.footprint, kItemGap_m)) {
      return false;
    }
  }
  if (IsRug(item)) return true;
  const double above = row != nullptr ? row->headroom_m : 0;
  return ClearOfOpenings(item.footprint, item.bottom_m, item.top_m + above, kWindowDepth_m);
}

bool Arrangement::ClearOfOpenings(const Footprint& footprint, double bottom_m, double top_m,
                                  double window_depth_m) const {
  for (const WallStrip& strip : problem_->strips) {
    const double deep = strip.door ? kDoorDepth_m : window_depth_m;
    if (!strip.door && top_m < strip.sill_m - 0.03) continue;
    if (!strip.door && bottom_m > strip.top_m + 0.05) continue;
    const WallFrame& wall = problem_->walls[static_cast<size_t>(strip.wall)];
    const Footprint zone = {wall.At((strip.low_m + strip.high_m) / 2, deep / 2),
                            {(strip.high_m - strip.low_m) / 2 + kStripGap_m, deep / 2},
                            wall.yaw_rad};
    if (Overlap(footprint, zone, 0)) return false;
  }
  return true;
}

bool Arrangement::ClearOf(const Item& item, const Item& other) const {
  if (Exempt(item, other)) return true;
  const RoomRow* own = RowOf(item);
  const RoomRow* its = RowOf(other);
  const bool hung = own != nullptr && item.stand == Stand::kOnWall;
  const bool other_hung = its != nullptr && other.stand == Stand::kOnWall;
  if (hung != other_hung) {
    // Things on the wall need the view before them free.
    Item art = hung ? item : other;
    const Item& thing = hung ? other : item;
    art.footprint.center += art.Front() * (kArtDepth_m / 2);
    art.footprint.half.y() += kArtDepth_m / 2;
    return !BoxesMeet(art, thing, kItemGap_m);
  }
  if (!BoxesMeet(item, other, hung ? 0.08 : kItemGap_m)) return true;
  // Seats go under tables and things stand on their bearers: there the meshes decide
  // (MeetsAnchor).
  return (item.anchor >= 0 && &at(item.anchor) == &other) ||
         (other.anchor >= 0 && &at(other.anchor) == &item);
}

bool Arrangement::MeetsAnchor(const Item& item) const {
  const Item& anchor = at(item.anchor);
  if (Exempt(item, anchor) || !BoxesMeet(item, anchor, kItemGap_m)) return false;
  Item::AnchorMeeting& known = item.meeting;
  const bool current = known.own == item.asset && known.anchor == anchor.asset &&
                       known.side == item.side && known.u == item.u && known.v == item.v &&
                       known.turn_rad == item.turn_rad;
  if (!current) {
    known = {item.asset,
             anchor.asset,
             item.side,
             item.u,
             item.v,
             item.turn_rad,
             MeshesMeet(item, anchor)};
  }
  return known.meets;
}

std::optional<std::vector<int>> Arrangement::InTheWayOf(int item) const {
  if (!ClearOfRoom(at(item))) return std::nullopt;
  std::vector<int> others;
  for (int i = 0; i < size(); ++i) {
    if (i != item && !ClearOf(at(item), at(i))) others.push_back(i);
  }
  return others;
}

bool Arrangement::Allowed(int item) const {
  const std::vector<int> moved = WithDependants(item);
  for (const int m : moved) {
    if (!ClearOfRoom(at(m))) return false;
  }
  for (const int m : moved) {
    for (int i = 0; i < size(); ++i) {
      // A pair of which both moved is tested once.
      if (i == m || (i < m && std::find(moved.begin(), moved.end(), i) != moved.end())) continue;
      if (!ClearOf(at(m), at(i))) return false;
    }
  }
  return std::none_of(moved.begin(), moved.end(),
                      [&](int m) { return at(m).anchor >= 0 && MeetsAnchor(at(m)); });
}

}  // namespace parallax
