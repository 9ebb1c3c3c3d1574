// The scene that rays see: placed meshes in Embree trees, their materials, and the data of hits.
//
// Meshes that several objects share are instanced; others are built in world space. Bodies are the
// placed meshes, then the instances of prototypes; the geometry id or, for instances, the instance
// id is the index of the body. Constant after Build except for Move; queries are thread-safe.
#pragma once

#include <memory>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/render/scene/ray_trees.h"
#include "worker/render/surface/relief.h"

namespace parallax {

// The surface of a hit; all that the radiance cache needs.
struct SurfaceId {
  // World, unit, on the side of counter-clockwise winding.
  Vec3f geometric_normal = Vec3f::UnitZ();
  float doubled_area = 0;  // Twice the triangle's area, m^2.
  uint16_t slot = 0;
  uint32_t material = 0;  // SceneMaterial.index; 0 = none bound.
};

// The unit that the radiance cache treats as one surface: a mesh by itself or, for plants and
// things in large numbers, all copies of the same mesh.
struct CacheGroup {
  static constexpr float kCoarse = 2.5f;  // Cells among leaves over those on walls.

  // The group's first mesh or, for instances, prototype (numbered behind them).
  uint32_t id = 0;
  uint32_t sheets = 0;  // Slots that are sheets (MaterialSlot::sheet), as bits.

  bool Sheet(uint16_t slot) const { return slot < 32 && (sheets >> slot & 1) != 0; }
  float Coarse(uint16_t slot) const { return Sheet(slot) ? kCoarse : 1.0f; }
};

// The surfaces of eight hits.
struct SurfaceIds8 {
  Vec3x8 geometric_normal;
  Float8 doubled_area;
  Int8 slot, material;
};

// Up to eight hits whose materials are to be evaluated.
struct HitBatch8 {
  Int8 placed, triangle;
  Float8 u, v;
  Vec3x8 geometric_normal;
  Float8 doubled_area;
  Float8 footprint_m;  // Width of the rays' cones at the hits.
  int count = 0;

  void Add(const RawHit& raw, const SurfaceId& id, float footprint) {
    placed[count] = static_cast<int32_t>(raw.placed);
    triangle[count] = static_cast<int32_t>(raw.triangle);
    u[count] = raw.u;
    v[count] = raw.v;
    geometric_normal.Set(count, id.geometric_normal);
    doubled_area[count] = id.doubled_area;
    footprint_m[count] = footprint;
    ++count;
  }
};

// Geometry of eight hits. Lanes beyond the last hold a copy of it.
struct Interpolated8 {
  SurfacePoint8 points;   // For their materials.
  Vec3x8 shading_normal;  // World, unit, on the side of the geometric one.
  Faces8 faces;           // Complete except for the edges in the world.
};

// Surface properties at eight hits.
struct MaterialSample8 {
  SurfaceSample8 surface;
  Vec3x8 shading_normal;  // Bent by the material's relief.
};

// Facts found by sampling a material at many points, so that it is not evaluated needlessly.
struct MaterialTraits {
  bool may_be_open = false;          // Opacity < 1 somewhere.
  bool may_be_transmissive = false;  // Transmission > 0 somewhere.
  bool may_be_thin = false;          // Lets light straight through somewhere.
  bool may_be_mirror = false;        // Metallic and smooth somewhere.
  bool may_be_translucent = false;   // Sheets of it let scattered light through somewhere.
  bool has_relief = false;           // Height is not constant.
  // Open, transmissive or emissive somewhere: sends out more than scattered light.
  bool needs_tracing = false;
};

// Geometry, materials and trees of one scene.
class RenderScene final : public ShadowFilter {
 public:
  // Builds trees and tables. `movable`: every mesh is instanced, so that Move is cheap.
  // Errors: kResourceExhausted when Embree needs more than `memory_limit_bytes` (0: the machine's
  // memory) or allocation fails; kInvalidArgument for a placed mesh without mesh or with a material
  // index out of range.
  // `movers`: whether each mesh can be moved; those are instances. Empty: none can.
  static absl::StatusOr<std::unique_ptr<RenderScene>> Build(SceneGeometry geometry,
                                                            int64_t memory_limit_bytes,
                                                            std::vector<bool> movers = {});
  ~RenderScene() override;

  // Places the movers anew; `world_from_object` is in order of geometry().meshes, and its places of
  // other meshes are not read. Only the top of the acceleration structure is rebuilt. Not while
  // rays are traced. Errors: kInvalidArgument without movers, or for another number of placements;
  // as RayTrees::Move.
  absl::Status Move(const std::vector<Eigen::Affine3f>& world_from_object);
  // Takes the movers out of the acceleration structure, or puts them back.
  // Errors: kInternal for what Embree says.
  absl::Status ShowMovers(bool shown) { return trees_->ShowMovers(shown); }

  // Returns the trees. RawHit.placed is the index of a body: of a mesh below
  // geometry().meshes.size(), of an instance from there on.
  const RayTrees& trees() const { return *trees_; }
  size_t body_count() const { return geometry_.meshes.size() + geometry_.instances.size(); }
  uint32_t ObjectIndex(uint32_t placed) const {
    const size_t meshes = geometry_.meshes.size();
    return placed < meshes ? geometry_.meshes[placed].object_index
                           : geometry_.instances[placed - meshes].object_index;
  }
  // Returns where a body is placed now: world from mesh.
  Eigen::Affine3f PlaceOf(uint32_t placed) const;
  const Mesh& MeshOf(uint32_t placed) const {
    return placed < geometry_.meshes.size() ? *geometry_.meshes[placed].mesh
                                            : *PrototypeOf(placed).mesh;
  }
  // Returns the transmittance from `origin` along unit `direction` over `distance`: 0 behind opaque
  // surfaces; holes (opacity) and thin glass weaken it.
  Vec3f Transmittance(const Vec3f& origin, const Vec3f& direction, float distance) const {
    return trees_->Transmittance(*this, origin, direction, distance);
  }
  Vec3f Passes(const RawHit& hit, const Vec3f& direction) const override;

  // Prefetch the data that Identify, and then Interpolate, reads.
  void Prefetch(const Hits8& hits) const;
  void PrefetchVertices(uint32_t placed, uint32_t triangle) const;
  SurfaceId Identify(const RawHit& hit) const;
  SurfaceIds8 Identify(const Hits8& hits) const;
  // Returns the interpolated vertex data of one to eight hits.
  Interpolated8 Interpolate(const HitBatch8& batch) const;
  // Materials of one to eight hits on `material`; objects without a material are plain grey.
  MaterialSample8 EvaluateMaterial(const HitBatch8& batch, uint32_t material) const;
  // Returns the surface at the hit, without its relief.
  SurfaceSample Evaluate(const RawHit& hit, const SurfaceId& id, float footprint_m) const;
  // Sets a triangle's corners in the world, as rays see them.
  void Corners(uint32_t placed, uint32_t triangle, Vec3f corners[3]) const;
  // Sets the hits of eight rays on triangles that they are known to meet; the lanes `met`, `placed`
  // and `triangle` of the hits are given. A ray that misses its triangle by rounding hits the
  // nearest point of it.
  void HitTriangles(const Rays8& rays, Hits8* hits) const;

  const SceneGeometry& geometry() const { return geometry_; }
  const MaterialTraits& traits(uint32_t material) const { return traits_[material]; }
  const CacheGroup& cache_group(uint32_t placed) const {
    const size_t meshes = geometry_.meshes.size();
    return cache_groups_[placed < meshes ? placed
                                         : meshes + geometry_.instances[placed - meshes].prototype];
  }
  const Box3f& bounds() const { return bounds_; }

 private:
  struct Body;    // The part of a body that every hit reads.
  struct Place;   // A body's placement.
  struct Stored;  // The arrays that a mesh or a prototype owns.
  struct Vertex;  // The vertex data that shading reads, packed for the CPU's cache.

  RenderScene();
  absl::Status CheckReferences() const;
  absl::Status BuildTrees(int64_t memory_limit_bytes);
  void StoreBodies(bool one_tree);
  void FindCacheGroups();
  void StoreInstances();
  Body BodyOf(const Mesh& mesh, const std::vector<uint32_t>& materials);
  const Prototype& PrototypeOf(uint32_t placed) const {
    return geometry_.prototypes[geometry_.instances[placed - geometry_.meshes.size()].prototype];
  }
  bool AllMove() const;
  bool Moves(size_t mesh) const { return mesh < movers_.size() && movers_[mesh]; }
  void SetPlace(size_t body, const Eigen::Affine3f& world_from_object);
  uint32_t MaterialOf(const Body& body, uint16_t slot) const;
  // Returns the lanes whose hits are on sheets.
  Mask8 OnSheets(const HitBatch8& batch) const;
  static std::shared_ptr<const std::vector<Vertex>> Pack(const Mesh& mesh);
  bool LetsLightThrough(const std::vector<uint32_t>& materials) const;
  void FindEdges(const HitBatch8& batch, Vec3x8 edges[2]) const;
  void ProbeMaterials();
  Vec3f FirstNormal(uint32_t placed, uint32_t triangle) const;

  SceneGeometry geometry_;
  std::vector<Body> bodies_;
  std::vector<Place> places_;             // Parallel to bodies_.
  std::vector<Stored> stored_;            // The meshes' arrays, then the prototypes'.
  std::vector<CacheGroup> cache_groups_;  // Parallel to stored_.
  std::vector<uint32_t> materials_;       // The materials of all bodies' slots, one behind another.
  std::vector<MaterialTraits> traits_;
  Box3f bounds_, rest_bounds_;  // All, and all but the movers.
  std::vector<bool> movers_;    // By mesh; empty: none.
  std::unique_ptr<RayTrees> trees_;
};

// Returns the distance from a surface at `position` within which rays neither start nor end.
inline float OffsetDistance(const Vec3f& position) {
  return 2e-5f + 2e-6f * position.cwiseAbs().maxCoeff();
}

// Returns the origin of a ray that leaves `position` on the side of `normal`.
inline Vec3f OffsetPoint(const Vec3f& position, const Vec3f& normal) {
  return position + normal * OffsetDistance(position);
}

// Returns the same for eight.
inline Float8 OffsetDistance(const Vec3x8& position) {
  return 2e-5f + 2e-6f * Max(Max(Abs(position.x), Abs(position.y)), Abs(position.z));
}
inline Vec3x8 OffsetPoint(const Vec3x8& position, const Vec3x8& normal) {
  return position + normal * OffsetDistance(position);
}

}  // namespace parallax
