// The assets of one solve, each made once: mesh, supports, and the tree for exact overlap tests.
// Not thread-safe.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/geometry/triangle_tree.h"

namespace parallax {

// An asset of the pool.
struct PooledAsset {
  std::string class_name;
  uint64_t seed = 0;
  const AssetClass* asset_class = nullptr;
  std::shared_ptr<const Mesh> mesh;
  std::vector<SupportSurface> supports;
  Box3f bounds;             // Object frame.
  std::vector<Vec2f> hull;  // Convex outline seen from above, counter-clockwise.

  // Returns the bounds in the plan after a turn by `yaw_rad`.
  Box2f TurnedBounds(double yaw_rad) const;

  // Returns the tree for exact overlap tests, which is built at first use.
  const std::shared_ptr<const TriangleTree>& Tree() const;

 private:
  mutable std::shared_ptr<const TriangleTree> tree_;
};

// Makes assets on demand.
class AssetPool {
 public:
  // Returns the asset; the pool owns it. Errors: kNotFound for an unknown class.
  absl::StatusOr<const PooledAsset*> Get(const std::string& class_name, uint64_t seed);

 private:
  std::map<std::pair<std::string, uint64_t>, std::unique_ptr<PooledAsset>> assets_;
};

}  // namespace parallax
