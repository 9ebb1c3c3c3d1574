// A mesh prepared for overlap tests: a tree of boxes over its triangles, built once in the object
// frame and queried under any placement, so that moving an object costs nothing.
//
// Our own rather than FCL's, because touching within a tolerance must not count (objects stand on
// each other) and because building is on the solver's critical path; tests compare it with FCL.
// Constant after construction: thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// The tree, with the mesh's positions.
class TriangleTree {
 public:
  struct Node {
    Box3f box;
    // Leaf: first entry of order(). Else: left child; the right one follows it.
    uint32_t first = 0;
    uint32_t count = 0;  // Leaf: triangles; 0 = inner node.
  };

  explicit TriangleTree(const Mesh& mesh);

  const Box3f& bounds() const { return bounds_; }
  size_t triangle_count() const { return triangles_.size(); }
  // Returns the mesh's positions in the object frame, and one more, so that Embree may read 16
  // bytes at the last.
  const std::vector<Vec3f>& positions() const { return positions_; }
  const std::vector<std::array<uint32_t, 3>>& triangles() const { return triangles_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<uint32_t>& order() const { return order_; }
  // Returns one vertex of each connected part, thinned to a few dozen.
  const std::vector<Vec3f>& part_points() const { return part_points_; }

  // Returns whether an object-frame point is inside a closed surface: majority of the signed
  // crossings along three rays. Sheets (MaterialSlot::sheet) enclose nothing.
  bool Inside(const Vec3f& point) const;

 private:
  void Build();
  void FindParts();
  int SignedCrossings(const Vec3f& origin, const Vec3f& direction) const;

  std::vector<Vec3f> positions_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<bool> sheet_;  // By triangle; empty when none is.
  std::vector<uint32_t> order_;
  std::vector<Node> nodes_;
  std::vector<Vec3f> part_points_;
  Box3f bounds_;
};

// Returns whether triangles of the two meshes cross, or one contains a part of the other. Triangles
// that reach less than `tolerance_m` (world) through each other's planes only touch; coplanar ones
// never cross. Placements must be similarities.
bool Overlap(const TriangleTree& a, const Eigen::Affine3f& world_from_a, const TriangleTree& b,
             const Eigen::Affine3f& world_from_b, float tolerance_m = 0.0f);

// Returns whether two triangles cross: the test that Overlap applies to pairs.   Source: Möller, "A
// fast triangle-triangle intersection test", 1997.
bool TrianglesCross(const std::array<Vec3f, 3>& s, const std::array<Vec3f, 3>& t,
                    float tolerance_m);

// Returns the axis-aligned bounds of a transformed box.
Box3f TransformBox(const Eigen::Affine3f& world_from_object, const Box3f& box);

// Returns the unsigned distance from a point to a triangle.
float PointTriangleDistance(const Vec3f& point, const std::array<Vec3f, 3>& triangle);

}  // namespace parallax
