#include "worker/layout/plan/open_plan.h"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace parallax {
namespace {

// These keep their doors in open plans.
constexpr std::string_view kShutRooms[] = {"bathroom", "closet", "stairs"};
constexpr double kPassage_m[] = {1.8, 4.0};
constexpr double kLintelOfPassage_m[] = {0.15, 0.45};
constexpr double kWideOpen_rad[] = {1.2, 1.4};

bool StaysShut(const v1::Room& room) {
  return std::find(std::begin(kShutRooms), std::end(kShutRooms), room.kind()) !=
         std::end(kShutRooms);
}

}  // namespace

void OpenUp(const v1::RoomConfig& config, const v1::Room& a, const v1::Room& b, Rng rng,
            v1::Opening& door) {
  const bool shut = StaysShut(a) || StaysShut(b);
  if (rng.Bernoulli(shut ? 0 : config.open_plan_p())) {
    door.set_kind(v1::Opening::KIND_PASSAGE);
    door.set_width_m(rng.Uniform(kPassage_m[0], kPassage_m[1]));
    const double lower = std::min(a.height_m(), b.height_m());
    const double lintel = rng.Uniform(kLintelOfPassage_m[0], kLintelOfPassage_m[1]);
    door.set_height_m(std::max(door.height_m(), lower - lintel));
  }
  if (door.kind() == v1::Opening::KIND_DOOR && rng.Bernoulli(config.open_door_p())) {
    door.set_open_rad(rng.Uniform(kWideOpen_rad[0], kWideOpen_rad[1]));
  }
}

}  // namespace parallax
