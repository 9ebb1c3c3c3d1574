#include "worker/scene/types/indoor/indoor.h"

#include <algorithm>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/config/config.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/scene/types/indoor/dress_house.h"
#include "worker/scene/types/indoor/house.h"
#include "worker/scene/types/indoor/landscape.h"
#include "worker/scene/types/nature/nature.h"

namespace parallax {
namespace {

absl::StatusOr<std::variant<v1::Layout, Rejected>> SolveHouse(const v1::SceneConfig& config,
                                                              SceneSeed seed,
                                                              const CancelToken& cancel) {
  // Furniture is left out by DressHouse, so that a variant without it shares layout and rigs.
  v1::SceneConfig furnished = config;
  furnished.mutable_furniture()->set_enabled(true);
  return SolveLayout(furnished, seed, cancel);
}

// A room's depths are looked up by wall, and a landscape's views by room.
absl::Status CheckHouse(const v1::Place& place) {
  const v1::House& house = place.house();
  if (house.has_landscape() && house.rooms().empty()) {
    return InvalidArgument("place: a landscape around a house of no rooms");
  }
  for (const v1::Room& room : house.rooms()) {
    for (const v1::Opening& opening : room.openings()) {
      if (opening.wall() >= 0 && opening.wall() <= 3) continue;
      return InvalidArgument("place: room {} has an opening in wall {}, allowed are 0 to 3",
                             Quoted(room.kind()), opening.wall());
    }
  }
  return absl::OkStatus();
}

bool HasLandscape(const v1::Scene& scene) { return scene.place().house().has_landscape(); }

absl::StatusOr<Mesh> MakeHousePart(const v1::Scene& scene, const v1::SceneObject& object) {
  const v1::House& house = scene.place().house();
  if (object.part() == kLandscapePart && HasLandscape(scene)) {
    return GroundPart(house.landscape(), ViewsOut(scene));
  }
  return MakeRoomPart(house, object);
}

absl::Status GrowAroundHouse(const v1::Scene& scene, SceneGeometry& geometry) {
  if (!HasLandscape(scene)) return absl::OkStatus();
  return GrowLand(scene, scene.place().house().landscape(), ViewsOut(scene), geometry);
}

std::optional<v1::SceneObject> GrownByHouse(const v1::Scene& scene, uint32_t index) {
  if (!HasLandscape(scene)) return std::nullopt;
  return GrownThing(scene.place().house().landscape(), index);
}

// Returns the mean of room.rooms, by even quantiles: a multiple of each number of rooms.
double MeanRooms(const v1::RoomConfig& room) {
  constexpr int kQuantiles = 840;
  double sum = 0;
  for (int i = 0; i < kQuantiles; ++i) sum += Draw(room.rooms(), (i + 0.5) / kQuantiles);
  return std::max(1.0, sum / kQuantiles);
}

// Core-seconds in which one room is furnished. bench_solve --scenes 50 --kind any --mode reduced,
// and --mode full: solve_cpu_s 0.82 and 0.91, shared out as layout_s and dress_s are. `best` adds
// annealings for its budget.
double RoomSeconds(const v1::SolverConfig& solver) {
  if (solver.mode() == v1::SolverConfig::MODE_BEST) return 0.26 + solver.budget_s();
  return solver.mode() == v1::SolverConfig::MODE_FULL ? 0.30 : 0.26;
}

// bench_solve --rooms 8 --kind any --scenes 3: 3.0 s, so each room costs as much as the first.
SceneCosts HouseCosts(const v1::SceneConfig& config) {
  // depth_check depth --only default, halls and landscape: CPU seconds a scene.
  const double halls = config.room().hall_p(), landscapes = config.room().landscape_p();
  return {.layout_s = MeanRooms(config.room()) * RoomSeconds(config.solver()) + 0.9 * halls,
          .dress_s = 0.58 + 0.2 * landscapes,
          .rigs_share_light = true,
          .build_s = 0.5 * halls + 0.2 * landscapes};
}

}  // namespace

const SceneType kIndoorScenes = {
    .type = v1::SCENE_TYPE_INDOOR,
    .place = v1::Place::kHouse,
    .layout = &SolveHouse,
    .rigs = &PlaceHouseRigs,
    .dress = &DressHouse,
    .part = &MakeHousePart,
    .surroundings = &HouseSurroundings,
    .costs = &HouseCosts,
    .describe = &DescribeHouse,
    .expand = &GrowAroundHouse,
    .grown = &GrownByHouse,
    .check = &CheckHouse,
};

}  // namespace parallax
