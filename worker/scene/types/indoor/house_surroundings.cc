#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

constexpr float kMargin_m = 1e-3f;
constexpr float kFrame_m = 0.012f;

Vec3d OriginOf(const v1::Room& room) {
  return {room.origin_x_m(), room.origin_y_m(), room.floor_z_m()};
}
Vec3d SizeOf(const v1::Room& room) { return {room.width_m(), room.depth_m(), room.height_m()}; }

float WallDepth(const v1::Room& room, int wall) {
  return static_cast<float>(room.wall_depth_m_size() == 4 ? room.wall_depth_m(wall)
                                                          : room.wall_thickness_m());
}

// At the outer face of the wall.
SkyPortal PortalOf(const v1::Room& room, const v1::Opening& opening) {
  const Vec3f origin = OriginOf(room).cast<float>(), size = SizeOf(room).cast<float>();
  const auto start = static_cast<float>(opening.center_m() - 0.5 * opening.width_m());
  const auto sill = static_cast<float>(opening.sill_m());
  const bool along_x = opening.wall() == 0 || opening.wall() == 2;
  const bool far = opening.wall() == 1 || opening.wall() == 2;
  const float depth = WallDepth(room, opening.wall());
  const float across = far ? (along_x ? size.y() : size.x()) + depth : -depth;
  const Vec3f along = along_x ? Vec3f::UnitX() : Vec3f::UnitY();
  SkyPortal portal;
  portal.corner = origin + (along_x ? Vec3f(start, across, sill) : Vec3f(across, start, sill));
  portal.edge_u = static_cast<float>(opening.width_m()) * along;
  portal.edge_v = static_cast<float>(opening.height_m()) * Vec3f::UnitZ();
  portal.normal = (far ? 1.0f : -1.0f) * (along_x ? Vec3f::UnitY() : Vec3f::UnitX());
  portal.depth_m = depth;
  return portal;
}

SkyEnclosure EnclosureOf(const v1::Room& room, bool open_top) {
  const Vec3f origin = OriginOf(room).cast<float>(), size = SizeOf(room).cast<float>();
  // A little less than the walls' outer faces, whose own points are outside.
  const auto rim = [&](int wall) { return std::max(0.0f, WallDepth(room, wall) - kMargin_m); };
  SkyEnclosure enclosure;
  enclosure.box = Box3f(origin - Vec3f(rim(3), rim(0), rim(0)),
                        origin + size + Vec3f(rim(1), rim(2), open_top ? -kMargin_m : rim(0)));
  for (const v1::Opening& opening : room.openings()) {
    enclosure.portals.push_back(PortalOf(room, opening));
  }
  if (open_top) {
    enclosure.portals.push_back({origin + Vec3f(0, 0, size.z()),
                                 {size.x(), 0, 0},
                                 {0, size.y(), 0},
                                 Vec3f::UnitZ(),
                                 WallDepth(room, 0)});
  }
  return enclosure;
}

// Surfaces of the room itself lie on the box; a millimetre keeps them in.
Box3f InteriorOf(const v1::Room& room) {
  const Vec3d low = OriginOf(room), high = low + SizeOf(room);
  return {low.cast<float>() - Vec3f::Constant(kMargin_m),
          high.cast<float>() + Vec3f::Constant(kMargin_m)};
}

// The hole of an opening through its masonry: frame, lining, leaf and threshold are the house's.
Box3f HoleOf(const v1::Room& room, const v1::Opening& opening) {
  const SkyPortal portal = PortalOf(room, opening);
  const Vec3f inner = portal.corner - portal.depth_m * portal.normal;
  const float depth =
      opening.depth_m() > 0 ? static_cast<float>(opening.depth_m()) : portal.depth_m;
  Box3f hole(inner);
  hole.extend(inner + portal.edge_u + portal.edge_v + depth * portal.normal);
  // Frames reach a little into the masonry around them and out of its faces.
  return {hole.min() - Vec3f::Constant(kFrame_m), hole.max() + Vec3f::Constant(kFrame_m)};
}

}  // namespace

Surroundings HouseSurroundings(const v1::Place& place) {
  const v1::House& house = place.house();
  Surroundings surroundings;
  surroundings.ground_below_horizon = !house.has_landscape();
  for (int i = 0; i < house.rooms_size(); ++i) {
    const v1::Room& room = house.rooms(i);
    if (!(room.width_m() > 0)) continue;
    if (i == 0) surroundings.bounds = {OriginOf(room), OriginOf(room) + SizeOf(room)};
    surroundings.enclosures.push_back(EnclosureOf(room, i == 0 && house.ceiling_removed()));
    surroundings.interiors.push_back(InteriorOf(room));
    for (const v1::Opening& opening : room.openings()) {
      if (!opening.mated()) surroundings.interiors.push_back(HoleOf(room, opening));
    }
  }
  return surroundings;
}

}  // namespace parallax
