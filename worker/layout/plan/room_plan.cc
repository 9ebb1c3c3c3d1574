#include "worker/layout/plan/room_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/config/config.h"
#include "worker/layout/anneal/room_table.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

constexpr double kOpeningGap_m = 0.35;
constexpr double kLintel_m = 0.12;  // Least masonry above an opening.
constexpr int kRoomTries = 40;
constexpr double kBay_m = 3.7;
constexpr double kHallSide_m[] = {8, 12}, kHallHeight_m[] = {3.5, 6};

// One over the other: doors of two storeys.
bool Above(const v1::Opening& upper, const v1::Opening& lower) {
  return upper.sill_m() > lower.sill_m() + lower.height_m() + 0.3;
}

bool Fits(const v1::Room& room, const v1::Opening& candidate) {
  for (const v1::Opening& other : room.openings()) {
    if (other.wall() != candidate.wall() || Above(other, candidate) || Above(candidate, other)) {
      continue;
    }
    const double free = std::abs(other.center_m() - candidate.center_m()) -
                        (other.width_m() + candidate.width_m()) / 2;
    if (free < kOpeningGap_m) return false;
  }
  return true;
}

// Where four bays meet: in every row, or in those along the walls only.
void AddColumns(v1::Room& room, Rng rng) {
  const HallBays bays = HallBays::Of(room);
  const bool any = rng.Bernoulli(0.75), every_row = rng.Bernoulli(0.5);
  const double side = rng.Uniform(0.3, 0.5);
  for (int i = 1; any && i < bays.along_x; ++i) {
    for (int k = 1; k < bays.along_y; ++k) {
      const bool middle = i > 1 && i + 1 < bays.along_x;
      if (!every_row && middle) continue;
      v1::Pillar& pillar = *room.add_pillars();
      pillar.set_side_m(side);
      pillar.set_x_m(room.width_m() * i / bays.along_x);
      pillar.set_y_m(room.depth_m() * k / bays.along_y);
    }
  }
}

}  // namespace

HallBays HallBays::Of(const v1::Room& room) {
  const auto count = [](double length) {
    return std::max(2, static_cast<int>(std::lround(length / kBay_m)));
  };
  return {count(room.width_m()), count(room.depth_m())};
}

std::vector<WallStretch> WholeWalls(const v1::Room& room) {
  std::vector<WallStretch> walls;
  for (int wall = 0; wall < 4; ++wall) {
    walls.push_back({wall, 0, wall % 2 == 0 ? room.width_m() : room.depth_m()});
  }
  return walls;
}

bool AddOpening(v1::Room& room, v1::Opening opening, const std::vector<WallStretch>& stretches,
                const OpeningOdds& odds, Rng& rng) {
  if (stretches.empty()) return false;
  for (int i = 0; i < kRoomTries; ++i) {
    const WallStretch& stretch = rng.Pick(stretches);
    opening.set_wall(stretch.wall);
    const double length = stretch.high_m - stretch.low_m;
    const double reach = length / 2 - opening.width_m() / 2 - odds.corner_gap_m;
    const double u = rng.Uniform(), side = rng.Bernoulli(0.5) ? 1 : -1;
    const bool near_corner = rng.Bernoulli(odds.near_corner_p);
    if (reach < 0) continue;
    const double off = near_corner ? reach - u * std::min(0.6, reach) : reach * u;
    opening.set_center_m((stretch.low_m + stretch.high_m) / 2 + side * off);
    if (!Fits(room, opening)) continue;
    *room.add_openings() = opening;
    return true;
  }
  return false;
}

v1::Opening DrawDoor(const v1::Room& room, Rng& rng) {
  v1::Opening door;
  door.set_kind(v1::Opening::KIND_DOOR);
  door.set_width_m(rng.Uniform(0.82, 1.02));
  door.set_sill_m(0);
  door.set_height_m(std::min(rng.Uniform(2.0, 2.14), room.height_m() - kLintel_m));
  door.set_seed(rng.Seed());
  return door;
}

v1::Opening DrawWindow(const v1::Room& room, Rng& rng) {
  v1::Opening window;
  const bool small = room.kind() == "bathroom" || room.kind() == "closet";
  window.set_kind(v1::Opening::KIND_WINDOW);
  window.set_width_m(small ? rng.Uniform(0.5, 0.9) : rng.Uniform(0.9, 2.3));
  const double top = std::min(rng.Uniform(2.0, 2.35), room.height_m() - kLintel_m);
  const bool tall = rng.Bernoulli(small || room.kind() == "kitchen" ? 0 : 0.15);
  double sill = tall ? rng.Uniform(0.08, 0.3) : rng.Uniform(0.75, 1.05);
  if (small) sill += 0.45;
  if (room.kind() == "kitchen") sill = std::max(sill, 1.12);  // Above counters.
  window.set_sill_m(std::min(sill, top - 0.6));
  window.set_height_m(top - window.sill_m());
  window.set_seed(rng.Seed());
  if (room.hall()) {  // Higher and wider: daylight reaches the middle.
    window.set_width_m(rng.Uniform(1.3, 2.6));
    window.set_sill_m(rng.Uniform(0.3, 0.95));
    window.set_height_m(room.height_m() * rng.Uniform(0.62, 0.8) - window.sill_m());
  }
  return window;
}

void AddPillars(v1::Room& room, Rng rng) {
  if (room.hall()) return AddColumns(room, rng);
  const double area = room.width_m() * room.depth_m();
  const bool any = rng.Bernoulli(area > 18 ? 0.25 : 0), free_standing = rng.Bernoulli(0.35);
  const double side = rng.Uniform(0.24, 0.4);
  if (!any) return;
  for (int i = 0; i < kRoomTries; ++i) {
    v1::Pillar pillar;
    pillar.set_side_m(side);
    if (free_standing) {  // Off the middle, so that tables find their place.
      pillar.set_x_m(room.width_m() * (rng.Bernoulli(0.5) ? 0.28 : 0.72));
      pillar.set_y_m(room.depth_m() * (rng.Bernoulli(0.5) ? 0.28 : 0.72));
    } else {
      const int wall = rng.UniformInt(0, 3);
      const WallFrame frame = FrameOfWall(room, wall);
      const Vec2d at = frame.At(frame.length_m * rng.Uniform(0.25, 0.75), side / 2 - 0.02);
      pillar.set_x_m(at.x());
      pillar.set_y_m(at.y());
    }
    const bool clear =
        std::all_of(room.openings().begin(), room.openings().end(), [&](const v1::Opening& o) {
          const WallFrame frame = FrameOfWall(room, o.wall());
          const Vec2d to = Vec2d(pillar.x_m(), pillar.y_m()) - frame.origin;
          const double along = to.dot(frame.along) - frame.LocalOf(o.center_m());
          return to.dot(frame.inward) > 1.4 || std::abs(along) > o.width_m() / 2 + side + 0.2;
        });
    if (!clear) continue;
    *room.add_pillars() = pillar;
    return;
  }
}

absl::StatusOr<v1::Room> DrawMainRoom(const v1::RoomConfig& config, SceneSeed seed) {
  const Rng root(seed, "layout/room");
  v1::Room room;
  if (config.kinds().empty()) return InvalidArgument("room.kinds is empty");
  const std::string kind = root.Child("kind").Pick(config.kinds());
  room.set_kind(kind);
  for (const v1::RoomKind& own : config.own_kinds()) {
    if (own.name() != kind) continue;
    room.set_own_kind(kind);
    room.set_kind(own.has_like() ? own.like() : "living_room");
  }
  if (FindRoomTable(room.kind()) == nullptr) {
    return InvalidArgument("room.kinds: unknown kind \"{}\"", kind);
  }
  room.set_name(kind + "_0");
  room.set_width_m(Draw(config.width_m(), root.Child("width").Uniform()));
  room.set_depth_m(Draw(config.depth_m(), root.Child("depth").Uniform()));
  room.set_height_m(Draw(config.height_m(), root.Child("height").Uniform()));
  if (!(std::min(room.width_m(), room.depth_m()) >= 1.5 && room.height_m() >= 1.9)) {
    return InvalidArgument("room: smaller than 1.5 m x 1.5 m x 1.9 m");
  }
  room.set_wall_thickness_m(root.Child("walls").Uniform(0.14, 0.28));
  room.set_skirting_height_m(root.Child("skirting").Uniform(0.06, 0.14));
  Rng cornice = root.Child("cornice");
  if (cornice.Bernoulli(0.4)) room.set_cornice_m(cornice.Uniform(0.05, 0.11));
  room.set_window_glass(config.window_glass());
  Rng hall = root.Child("hall");
  if (hall.Bernoulli(config.hall_p())) {
    room.set_hall(true);
    room.set_width_m(hall.Uniform(kHallSide_m[0], kHallSide_m[1]));
    room.set_depth_m(hall.Uniform(kHallSide_m[0], kHallSide_m[1]));
    room.set_height_m(hall.Uniform(kHallHeight_m[0], kHallHeight_m[1]));
  }
  return room;
}

}  // namespace parallax
