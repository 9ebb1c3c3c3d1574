#include "worker/layout/anneal/fixtures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "worker/layout/plan/openings.h"
#include "worker/layout/plan/room_plan.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

constexpr double kHeadroom_m = 1.95;  // Lamps hang above people.
constexpr int kModels = 4;
constexpr double kRoomHeight_m = 2.7;

bool Excluded(const v1::AssetConfig& assets, const std::string& class_name) {
  return std::find(assets.exclude().begin(), assets.exclude().end(), class_name) !=
         assets.exclude().end();
}

// Draws the first model that leaves headroom, else the shortest.
absl::StatusOr<const PooledAsset*> DrawCeilingLamp(const Rng& root, double height_m,
                                                   AssetPool& pool) {
  const PooledAsset* best = nullptr;
  for (uint64_t k = 0; k < kModels; ++k) {
    ASSIGN_OR_RETURN(const PooledAsset* lamp,
                     pool.Get("CeilingClassicLamp", root.Child("model", k).Seed()));
    if (best == nullptr || lamp->bounds.min().z() > best->bounds.min().z()) best = lamp;
    if (height_m + lamp->bounds.min().z() >= kHeadroom_m) return lamp;
  }
  return best;
}

// A hall's lamps: equal ones in the middles of its bays, brighter in high halls. Their power is
// that of a room of the same floor as if it stood lower.
absl::Status HangInRows(const v1::Room& room, const v1::AssetConfig& assets, const Rng& root,
                        const Vec3d& power_w, AssetPool& pool, std::vector<Fixture>& fixtures) {
  if (!ClassAllowed(assets, "CeilingClassicLamp")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const PooledAsset* lamp,
                   DrawCeilingLamp(root.Child("ceiling"), room.height_m(), pool));
  const HallBays bays = HallBays::Of(room);
  const double brighter = room.height_m() / kRoomHeight_m;
  for (int i = 0; i < bays.along_x; ++i) {
    for (int k = 0; k < bays.along_y; ++k) {
      Fixture fixture;
      fixture.asset = lamp;
      fixture.position = {(i + 0.5) / bays.along_x * room.width_m(),
                          (k + 0.5) / bays.along_y * room.depth_m(),
                          room.height_m() - double{lamp->bounds.max().z()} - 0.0005};
      fixture.relation = "on_ceiling";
      fixture.power_w = power_w * (brighter / (bays.along_x * bays.along_y));
      fixtures.push_back(fixture);
    }
  }
  return absl::OkStatus();
}

}  // namespace

bool ClassAllowed(const v1::AssetConfig& assets, const std::string& class_name) {
  const AssetClass* found = FindAssetClass(class_name);
  return found != nullptr && found->on_by_default && !Excluded(assets, class_name);
}

Vec3d LampColor(double whiteness) {
  const Vec3d color = Vec3d(1.0, 0.70, 0.42) * (1 - whiteness) + Vec3d(1.0, 0.97, 0.93) * whiteness;
  return color / color.mean();
}

std::vector<WallStrip> StripsOf(const v1::Room& room) {
  std::vector<WallStrip> strips;
  for (const v1::Opening& o : room.openings()) {
    const double middle = FrameOfWall(room, o.wall()).LocalOf(o.center_m());
    const double more = IsDressed(o) ? kDressing_m : 0;
    const double half = o.width_m() / 2 + more;
    strips.push_back({o.wall(), middle - half, middle + half, o.sill_m() - more,
                      o.sill_m() + o.height_m() + more, o.kind() != v1::Opening::KIND_WINDOW});
  }
  return strips;
}

absl::StatusOr<std::vector<Fixture>> PlaceFixtures(const v1::Room& room,
                                                   const v1::AssetConfig& assets, SceneSeed seed,
                                                   AssetPool& pool) {
  const Rng root(seed, "layout/fixtures");
  std::vector<Fixture> fixtures;
  const double w = room.width_m(), d = room.depth_m(), area = w * d;
  Rng draw = root.Child("light");
  // Typical installations: 6 to 11 radiant watts a square metre, from one lamp or two.
  const double total_w = area * draw.Uniform(6, 11);
  const Vec3d color = LampColor(draw.Uniform());
  const bool two = area > 16 && draw.Bernoulli(0.6);
  if (room.hall()) {
    RETURN_IF_ERROR(HangInRows(room, assets, root, color * total_w, pool, fixtures));
  } else if (ClassAllowed(assets, "CeilingClassicLamp")) {
    ASSIGN_OR_RETURN(const PooledAsset* lamp,
                     DrawCeilingLamp(root.Child("ceiling"), room.height_m(), pool));
    for (int i = 0; i < (two ? 2 : 1); ++i) {
      const double t = two ? 0.27 + 0.46 * i : 0.5;
      const bool wide = w >= d;
      Fixture fixture;
      fixture.asset = lamp;
      fixture.position = {wide ? t * w : 0.5 * w, wide ? 0.5 * d : t * d,
                          room.height_m() - lamp->bounds.max().z() - 0.0005};
      fixture.yaw_rad = wide ? 0 : std::numbers::pi / 2;
      fixture.relation = "on_ceiling";
      fixture.power_w = color * (total_w / (two ? 2 : 1));
      fixtures.push_back(fixture);
    }
  }
  // Puts a floor lamp into a corner of every second room, away from doors and windows.
  Rng corner = root.Child("floor lamp");
  const bool lounge = room.kind() != "bathroom" && room.kind() != "closet" &&
                      room.kind() != "kitchen" && room.kind() != "hallway" && !room.has_stairs();
  if (lounge && ClassAllowed(assets, "FloorLamp") && corner.Bernoulli(0.5)) {
    ASSIGN_OR_RETURN(const PooledAsset* lamp, pool.Get("FloorLamp", corner.Seed()));
    // Turned into the corner; its true outline there, so that an arm reaches into the room only.
    constexpr double kTurn = -std::numbers::pi / 4, kGap_m = 0.06;
    const Box2f outline = lamp->TurnedBounds(kTurn);
    const double reach = static_cast<double>(outline.sizes().maxCoeff()) + kGap_m;
    const std::vector<WallStrip> strips = StripsOf(room);
    const int first = corner.UniformInt(0, 3);
    const double power = corner.Uniform(20, 55);
    for (int i = 0; i < 4; ++i) {
      const int wall = (first + i) % 4;
      const WallFrame frame = FrameOfWall(room, wall);
      const WallFrame before = FrameOfWall(room, (wall + 3) % 4);
      const bool blocked = std::any_of(strips.begin(), strips.end(), [&](const WallStrip& s) {
        if (s.wall == wall) return s.low_m < reach + 0.15;
        if (s.wall == (wall + 3) % 4) return s.high_m > before.length_m - reach - 0.15;
        return false;
      });
      if (blocked || lamp->bounds.max().z() > room.height_m() - 0.1) continue;
      const Vec2d at = frame.At(kGap_m - static_cast<double>(outline.min().x()),
                                kGap_m - static_cast<double>(outline.min().y()));
      fixtures.push_back({lamp,
                          {at.x(), at.y(), 0.0005 - lamp->bounds.min().z()},
                          frame.yaw_rad + kTurn,
                          "in_corner",
                          LampColor(corner.Uniform(0, 0.5)) * power});
      break;
    }
  }
  const Vec3d origin(room.origin_x_m(), room.origin_y_m(), room.floor_z_m());
  for (Fixture& fixture : fixtures) fixture.position += origin;
  return fixtures;
}

}  // namespace parallax
