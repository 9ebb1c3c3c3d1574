#include "worker/layout/room_plan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "worker/layout/room_table.h"

namespace parallax {
namespace {

constexpr double kCornerGap_m =
    0.25;  // Least masonry between an opening and a corner or another opening.
constexpr double kOpeningGap_m = 0.35;
constexpr double kLintel_m = 0.12;  // Least masonry above an opening.
constexpr int kTries = 40;

double WallLength(const v1::Room& room, int wall) {
  return wall % 2 == 0 ? room.width_m() : room.depth_m();
}

bool Fits(const v1::Room& room, const v1::Opening& candidate) {
  const double low = candidate.center_m() - candidate.width_m() / 2;
  const double high = candidate.center_m() + candidate.width_m() / 2;
  if (low < kCornerGap_m || high > WallLength(room, candidate.wall()) - kCornerGap_m) return false;
  for (const v1::Opening& other : room.openings()) {
    if (other.wall() != candidate.wall()) continue;
    const double free = std::abs(other.center_m() - candidate.center_m()) -
                        (other.width_m() + candidate.width_m()) / 2;
    if (free < kOpeningGap_m) return false;
  }
  return true;
}

std::optional<v1::Opening> PlaceOpening(const v1::Room& room, v1::Opening opening, Rng& rng,
                                        double near_corner_p) {
  for (int i = 0; i < kTries; ++i) {
    opening.set_wall(rng.UniformInt(0, 3));
    const double length = WallLength(room, opening.wall());
    const double reach = length / 2 - opening.width_m() / 2 - kCornerGap_m;
    const double u = rng.Uniform(), side = rng.Bernoulli(0.5) ? 1 : -1;
    const bool near_corner = rng.Bernoulli(near_corner_p);
    if (reach < 0) continue;
    const double off = near_corner ? reach - u * std::min(0.6, reach) : reach * u;
    opening.set_center_m(length / 2 + side * off);
    if (Fits(room, opening)) return opening;
  }
  return std::nullopt;
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
  window.set_kind(v1::Opening::KIND_WINDOW);
  window.set_width_m(rng.Uniform(0.9, 2.3));
  const double top = std::min(rng.Uniform(2.0, 2.35), room.height_m() - kLintel_m);
  const bool tall = rng.Bernoulli(0.15);
  const double sill = tall ? rng.Uniform(0.08, 0.3) : rng.Uniform(0.75, 1.05);
  window.set_sill_m(std::min(sill, top - 0.6));
  window.set_height_m(top - window.sill_m());
  window.set_seed(rng.Seed());
  return window;
}

}  // namespace

absl::StatusOr<v1::Room> DrawRoom(const v1::RoomConfig& config, SceneSeed seed) {
  const Rng root(seed, "layout/room");
  v1::Room room;
  if (config.kinds().empty()) return absl::InvalidArgumentError("room.kinds is empty");
  for (const std::string& kind : config.kinds()) {
    if (FindRoomTable(kind) == nullptr) {
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "room.kinds: unknown kind \"" + kind + "\"");
    }
  }
  room.set_kind(root.Child("kind").Pick(config.kinds()));
  room.set_width_m(Draw(config.width_m(), root.Child("width").Uniform()));
  room.set_depth_m(Draw(config.depth_m(), root.Child("depth").Uniform()));
  room.set_height_m(Draw(config.height_m(), root.Child("height").Uniform()));
  if (!(std::min(room.width_m(), room.depth_m()) >= 1.5 && room.height_m() >= 1.9)) {
    return absl::InvalidArgumentError("room: smaller than 1.5 m x 1.5 m x 1.9 m");
  }
  room.set_wall_thickness_m(root.Child("walls").Uniform(0.14, 0.28));
  room.set_skirting_height_m(root.Child("skirting").Uniform(0.06, 0.14));
  room.set_window_glass(config.window_glass());

  const int doors =
      static_cast<int>(std::lround(Draw(config.doors(), root.Child("doors").Uniform())));
  const int windows =
      static_cast<int>(std::lround(Draw(config.windows(), root.Child("windows").Uniform())));
  for (int i = 0; i < doors; ++i) {
    Rng rng = root.Child("door", static_cast<uint64_t>(i));
    const auto door = PlaceOpening(room, DrawDoor(room, rng), rng, 0.6);
    if (door) *room.add_openings() = *door;
  }
  for (int i = 0; i < windows; ++i) {
    Rng rng = root.Child("window", static_cast<uint64_t>(i));
    const auto window = PlaceOpening(room, DrawWindow(room, rng), rng, 0.0);
    if (window) *room.add_openings() = *window;
  }
  return room;
}

}  // namespace parallax
