#include "worker/scene/types/nature/ground/views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/math/raw_rig.h"
#include "common/math/stereo.h"

namespace parallax {
namespace {

constexpr float kMargin_rad = 5 * std::numbers::pi_v<float> / 180;

constexpr int kRawPoints = 9;  // Sample points per side of the raw image.

// Angle in plan between a direction and the heading; pi where it points straight down or up.
double TurnTo(const Vec3d& to, double heading) {
  if (to.head<2>().norm() < 0.15 * to.norm()) return std::numbers::pi;
  return std::abs(std::remainder(std::atan2(to.y(), to.x()) - heading, 2 * std::numbers::pi));
}

// The direction that a lens maps to `point`, which is relative to the principal point. Beyond what
// the lens sees: that of the last point on the way there.
Vec3d LastSeen(const LensDistortion& lens, double reach, const Vec2d& point) {
  if (const auto seen = lens.Unproject(point, reach)) return *seen;
  Vec3d last = Vec3d::UnitZ();
  double low = 0, high = 1;
  for (int i = 0; i < 20; ++i) {
    const double middle = (low + high) / 2;
    const auto seen = lens.Unproject(middle * point, reach);
    (seen ? low : high) = middle;
    if (seen) last = *seen;
  }
  return last;
}

// Whether a raw camera's picture shows what is straight below it or above it.
bool SeesUpright(const RawIntrinsics& raw, double reach, const Eigen::Matrix3d& world_from_raw) {
  for (const double up : {-1.0, 1.0}) {
    const auto at = raw.lens.Project(world_from_raw.transpose() * Vec3d(0, 0, up), reach);
    if (!at) continue;
    const double x = raw.k.fx_px * at->x() + raw.k.cx_px, y = raw.k.fy_px * at->y() + raw.k.cy_px;
    if (x >= 0 && x <= raw.width_px && y >= 0 && y <= raw.height_px) return true;
  }
  return false;
}

// As HalfAngle, for one camera before rectification; `axes` are the rig's.
double RawHalfAngle(const v1::RawCamera& camera, const Eigen::Matrix3d& axes, double heading) {
  const RawIntrinsics raw = FromProto(camera);
  const double reach = raw.lens.Reach();
  const Eigen::Matrix3d world_from_raw = axes * raw.rectified_from_raw;
  if (SeesUpright(raw, reach, world_from_raw)) return std::numbers::pi;
  const double step_x = raw.width_px / (kRawPoints - 1.0),
               step_y = raw.height_px / (kRawPoints - 1.0);
  double widest = 0;
  for (int y = 0; y < kRawPoints; ++y) {
    for (int x = 0; x < kRawPoints; ++x) {
      const Vec2d point((x * step_x - raw.k.cx_px) / raw.k.fx_px,
                        (y * step_y - raw.k.cy_px) / raw.k.fy_px);
      widest = std::max(widest, TurnTo(world_from_raw * LastSeen(raw.lens, reach, point), heading));
    }
  }
  return widest;
}

// Half of the angle that the pictures span from above; pi where they look straight down or up.
double HalfAngle(const v1::Rig& rig, double heading) {
  const Eigen::Matrix3d axes = RigAxes(rig);
  const Vec2d half = HalfTangents(rig), shift = ShiftTangents(rig);
  double widest = 0;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const Vec3d to = axes * Vec3d(shift.x() + x * half.x(), shift.y() + y * half.y(), 1);
      widest = std::max(widest, TurnTo(to, heading));
    }
  }
  if (!rig.has_raw_left()) return widest;
  return std::max({widest, RawHalfAngle(rig.raw_left(), axes, heading),
                   RawHalfAngle(rig.raw_right(), axes, heading)});
}

// Works in space and in plan.
template <typename Vector>
float SquaredDistance(const Vector& p, const Vector& a, const Vector& b) {
  const Vector along = b - a;
  const float t =
      std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-12f), 0.0f, 1.0f);
  return (p - (a + t * along)).squaredNorm();
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
    eyes_.push_back(
        {left.cast<float>(), right.cast<float>(), axes.col(0).cast<float>(), rig.path()});
    for (const double focal_px : {rig.fx_px(), rig.raw_left().fx_px(), rig.raw_right().fx_px()}) {
      focal_px_ = std::max(focal_px_, static_cast<float>(focal_px));
    }
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

EyeWay::EyeWay(const Views& views, float baseline_m) {
  const std::vector<Views::Eyes>& eyes = views.eyes();
  float longest_m = 0, widest_m = 0;
  const auto add = [&](const Vec3f& from, const Vec3f& to) {
    segments_.push_back({from, to});
    box_.extend(from).extend(to);
    return (to - from).norm();
  };
  const auto right_of = [&](const Views::Eyes& at) -> Vec3f {
    if (baseline_m <= (at.right - at.left).norm()) return at.right;
    return at.left + baseline_m * at.across;
  };
  for (size_t i = 0; i < eyes.size(); ++i) {
    const Vec3f left = eyes[i].left, right = right_of(eyes[i]);
    lefts_.push_back(left.head<2>());
    widest_m = std::max(widest_m, add(left, right));
    if (i + 1 == eyes.size() || !eyes[i].WalkOnTo(eyes[i + 1])) continue;
    const Vec3f next_left = eyes[i + 1].left, next_right = right_of(eyes[i + 1]);
    longest_m = std::max({longest_m, add(left, next_left), add(right, next_right)});
    if (baseline_m > 0) add(0.5f * (left + right), 0.5f * (next_left + next_right));
  }
  from_left_m_ = widest_m + 0.5f * longest_m;
}

bool EyeWay::Meets(const Vec3f& middle, float radius_m, float distance_m) const {
  const float reach = distance_m + radius_m;
  if (box_.squaredExteriorDistance(middle) > 1.01f * reach * reach) return false;
  return std::any_of(segments_.begin(), segments_.end(), [&](const Segment& segment) {
    return SquaredDistance(middle, segment.from, segment.to) < reach * reach;
  });
}

bool EyeWay::IsWithin(const Vec2f& p, float distance_m) const {
  float least = std::numeric_limits<float>::infinity();
  for (const Vec2f& left : lefts_) least = std::min(least, (p - left).squaredNorm());
  least = std::sqrt(least);
  if (least <= distance_m) return true;
  if (least > distance_m + from_left_m_) return false;
  return std::any_of(segments_.begin(), segments_.end(), [&](const Segment& segment) {
    const Vec2f from = segment.from.head<2>(), to = segment.to.head<2>();
    return SquaredDistance(p, from, to) <= distance_m * distance_m;
  });
}

}  // namespace parallax
