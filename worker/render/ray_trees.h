// Embree's trees over placed meshes, and the rays that are traced through them.
//
// Light is traced through a fast tree. Where rays may run exactly along the edge that two triangles
// share, as those of ground truth do, it can let one slip through: they have a robust tree
// (RTC_SCENE_FLAG_ROBUST), which takes two thirds longer. Both stand over the same meshes. Where
// that would be too much memory, the robust one serves for both.
//
// Constant after Build but for Move; queries are thread-safe.
#pragma once

#include <memory>
#include <vector>

#include "common/base/status.h"
#include "common/math/lanes.h"
#include "common/math/types.h"
#include "worker/geometry/embree_handles.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// A ray with its cone: `width_m` at the origin, widening by `spread` radians.
struct Ray {
  Vec3f origin = Vec3f::Zero();
  Vec3f direction = Vec3f::UnitZ();  // Unit.
  float width_m = 0;
  float spread = 0;
};

struct RawHit {
  float distance = 0;
  uint32_t placed = 0;             // Which body.
  uint32_t triangle = 0;           // In that body's mesh.
  float u = 0, v = 0;              // Weights of the triangle's corners b and c.
  Vec3f position = Vec3f::Zero();  // World.
  // Cross product of the triangle's edges, in the frame of its stored positions (the object's for
  // instances).
  Vec3f edge_cross = Vec3f::UnitZ();
};

// Up to eight rays, and what they meet; as above.
struct Rays8 {
  Vec3x8 origin, direction;
};

struct Hits8 {
  Mask8 met;  // Else the rest says nothing.
  Float8 distance, u, v;
  Int8 placed, triangle;
  Vec3x8 position, edge_cross;

  RawHit Get(int lane) const {
    return {distance[lane],
            static_cast<uint32_t>(placed[lane]),
            static_cast<uint32_t>(triangle[lane]),
            u[lane],
            v[lane],
            position.Get(lane),
            edge_cross.Get(lane)};
  }
};

// Asked by shadow rays what of their light passes a surface in their way.
class ShadowFilter {
 public:
  virtual ~ShadowFilter() = default;
  // `hit.distance` is not set.
  virtual Vec3f Passes(const RawHit& hit, const Vec3f& direction) const = 0;
};

// One mesh in the trees. Borrowed data must outlive the trees.
struct TreeBody {
  const Mesh* mesh = nullptr;        // Its triangles; bodies that share it share a tree.
  const Vec3f* positions = nullptr;  // As many as the mesh has, and 4 bytes behind them.
  bool instanced = false;            // Then in the object's frame, else in the world's.
  bool filtered = false;             // May let light through.
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
};

struct TreeOptions {
  bool one_tree = false;  // No instances: worth a careful build.
  bool twins = false;     // A fast tree beside the robust one.
  int64_t memory_limit_bytes = 0;
};

class RayTrees {
 public:
  enum class Tree { kFast, kRobust };
  // Errors: kResourceExhausted when Embree needs more than the limit. Bodies' index = position in
  // the list.
  static absl::StatusOr<std::unique_ptr<RayTrees>> Build(const std::vector<TreeBody>& bodies,
                                                         const TreeOptions& options);
  ~RayTrees();

  // Instances only: places every body anew; only the top of the trees is built again.
  absl::Status Move(const std::vector<Eigen::Affine3f>& world_from_object);

  // The nearest hit beyond `t_min`; false if there is none.
  bool Intersect(Tree tree, const Ray& ray, float t_min, RawHit* hit) const;
  // Likewise of these of eight, beyond 0. `coherent`: they leave side by side and go
  // about the same way; then they go as a packet.
  void Intersect(Tree tree, const Rays8& rays, Mask8 lanes, bool coherent, Hits8* hits) const;
  // Part of the light that passes from `origin` along unit `direction` for `distance`.
  Vec3f Transmittance(const ShadowFilter& filter, const Vec3f& origin, const Vec3f& direction,
                      float distance) const;

 private:
  class Builder;
  struct MemoryWatch;

  RayTrees();
  absl::Status Error() const;
  RTCScene scene(Tree tree) const;
  void IntersectPacket(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const;
  void IntersectEach(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const;

  std::unique_ptr<MemoryWatch> memory_;
  EmbreeDevice device_;
  std::vector<EmbreeScene> shared_;  // Trees of instanced meshes.
  EmbreeScene robust_, fast_;        // `fast_` may be none.
  std::vector<bool> solid_;          // By body: it has triangles.
};

}  // namespace parallax
