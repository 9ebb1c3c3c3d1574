// Embree's trees (bounding volume hierarchies) over placed meshes, and the rays that are traced
// through them.
//
// Light is traced through a fast tree. Rays of ground truth may run exactly along the edge that two
// triangles share, where a fast tree can let them slip through: they use a robust tree
// (RTC_SCENE_FLAG_ROBUST), which takes two thirds longer. Both are built over the same meshes.
// Where that would need too much memory, the robust tree serves for both.
//
// Constant after Build except for Move; queries are thread-safe.
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

// A hit before its surface is identified.
struct RawHit {
  float distance = 0;
  uint32_t placed = 0;             // Index of the body.
  uint32_t triangle = 0;           // In that body's mesh.
  float u = 0, v = 0;              // Weights of the triangle's corners b and c.
  Vec3f position = Vec3f::Zero();  // World.
  // Cross product of the triangle's edges, in the frame of its stored positions (the object's for
  // instances).
  Vec3f edge_cross = Vec3f::UnitZ();
};

// Up to eight rays, and their hits; fields are those of Ray and RawHit.
struct Rays8 {
  Vec3x8 origin, direction;
};

// The hits of Rays8.
struct Hits8 {
  Mask8 met;  // Lanes with a hit; the others are undefined.
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

inline Hits8 Select(Mask8 mask, const Hits8& a, const Hits8& b) {
  return {mask ? a.met : b.met,
          mask ? a.distance : b.distance,
          mask ? a.u : b.u,
          mask ? a.v : b.v,
          mask ? a.placed : b.placed,
          mask ? a.triangle : b.triangle,
          Select(mask, a.position, b.position),
          Select(mask, a.edge_cross, b.edge_cross)};
}

// Gives the transmittance of surfaces that shadow rays meet.
class ShadowFilter {
 public:
  virtual ~ShadowFilter() = default;
  // Returns the transmittance at the hit, in [0, 1] by channel. `hit.distance` is not set.
  virtual Vec3f Passes(const RawHit& hit, const Vec3f& direction) const = 0;
};

// One mesh in the trees. Borrowed data must outlive the trees.
struct TreeBody {
  const Mesh* mesh = nullptr;        // Its triangles; bodies that share it share a tree.
  const Vec3f* positions = nullptr;  // As many as the mesh has, and 4 bytes behind them.
  bool instanced = false;            // Positions are in the object's frame, else in the world's.
  bool filtered = false;             // May let light through.
  bool moves = false;                // Instanced only: Move places it anew.
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
};

// How the trees are built.
struct TreeOptions {
  bool one_tree = false;  // No instances: worth a careful build.
  bool twins = false;     // A fast tree beside the robust one.
  int64_t memory_limit_bytes = 0;
};

// The trees of one scene.
class RayTrees {
 public:
  enum class Tree { kFast, kRobust };
  // Builds the trees; a body's index is its position in the list. Errors: kResourceExhausted when
  // Embree needs more than the limit.
  static absl::StatusOr<std::unique_ptr<RayTrees>> Build(const std::vector<TreeBody>& bodies,
                                                         const TreeOptions& options);
  ~RayTrees();

  // Places the moving bodies anew and rebuilds the top level only. `world_from_object` has a place
  // for each of the first bodies, all movers among them. Errors: kResourceExhausted when Embree
  // needs more than the limit; kInternal for its other errors.
  absl::Status Move(const std::vector<Eigen::Affine3f>& world_from_object);
  // Takes the bodies that move out of all trees, or puts them back. Errors: as Move.
  absl::Status ShowMovers(bool shown);

  // Finds the nearest hit beyond `t_min`; false if none exists.
  bool Intersect(Tree tree, const Ray& ray, float t_min, RawHit* hit) const;
  // Finds the nearest hits beyond 0 of those of eight rays whose `lanes` are set. With `coherent`,
  // the rays start close together and have similar directions, and are traced as a packet.
  void Intersect(Tree tree, const Rays8& rays, Mask8 lanes, bool coherent, Hits8* hits) const;
  // Returns the transmittance from `origin` along unit `direction` over `distance`, in [0, 1] by
  // channel.
  Vec3f Transmittance(const ShadowFilter& filter, const Vec3f& origin, const Vec3f& direction,
                      float distance) const;

 private:
  class Builder;
  struct MemoryWatch;

  RayTrees();
  absl::Status Error() const;
  RTCScene scene(Tree tree) const;
  uint32_t BodyOf(const RTCHit& hit) const {
    return hit.instID[0] != rest_ ? hit.instID[0] : hit.geomID;
  }
  void IntersectPacket(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const;
  void IntersectEach(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const;

  std::unique_ptr<MemoryWatch> memory_;
  EmbreeDevice device_;
  std::vector<EmbreeScene> shared_;  // Trees of instanced meshes.
  EmbreeScene robust_, fast_;        // `fast_` may be none.
  std::vector<uint32_t> movers_;     // Bodies that move and have triangles.
  // Where bodies move, those that stand in the world's frame are one instance, with this id, so
  // that they are built once. Else they are at the top, where no hit has an instance.
  uint32_t rest_ = RTC_INVALID_GEOMETRY_ID;
};

}  // namespace parallax
