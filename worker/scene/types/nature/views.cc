#include "worker/scene/types/nature/views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/math/stereo.h"

namespace parallax {
namespace {

constexpr float kMargin_rad = 5 * std::numbers::pi_v<float> / 180;

// Half of the angle that the picture spans from above; pi where it looks straight down or up.
double HalfAngle(const v1::Rig& rig, double heading) {
  const Eigen::Matrix3d axes = RigAxes(rig);
  const Vec2d half = HalfTangents(rig), shift = ShiftTangents(rig);
  double widest = 0;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const Vec3d to = axes * Vec3d(shift.x() + x * half.x(), shift.y() + y * half.y(), 1);
      if (to.head<2>().norm() < 0.15 * to.norm()) return std::numbers::pi;
      const double turn =
          std::remainder(std::atan2(to.y(), to.x()) - heading, 2 * std::numbers::pi);
      widest = std::max(widest, std::abs(turn));
    }
  }
  return widest;
}

}  // namespace

Views::Views(const google::protobuf::RepeatedPtrField<v1::Rig>& rigs) {
  for (const v1::Rig& rig : rigs) {
    const Eigen::Matrix3d axes = RigAxes(rig);
    const Vec3d left = EyePosition(rig, 0), right = EyePosition(rig, 1);
    const Vec3d forward = axes.col(2);
    const double heading = std::atan2(forward.y(), forward.x());
    Cone cone;
    cone.apex = left.head<2>().cast<float>();
    cone.ahead = Vec2d(std::cos(heading), std::sin(heading)).cast<float>();
    cone.half_rad = static_cast<float>(HalfAngle(rig, heading)) + kMargin_rad;
    cone.half_rad = std::min(cone.half_rad, std::numbers::pi_v<float>);
    cone.sine = std::sin(cone.half_rad);
    cone.cosine = std::cos(cone.half_rad);
    cones_.push_back(cone);
    eyes_.push_back({left.cast<float>(), right.cast<float>()});
    focal_px_ = std::max(focal_px_, static_cast<float>(rig.fx_px()));
  }
}

float Views::Distance(const Vec2f& p) const {
  float least = std::numeric_limits<float>::infinity();
  for (const Cone& cone : cones_) least = std::min(least, (p - cone.apex).squaredNorm());
  return std::sqrt(least);
}

bool Views::Wants(const Vec2f& p, float radius_m, float disc_m, float reach_m) const {
  return std::any_of(cones_.begin(), cones_.end(), [&](const Cone& cone) {
    const Vec2f to = p - cone.apex;
    const float square = to.squaredNorm();
    const float disc = disc_m + radius_m, reach = reach_m + radius_m;
    if (square < disc * disc) return true;
    if (square > reach * reach) return false;
    const float along = to.dot(cone.ahead);
    if (along >= cone.cosine * std::sqrt(square)) return true;
    // Beside the cone, but not farther than its radius from the border.
    const float across = std::abs(cone.ahead.x() * to.y() - cone.ahead.y() * to.x());
    return cone.half_rad < 1.5f && along > -radius_m &&
           across * cone.cosine - along * cone.sine < radius_m;
  });
}

TileSet Views::Tiles(float disc_m, float reach_m) const {
  Box2f all;
  for (const Cone& cone : cones_) all.extend(cone.apex);
  const Vec2f around = Vec2f::Constant(std::max(disc_m, reach_m));
  const Tile first = TileAt(all.min() - around), last = TileAt(all.max() + around);
  TileSet tiles;
  for (int32_t y = first.first; y <= last.first; ++y) {
    for (int32_t x = first.second; x <= last.second; ++x) {
      const Tile tile(y, x);
      const Vec2f middle = BoxOf(tile).center();
      if (Wants(middle, 0.75f * kTile_m, disc_m, reach_m)) tiles.insert(tile);
    }
  }
  return tiles;
}

std::vector<ViewCone> Views::Cones(const Terrain& terrain) const {
  std::vector<ViewCone> views;
  for (size_t i = 0; i < cones_.size(); ++i) {
    const Cone& cone = cones_[i];
    const float above = eyes_[i].left.z() - terrain.Height(cone.apex, 0.2f);
    views.push_back({cone.apex, std::max(above, 0.2f), std::atan2(cone.ahead.y(), cone.ahead.x()),
                     cone.half_rad});
  }
  return views;
}

}  // namespace parallax
