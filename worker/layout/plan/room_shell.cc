#include "worker/layout/plan/room_shell.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "worker/assets/building/staircases.h"
#include "worker/layout/plan/openings.h"
#include "worker/layout/plan/part_builder.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

using Grain = PartBuilder::Grain;

constexpr float kSlab_m = 0.2f;  // Floor and ceiling.
// Walls reach this far into the slabs: no light leaks along the edges.
constexpr float kReach_m = 0.05f;

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
  const float thick = static_cast<float>(frame.depth_m);
  const float before = static_cast<float>(FrameOfWall(room, (wall + 3) % 4).depth_m);
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
    builder.Quad(outside, {-before, -thick, c}, {0, -thick, c}, {0, -thick, d},
                 {-before, -thick, d});
    builder.Quad(outside, {-before, 0, c}, {-before, -thick, c}, {-before, -thick, d},
                 {-before, 0, d}, Grain::kY);
  }
  const float bottom = z.front(), top = z.back();
  builder.Quad(outside, {-before, 0, bottom}, {0, 0, bottom}, {0, -thick, bottom},
               {-before, -thick, bottom});
  builder.Quad(outside, {-before, -thick, top}, {0, -thick, top}, {0, 0, top}, {-before, 0, top});
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
  const auto under = [&](int wall) { return static_cast<float>(FrameOfWall(room, wall).depth_m); };
  builder.Box(builder.Slot(slot, families), {-under(3), -under(0), bottom},
              {static_cast<float>(room.width_m()) + under(1),
               static_cast<float>(room.depth_m()) + under(2), bottom + kSlab_m},
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

// A moulding where walls and ceiling meet.
Mesh MakeCornice(const v1::Room& room) {
  PartBuilder builder;
  const uint16_t slot = builder.Slot("cornice", {"paint", "plaster"});
  const float h = static_cast<float>(room.height_m()), c = static_cast<float>(room.cornice_m());
  const std::vector<Vec2f> profile = {{-0.003f, h - c},        {0.010f, h - c},
                                      {0.016f, h - 0.93f * c}, {0.86f * c, h - 0.14f * c - 0.006f},
                                      {0.9f * c, h - 0.008f},  {0.9f * c, h + 0.003f},
                                      {-0.003f, h + 0.003f}};
  for (int wall = 0; wall < 4; ++wall) {
    const WallFrame frame = FrameOfWall(room, wall);
    builder.SetFrame(frame.WorldFromWall());
    builder.ExtrudeX(slot, profile, 0, static_cast<float>(frame.length_m));
  }
  return builder.Take();
}

Mesh MakePillars(const v1::Room& room) {
  PartBuilder builder;
  const uint16_t shaft = builder.Slot("wall", {"paint", "plaster", "brick"});
  const uint16_t foot = builder.Slot("skirting", {"paint", "wood"});
  const float h = static_cast<float>(room.height_m()) + 0.01f;
  const float skirting = static_cast<float>(room.skirting_height_m());
  for (const v1::Pillar& pillar : room.pillars()) {
    const Vec3f at(static_cast<float>(pillar.x_m()), static_cast<float>(pillar.y_m()), 0);
    const float r = 0.5f * static_cast<float>(pillar.side_m()), out = r + 0.013f;
    // Papered and tiled like the walls: their patterns stand upright on it, too.
    builder.Box(shaft, at + Vec3f(-r, -r, -0.01f), at + Vec3f(r, r, h), 0.004f, Grain::kX);
    builder.Box(foot, at + Vec3f(-out, -out, -0.004f), at + Vec3f(out, out, skirting), 0.004f,
                Grain::kX);
  }
  return builder.Take();
}

bool IsSpiral(const v1::Stairs& stairs) {
  return Rng(SceneSeed{stairs.seed()}, "stairs").Child("spiral").Bernoulli(0.3);
}

std::string StairClassOf(const v1::Stairs& stairs) {
  return IsSpiral(stairs) ? "SpiralStaircase" : "UShapedStaircase";
}

// The flight of the room's Stairs, the upper landing before it, a rail where the landing ends over
// the first flight.
Mesh MakeStairs(const v1::Room& room) {
  const v1::Stairs& stairs = room.stairs();
  Rng rng(SceneSeed{stairs.seed()}, "stairs");
  StairParams params;
  params.body = static_cast<StairBody>(rng.UniformInt(0, static_cast<int>(StairBody::kCount) - 1));
  params.rail = static_cast<StairRail>(rng.UniformInt(0, static_cast<int>(StairRail::kCount) - 1));
  constexpr float kGap_m = 0.12f;  // Between the two flights, as the generator leaves it.
  params.width_m = 0.5f * (static_cast<float>(stairs.width_m()) - kGap_m);
  params.run_m = 0.25f;
  const int flight = static_cast<int>(
      std::lround((static_cast<float>(stairs.length_m()) - params.width_m) / params.run_m));
  params.steps = 2 * flight + 1;
  params.rise_m = static_cast<float>(stairs.rise_m()) / static_cast<float>(params.steps);
  params.seed = stairs.seed();
  const float landing = static_cast<float>(stairs.landing_m());
  const float width = static_cast<float>(room.width_m()),
              rise = static_cast<float>(stairs.rise_m());
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.translation() = Vec3f(0.5f * width, landing + 0.012f, 0.0005f);
  place.linear() = Eigen::AngleAxisf(3.14159265f, Vec3f::UnitZ()).toRotationMatrix();

  PartBuilder builder;
  const uint16_t slab = builder.Slot("floor", {"wood floor", "tiles", "carpet"});
  const uint16_t wood = builder.Slot("rail", {"wood", "metal"});
  builder.Box(slab, {-0.004f, -0.004f, rise - 0.22f}, {width + 0.004f, landing, rise}, 0,
              Grain::kX);
  const float y = landing - 0.04f, end = 0.5f * width - 0.08f, top = rise + 0.95f;
  builder.Box(wood, {0.001f, y - 0.022f, top - 0.045f}, {end + 0.03f, y + 0.022f, top}, 0.008f,
              Grain::kX);
  const int posts = 8;
  for (int i = 0; i <= posts; ++i) {
    const float x = 0.03f + (end - 0.03f) * static_cast<float>(i) / posts;
    const float r = i == posts ? 0.028f : 0.011f;
    builder.Box(wood, {x - r, y - r, rise - 0.002f}, {x + r, y + r, top - 0.04f}, 0.003f,
                Grain::kZ);
  }
  Mesh mesh = builder.Take();
  if (IsSpiral(stairs)) {
    // One turn and a half: it starts heading away from the landing and arrives heading towards it.
    params.width_m = 0.5f * width - 0.16f;
    params.turn_rad = 3 * 3.14159265f;
    if (params.rail == StairRail::kGlass) params.rail = StairRail::kBalusters;
    place.translation().y() += 0.5f * width - 0.04f;
    Append(mesh, MakeSpiralStaircase(params).mesh, place);
  } else {
    // Wherever its own origin is: its landing halfway up lies at the far wall.
    const Mesh flights = MakeUShapedStaircase(params).mesh;
    const Box3f box = flights.Bounds();
    place.translation().x() = 0.5f * width + box.center().x();  // Turned by half a circle.
    place.translation().y() = static_cast<float>(room.depth_m()) - 0.02f + box.min().y();
    Append(mesh, flights, place);
  }
  return mesh;
}

const char* NameOf(v1::Opening::Kind kind) {
  switch (kind) {
    case v1::Opening::KIND_DOOR:
      return "door_";
    case v1::Opening::KIND_PASSAGE:
      return "passage_";
    default:
      return "window_";
  }
}

// Calls visit(name, opening) for each opening whose filling is this room's.
template <typename Visit>
void ForEachFilling(const v1::Room& room, Visit visit) {
  std::map<std::string, int> count;
  for (const v1::Opening& opening : room.openings()) {
    if (opening.mated()) continue;
    const std::string kind = NameOf(opening.kind());
    visit(fmt::format("{}{}", kind, count[kind]++), opening);
  }
}

absl::StatusOr<Mesh> MakeLocalPart(const v1::Room& room, std::string_view part) {
  if (part == "floor") return MakeSlab(room, "floor", {"wood floor", "tiles", "carpet"}, -kSlab_m);
  if (part == "ceiling") {
    return MakeSlab(room, "ceiling", {"paint", "plaster"}, static_cast<float>(room.height_m()));
  }
  if (part == "walls") return MakeWalls(room);
  if (part == "skirting") return MakeSkirting(room);
  if (part == "cornice" && room.cornice_m() > 0) return MakeCornice(room);
  if (part == "pillars" && room.pillars_size() > 0) return MakePillars(room);
  if (part == "stairs" && room.has_stairs()) return MakeStairs(room);
  std::optional<Mesh> found;
  ForEachFilling(room, [&](const std::string& name, const v1::Opening& opening) {
    if (name != part) return;
    found = opening.kind() == v1::Opening::KIND_WINDOW ? MakeWindow(room, opening)
                                                       : MakeDoor(room, opening);
  });
  if (found) return *std::move(found);
  return NotFound("the room has no part \"{}\"", part);
}

}  // namespace

WallFrame FrameOfWall(const v1::Room& room, int wall) {
  const double w = room.width_m(), d = room.depth_m();
  constexpr double half_turn = 3.14159265358979323846;
  const double depth =
      room.wall_depth_m_size() == 4 ? room.wall_depth_m(wall) : room.wall_thickness_m();
  switch (wall) {
    case 0:
      return {{0, 0}, {1, 0}, {0, 1}, w, false, 0, depth};
    case 1:
      return {{w, 0}, {0, 1}, {-1, 0}, d, false, half_turn / 2, depth};
    case 2:
      return {{w, d}, {-1, 0}, {0, -1}, w, true, half_turn, depth};
    default:
      return {{0, d}, {0, -1}, {1, 0}, d, true, -half_turn / 2, depth};
  }
}

std::vector<std::string> RoomParts(const v1::Room& room) {
  std::vector<std::string> parts = {"floor", "ceiling", "walls", "skirting"};
  if (room.cornice_m() > 0) parts.push_back("cornice");
  if (room.pillars_size() > 0) parts.push_back("pillars");
  if (room.has_stairs()) parts.push_back("stairs");
  ForEachFilling(room, [&](const std::string& name, const v1::Opening&) { parts.push_back(name); });
  return parts;
}

std::vector<std::string> BuildingClasses() {
  return {"PanelDoor", "GlassPanelDoor",   "LiteDoor",       "LouverDoor",
          "Window",    "UShapedStaircase", "SpiralStaircase"};
}

std::string ClassOfPart(const v1::Room& room, std::string_view part) {
  std::string name(part.substr(0, part.find('_')));
  ForEachFilling(room, [&](const std::string& filling, const v1::Opening& opening) {
    if (filling == part && opening.kind() == v1::Opening::KIND_DOOR) name = LeafClassOf(opening);
  });
  if (part == "stairs") name = StairClassOf(room.stairs());
  name[0] = static_cast<char>(name[0] >= 'a' ? name[0] - 'a' + 'A' : name[0]);
  return name;
}

absl::StatusOr<Mesh> MakeRoomPart(const v1::Room& room, std::string_view part) {
  ASSIGN_OR_RETURN(Mesh mesh, MakeLocalPart(room, part));
  const Vec3f origin = Vec3d(room.origin_x_m(), room.origin_y_m(), room.floor_z_m()).cast<float>();
  if (!origin.isZero()) {
    for (Vec3f& p : mesh.positions) p += origin;
  }
  return mesh;
}

int RoomIndexOf(const v1::House& house, uint32_t object_index) {
  for (int i = 1; i < house.rooms_size(); ++i) {
    const auto& own = house.rooms(i).object_index();
    if (std::binary_search(own.begin(), own.end(), object_index)) return i;
  }
  return 0;
}

absl::StatusOr<Mesh> MakeRoomPart(const v1::House& house, const v1::SceneObject& object) {
  if (house.rooms().empty()) {
    return NotFound("the house has no rooms");
  }
  return MakeRoomPart(house.rooms(RoomIndexOf(house, object.index())), object.part());
}

}  // namespace parallax
