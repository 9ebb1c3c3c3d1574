// Embree queries for everything but light transport: nearest hits, occlusion, nearest distance and
// overlap of placed meshes. The renderer builds its own Embree scene with the handles of
// embree_handles.h.
//
// Build once, then query: const members are thread-safe.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"
#include "worker/geometry/triangle_tree.h"

namespace parallax {

// The nearest hit of a ray.
struct RayHit {
  float distance = 0;     // In units of the direction's length.
  uint32_t body = 0;      // Index of the Add call.
  uint32_t triangle = 0;  // In that mesh.
  // Geometric, world frame, unit, on the side of counter-clockwise winding.
  Vec3f normal = Vec3f::Zero();
};

// A set of placed triangle meshes for geometric queries.
class RayScene {
 public:
  RayScene();
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  // Places a copy of the mesh; returns its body index (0, 1, 2...).
  uint32_t Add(const Mesh& mesh, const Eigen::Affine3f& world_from_object);
  // Places a prepared mesh, which is shared and not copied; returns its body index.
  uint32_t Add(std::shared_ptr<const TriangleTree> tree, const Eigen::Affine3f& world_from_object);
  // Removes a body (false) or restores it (true). Needs Commit before the next query.
  void SetEnabled(uint32_t body, bool enabled);
  // Builds the acceleration structure; queries require it.
  void Commit();

  // Returns the nearest hit along a ray, or nothing within `max_distance` (in lengths of
  // `direction`).
  std::optional<RayHit> Intersect(
      const Vec3f& origin, const Vec3f& direction,
      float max_distance = std::numeric_limits<float>::infinity()) const;
  // Returns whether anything is between two points (1 % of a millimetre is left free at both ends).
  bool Occluded(const Vec3f& from, const Vec3f& to) const;
  // Returns the distance from `point` to the nearest surface, or `max_distance` if nothing is that
  // near.
  float NearestDistance(const Vec3f& point, float max_distance) const;
  // Returns whether `point` lies inside a closed surface: majority vote of signed crossings over
  // three fixed directions.
  bool Inside(const Vec3f& point) const;
  // Return whether a triangle of the placed mesh crosses a triangle of the enabled bodies, or one
  // contains the other. The test is exact; touching within `tolerance_m` does not count.
  bool Overlaps(const Mesh& mesh, const Eigen::Affine3f& world_from_object,
                float tolerance_m = 0.0f) const;
  bool Overlaps(const TriangleTree& tree, const Eigen::Affine3f& world_from_object,
                float tolerance_m = 0.0f) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parallax
