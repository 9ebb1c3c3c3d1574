#include <fmt/core.h>

#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

std::string SizeText(const v1::Room& room) {
  return fmt::format("{:.2f} x {:.2f} x {:.2f} m", room.width_m(), room.depth_m(), room.height_m());
}

GroundPlan PlanOf(const v1::Room& room) {
  GroundPlan plan;
  const Vec3d origin(room.origin_x_m(), room.origin_y_m(), room.floor_z_m());
  plan.extent = {origin, origin + Vec3d(room.width_m(), room.depth_m(), room.height_m())};
  for (const v1::Opening& opening : room.openings()) {
    plan.gaps.push_back({opening.wall(), opening.center_m() - opening.width_m() / 2,
                         opening.center_m() + opening.width_m() / 2,
                         opening.kind() == v1::Opening::KIND_DOOR ? 'D' : '='});
  }
  return plan;
}

}  // namespace

SceneDescription DescribeHouse(const v1::Scene& scene) {
  SceneDescription description;
  const v1::House& house = scene.place().house();
  if (house.rooms().empty()) return description;
  const v1::Room& first = house.rooms(0);
  description.kind = first.kind();
  if (!(first.width_m() > 0 && first.depth_m() > 0)) return description;
  description.lines.push_back(first.kind() + (first.hall() ? ", a hall, " : " ") + SizeText(first) +
                              (house.ceiling_removed() ? ", ceiling removed" : ""));
  for (int i = 1; i < house.rooms_size(); ++i) {
    const v1::Room& other = house.rooms(i);
    description.lines.push_back(fmt::format("  beside it: {} {} at {:.2f} {:.2f} {:.2f}",
                                            other.name(), SizeText(other), other.origin_x_m(),
                                            other.origin_y_m(), other.floor_z_m()));
  }
  if (house.has_landscape()) {
    const v1::Terrain& land = house.landscape();
    description.lines.push_back(fmt::format("  around it: {} in {}, {} things, clearing {:.2f} m",
                                            land.biome(), land.season(), land.instances(),
                                            land.plot().clearing_m()));
  }
  description.plan = PlanOf(first);
  return description;
}

}  // namespace parallax
