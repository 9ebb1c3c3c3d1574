#include "worker/scene/types/nature/walk/sight.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "common/math/stereo.h"

namespace parallax {
namespace {

constexpr double kNearest_m = 1, kFarthest_m = 6000, kStep = 1.06;
constexpr double kLift_m = 0.3;
constexpr int kColumns = 9, kRows = 5;

// The distance along a ray, `direction` unit, at which it goes below the ground.
std::optional<double> MeetGround(const Terrain& terrain, const Vec3d& eye, const Vec3d& direction) {
  for (double t = kNearest_m; t < kFarthest_m; t *= kStep) {
    const Vec3d at = eye + t * direction;
    const auto footprint_m = static_cast<float>(t * (kStep - 1));
    if (at.z() < terrain.Height(at.head<2>().cast<float>(), footprint_m)) return t;
  }
  return std::nullopt;
}

}  // namespace

Sight::Sight(const Terrain& terrain, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs)
    : terrain_(terrain) {
  std::vector<double> distances;
  for (const int index : {0, rigs.size() / 2, rigs.size() - 1}) {
    const v1::Rig& rig = rigs[index];
    const Vec2d half = HalfTangents(rig), shift = ShiftTangents(rig);
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const Vec3d local(shift.x() + half.x() * (2.0 * (x + 0.5) / kColumns - 1),
                          shift.y() + half.y() * (2.0 * (y + 0.5) / kRows - 1), 1);
        const Vec3d eye = EyePosition(rig, 0), direction = (RigAxes(rig) * local).normalized();
        const auto met = MeetGround(terrain, eye, direction);
        if (!met) continue;
        distances.push_back(*met);
        ground_.emplace_back(eye + *met * direction);
      }
    }
  }
  if (distances.empty()) distances.push_back(kFarthest_m);
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  median_m_ = *middle;
}

double Sight::SunlitShare(const Vec3d& direction) const {
  if (ground_.empty()) return 1;
  const auto lit = std::count_if(ground_.begin(), ground_.end(), [&](const Vec3d& point) {
    // A ray went below the ground somewhere in its last step: the point is raised above it.
    const Vec2f place = point.head<2>().cast<float>();
    const double height_m = terrain_.Height(place, 0.1f) + kLift_m;
    return !MeetGround(terrain_, {point.x(), point.y(), height_m}, direction);
  });
  return static_cast<double>(lit) / static_cast<double>(ground_.size());
}

}  // namespace parallax
