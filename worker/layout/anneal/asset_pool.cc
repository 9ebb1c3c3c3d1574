#include "worker/layout/anneal/asset_pool.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

// Source: Andrew's monotone chain.
std::vector<Vec2f> ConvexHull(const Mesh& mesh) {
  std::vector<Vec2f> points;
  points.reserve(mesh.positions.size());
  for (const Vec3f& p : mesh.positions) points.push_back(p.head<2>());
  const auto less = [](const Vec2f& a, const Vec2f& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), less);
  std::vector<Vec2f> hull;
  const auto extend = [&](const Vec2f& p, size_t fixed) {
    while (hull.size() > fixed + 1) {
      const Vec2f a = hull[hull.size() - 1] - hull[hull.size() - 2], b = p - hull.back();
      if (a.x() * b.y() - a.y() * b.x() > 0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vec2f& p : points) extend(p, 0);
  const size_t lower = hull.size() - 1;
  for (auto p = points.rbegin(); p != points.rend(); ++p) extend(*p, lower);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

}  // namespace

Box2f PooledAsset::TurnedBounds(double yaw_rad) const {
  const Eigen::Rotation2Df turn(static_cast<float>(yaw_rad));
  Box2f box;
  for (const Vec2f& p : hull) box.extend(turn * p);
  return box;
}

const std::shared_ptr<const TriangleTree>& PooledAsset::Tree() const {
  if (tree_ == nullptr) tree_ = std::make_shared<TriangleTree>(*mesh);
  return tree_;
}

absl::StatusOr<const PooledAsset*> AssetPool::Get(const std::string& class_name, uint64_t seed) {
  auto& entry = assets_[{class_name, seed}];
  if (entry == nullptr) {
    ASSIGN_OR_RETURN(Asset asset, MakeAsset(class_name, seed));
    entry = std::make_unique<PooledAsset>();
    entry->class_name = class_name;
    entry->seed = seed;
    entry->asset_class = FindAssetClass(class_name);
    entry->bounds = asset.mesh.Bounds();
    entry->hull = ConvexHull(asset.mesh);
    entry->supports = std::move(asset.supports);
    entry->mesh = std::make_shared<Mesh>(std::move(asset.mesh));
  }
  return entry.get();
}

}  // namespace parallax
