#include "worker/scene/floating/view_guard.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/scene/rigs/rig_camera.h"

namespace parallax {
namespace {

constexpr double kClearance_m = 0.3;
constexpr double kNear_m = 0.7;     // Things nearer than this have huge disparities.
constexpr double kMostOfOne = 0.5;  // Part of a view that one thing's box may fill...
constexpr double kMostNear = 0.3;   // ... all near ones together...
constexpr double kMostOfAll = 2.2;  // ... and all things.
constexpr double kLeastDepth_m = 0.05;

using Polygon = std::vector<Vec2d>;

double AreaOf(const Polygon& polygon) {
  double doubled = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(doubled) / 2;
}

// Source: Andrew's monotone chain.
Polygon ConvexHull(std::array<Vec2d, 8> points) {
  std::sort(points.begin(), points.end(), [](const Vec2d& a, const Vec2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  Polygon hull;
  const auto extend = [&](const Vec2d& p, size_t fixed) {
    while (hull.size() > fixed + 1) {
      const Vec2d a = hull[hull.size() - 1] - hull[hull.size() - 2], b = p - hull.back();
      if (a.x() * b.y() - a.y() * b.x() > 0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vec2d& p : points) extend(p, 0);
  const size_t lower = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) extend(*p, lower);
  hull.pop_back();
  return hull;
}

// The part of a convex polygon in [-1, 1]^2.   Source: Sutherland and Hodgman, 1974.
Polygon ClipToImage(Polygon polygon) {
  for (int side = 0; side < 4; ++side) {
    const auto inside_by = [side](const Vec2d& p) {
      const double at = side < 2 ? p.x() : p.y();
      return side % 2 == 0 ? 1 - at : 1 + at;
    };
    Polygon kept;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Vec2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double da = inside_by(a), db = inside_by(b);
      if (da >= 0) kept.push_back(a);
      if ((da >= 0) != (db >= 0)) kept.push_back(a + (b - a) * (da / (da - db)));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

}  // namespace

ViewGuard::ViewGuard(const v1::RigConfig& config, const v1::Scene& scene)
    : reach_m_(std::max(config.clearance_baseline_m(), LargestBaseline(config))),
      clearance_m_(std::max(kClearance_m, config.min_distance_m())) {
  for (const v1::Rig& rig : scene.rigs()) {
    if (!rig.shares_left()) views_.push_back(RigView::Of(rig));
  }
  taken_.resize(views_.size());
}

bool ViewGuard::Allows(const Box3f& bounds, const PoseInTime& pose_at) {
  asked_.assign(views_.size(), {});
  const Eigen::AlignedBox3d box(bounds.min().cast<double>(), bounds.max().cast<double>());
  for (size_t i = 0; i < views_.size(); ++i) {
    const RigView& view = views_[i];
    const Pose pose = pose_at(view.time_s);
    const Pose object_from_world = pose.Inverse();
    const Vec3d middle = pose * box.center();
    const double radius = pose.scale * box.diagonal().norm() / 2;
    if (!IsClearOfEyes(view, reach_m_, clearance_m_, bounds, pose)) return false;
    const Vec3d right = view.axes.col(0);
    Filled& asked = asked_[i];
    for (const double shift : {0.0, reach_m_}) {
      const Vec3d eye = view.eye + shift * right;
      if (view.axes.col(2).dot(middle - eye) < -radius) continue;
      std::array<Vec2d, 8> corners;
      bool ahead = false;
      for (int c = 0; c < 8; ++c) {
        const Vec3d at = view.axes.transpose() *
                         (pose * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(c)) - eye);
        ahead = ahead || at.z() > kLeastDepth_m;
        const double z = std::max(at.z(), kLeastDepth_m);
        corners[static_cast<size_t>(c)] = Vec2d((at.x() - z * view.shift_x) / (z * view.half_x),
                                                (at.y() - z * view.shift_y) / (z * view.half_y));
      }
      if (!ahead) continue;
      const double filled = AreaOf(ClipToImage(ConvexHull(corners))) / 4;
      const double distance = pose.scale * box.exteriorDistance(object_from_world * eye);
      asked.all = std::max(asked.all, filled);
      if (distance < kNear_m) asked.near = std::max(asked.near, filled);
    }
    if (asked.all > kMostOfOne || taken_[i].near + asked.near > kMostNear ||
        taken_[i].all + asked.all > kMostOfAll) {
      return false;
    }
  }
  return true;
}

void ViewGuard::Take() {
  for (size_t i = 0; i < taken_.size(); ++i) {
    taken_[i].all += asked_[i].all;
    taken_[i].near += asked_[i].near;
  }
  asked_.assign(views_.size(), {});
}

}  // namespace parallax
