#include "worker/layout/room_shell.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "worker/layout/openings.h"
#include "worker/layout/part_builder.h"
#include "worker/layout/wall_frame.h"

namespace parallax {
namespace {

using Grain = PartBuilder::Grain;

constexpr float kSlab_m = 0.2f;  // Floor and ceiling.
constexpr float kReach_m =
    0.05f;  // Walls reach this far into the slabs: no light leaks along the edges.

struct Hole {
  float left, right, bottom, top;
};

std::vector<Hole> HolesOf(const v1::Room& room, int wall) {
  const WallFrame frame = FrameOfWall(room, wall);
  std::vector<Hole> holes;
  for (const v1::Opening& o : room.openings()) {
    if (o.wall() != wall) continue;
    const double middle = frame.LocalOf(o.center_m());
    // A door's cut goes down under the floor's top, so that no two faces share a plane there.
    const double bottom = o.sill_m() > 0.01 ? o.sill_m() : -0.8 * kReach_m;
    holes.push_back({static_cast<float>(middle - o.width_m() / 2),
                     static_cast<float>(middle + o.width_m() / 2), static_cast<float>(bottom),
                     static_cast<float>(o.sill_m() + o.height_m())});
  }
  return holes;
}

// Heights at which any wall is cut. All walls share them, so that the cells of neighbours meet edge
// to edge.
std::vector<float> HeightCuts(const v1::Room& room) {
  std::set<float> cuts = {-kReach_m, static_cast<float>(room.height_m()) + kReach_m};
  for (int wall = 0; wall < 4; ++wall) {
    for (const Hole& hole : HolesOf(room, wall)) {
      cuts.insert(hole.bottom);
      cuts.insert(hole.top);
    }
  }
  return {cuts.begin(), cuts.end()};
}

// One wall as a grid of cells between the cuts: solid cells show an inner and an outer face,
// borders of holes a reveal.
void AddWall(PartBuilder& builder, const v1::Room& room, int wall, const std::vector<float>& z) {
  const uint16_t inside = builder.Slot("wall", {"paint", "wallpaper", "plaster", "brick"});
  const uint16_t outside = builder.Slot("exterior", {"plaster", "brick", "paint"});
  const WallFrame frame = FrameOfWall(room, wall);
  builder.SetFrame(frame.WorldFromWall());
  const std::vector<Hole> holes = HolesOf(room, wall);
  const float length = static_cast<float>(frame.length_m);
  const float thick = static_cast<float>(room.wall_thickness_m());
  std::set<float> cuts = {0.0f, length};
  for (const Hole& hole : holes) {
    cuts.insert(hole.left);
    cuts.insert(hole.right);
  }
  const std::vector<float> x(cuts.begin(), cuts.end());
  const int columns = static_cast<int>(x.size()) - 1, rows = static_cast<int>(z.size()) - 1;
  const auto open = [&](int i, int j) {
    if (i < 0 || i >= columns || j < 0 || j >= rows) return false;
    const float mx = 0.5f * (x[i] + x[i + 1]), mz = 0.5f * (z[j] + z[j + 1]);
    return std::any_of(holes.begin(), holes.end(), [&](const Hole& h) {
      return mx > h.left && mx < h.right && mz > h.bottom && mz < h.top;
    });
  };
  for (int i = 0; i < columns; ++i) {
    const float a = x[i], b = x[i + 1];
    for (int j = 0; j < rows; ++j) {
      const float c = z[j], d = z[j + 1];
      if (!open(i, j)) {
        builder.Quad(inside, {b, 0, c}, {a, 0, c}, {a, 0, d}, {b, 0, d});
        builder.Quad(outside, {a, -thick, c}, {b, -thick, c}, {b, -thick, d}, {a, -thick, d});
        continue;
      }
      if (!open(i - 1, j))
        builder.Quad(inside, {a, -thick, c}, {a, 0, c}, {a, 0, d}, {a, -thick, d}, Grain::kY);
      if (!open(i + 1, j))
        builder.Quad(inside, {b, 0, c}, {b, -thick, c}, {b, -thick, d}, {b, 0, d}, Grain::kY);
      if (!open(i, j - 1))
        builder.Quad(inside, {a, 0, c}, {a, -thick, c}, {b, -thick, c}, {b, 0, c});
      if (!open(i, j + 1))
        builder.Quad(inside, {a, -thick, d}, {a, 0, d}, {b, 0, d}, {b, -thick, d});
    }
    const float bottom = z.front(), top = z.back();
    builder.Quad(outside, {a, 0, bottom}, {b, 0, bottom}, {b, -thick, bottom}, {a, -thick, bottom});
    builder.Quad(outside, {a, -thick, top}, {b, -thick, top}, {b, 0, top}, {a, 0, top});
  }
  // The corner post at the wall's start: this wall shows its outer face there, the neighbour its
  // own.
  for (int j = 0; j < rows; ++j) {
    const float c = z[j], d = z[j + 1];
    builder.Quad(outside, {-thick, -thick, c}, {0, -thick, c}, {0, -thick, d}, {-thick, -thick, d});
    builder.Quad(outside, {-thick, 0, c}, {-thick, -thick, c}, {-thick, -thick, d}, {-thick, 0, d},
                 Grain::kY);
  }
  const float bottom = z.front(), top = z.back();
  builder.Quad(outside, {-thick, 0, bottom}, {0, 0, bottom}, {0, -thick, bottom},
               {-thick, -thick, bottom});
  builder.Quad(outside, {-thick, -thick, top}, {0, -thick, top}, {0, 0, top}, {-thick, 0, top});
}

Mesh MakeWalls(const v1::Room& room) {
  PartBuilder builder;
  const std::vector<float> cuts = HeightCuts(room);
  for (int wall = 0; wall < 4; ++wall) AddWall(builder, room, wall, cuts);
  return builder.Take();
}

Mesh MakeSlab(const v1::Room& room, const std::string& slot,
              const std::vector<std::string>& families, float bottom) {
  PartBuilder builder;
  const float t = static_cast<float>(room.wall_thickness_m());
  builder.Box(builder.Slot(slot, families), {-t, -t, bottom},
              {static_cast<float>(room.width_m()) + t, static_cast<float>(room.depth_m()) + t,
               bottom + kSlab_m},
              0, room.width_m() >= room.depth_m() ? Grain::kX : Grain::kY);
  return builder.Take();
}

// Free stretches of a wall at the foot, between openings that come down to the skirting.
std::vector<std::pair<float, float>> SkirtingRuns(const v1::Room& room, int wall) {
  const WallFrame frame = FrameOfWall(room, wall);
  std::vector<Hole> holes = HolesOf(room, wall);
  std::sort(holes.begin(), holes.end(),
            [](const Hole& a, const Hole& b) { return a.left < b.left; });
  constexpr float casing = 0.1f;  // The widest door casing: the skirting ends against it.
  std::vector<std::pair<float, float>> runs;
  float from = 0;
  for (const Hole& hole : holes) {
    if (hole.bottom > static_cast<float>(room.skirting_height_m())) continue;
    if (hole.left - casing > from + 0.02f) runs.push_back({from, hole.left - casing});
    from = hole.right + casing;
  }
  const float length = static_cast<float>(frame.length_m);
  if (length > from + 0.02f) runs.push_back({from, length});
  return runs;
}

Mesh MakeSkirting(const v1::Room& room) {
  PartBuilder builder;
  const uint16_t slot = builder.Slot("skirting", {"paint", "wood"});
  const float h = static_cast<float>(room.skirting_height_m());
  // Out of the wall (y) and up (z), counter-clockwise from +x; the back and the foot stand in wall
  // and floor.
  const std::vector<Vec2f> profile = {
      {-0.003f, -0.003f},    {0.015f, -0.003f},    {0.015f, 0.72f * h},
      {0.0135f, 0.80f * h},  {0.0095f, 0.86f * h}, {0.0085f, 0.93f * h},
      {0.0055f, 0.985f * h}, {0.002f, h},          {-0.003f, h}};
  for (int wall = 0; wall < 4; ++wall) {
    builder.SetFrame(FrameOfWall(room, wall).WorldFromWall());
    for (const auto& [from, to] : SkirtingRuns(room, wall)) {
      builder.ExtrudeX(slot, profile, from, to);
    }
  }
  return builder.Take();
}

}  // namespace

WallFrame FrameOfWall(const v1::Room& room, int wall) {
  const double w = room.width_m(), d = room.depth_m();
  constexpr double half_turn = 3.14159265358979323846;
  switch (wall) {
    case 0:
      return {{0, 0}, {1, 0}, {0, 1}, w, false, 0};
    case 1:
      return {{w, 0}, {0, 1}, {-1, 0}, d, false, half_turn / 2};
    case 2:
      return {{w, d}, {-1, 0}, {0, -1}, w, true, half_turn};
    default:
      return {{0, d}, {0, -1}, {1, 0}, d, true, -half_turn / 2};
  }
}

std::vector<std::string> RoomParts(const v1::Room& room) {
  std::vector<std::string> parts = {"floor", "ceiling", "walls", "skirting"};
  int doors = 0, windows = 0;
  for (const v1::Opening& opening : room.openings()) {
    if (opening.kind() == v1::Opening::KIND_DOOR) {
      parts.push_back("door_" + std::to_string(doors++));
    } else {
      parts.push_back("window_" + std::to_string(windows++));
    }
  }
  return parts;
}

absl::StatusOr<Mesh> MakeRoomPart(const v1::Room& room, std::string_view part) {
  if (part == "floor") return MakeSlab(room, "floor", {"wood floor", "tiles", "carpet"}, -kSlab_m);
  if (part == "ceiling") {
    return MakeSlab(room, "ceiling", {"paint", "plaster"}, static_cast<float>(room.height_m()));
  }
  if (part == "walls") return MakeWalls(room);
  if (part == "skirting") return MakeSkirting(room);
  int doors = 0, windows = 0;
  for (const v1::Opening& opening : room.openings()) {
    const bool door = opening.kind() == v1::Opening::KIND_DOOR;
    const std::string name =
        door ? "door_" + std::to_string(doors++) : "window_" + std::to_string(windows++);
    if (name == part) return door ? MakeDoor(room, opening) : MakeWindow(room, opening);
  }
  return MakeError(absl::StatusCode::kNotFound,
                   "the room has no part \"" + std::string(part) + "\"");
}

}  // namespace parallax
