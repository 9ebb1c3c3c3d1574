// A mesh prepared for solid questions: a tree of boxes over its triangles, built once in the object
// frame and asked under any placement, so that a moved object costs nothing to re-ask.
//
// Ours rather than FCL's, because touching within a tolerance must not count (things stand on each
// other) and because building is on the solver's critical path; the tests hold it against FCL.
// Constant after construction: thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"

namespace parallax {

class TriangleTree {
 public:
  struct Node {
    Box3f box;
    uint32_t first =
        0;  // Leaf: first entry of order(); else: the left child (the right one follows it).
    uint32_t count = 0;  // Leaf: triangles; 0 = inner node.
  };

  explicit TriangleTree(const Mesh& mesh);

  const Box3f& bounds() const { return bounds_; }
  size_t triangle_count() const { return triangles_.size(); }
  // Object frame. One vertex more than the mesh has, so that Embree may read 16 bytes at the last.
  const std::vector<Vec3f>& positions() const { return positions_; }
  const std::vector<std::array<uint32_t, 3>>& triangles() const { return triangles_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<uint32_t>& order() const { return order_; }
  // A vertex of each part that hangs together by shared vertices, thinned to a few dozen.
  const std::vector<Vec3f>& part_points() const { return part_points_; }

  // Whether an object-frame point lies inside a closed surface: majority of the signed crossings
  // along three rays. Sheets (MaterialSlot::sheet) hold nothing.
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

// Whether triangles of the two cross, or one holds a part of the other whole. Triangles that reach
// less than `tolerance_m` (world) through each other's planes only touch; coplanar ones never
// cross. Placements are similarities.
bool Overlap(const TriangleTree& a, const Eigen::Affine3f& world_from_a, const TriangleTree& b,
             const Eigen::Affine3f& world_from_b, float tolerance_m = 0.0f);

// The crossing test of two triangles by itself.   Source: Möller, "A fast triangle-triangle
// intersection test", 1997.
bool TrianglesCross(const std::array<Vec3f, 3>& s, const std::array<Vec3f, 3>& t,
                    float tolerance_m);

// The box of a placed box.
Box3f TransformBox(const Eigen::Affine3f& world_from_object, const Box3f& box);

// Unsigned distance from a point to a triangle.
float PointTriangleDistance(const Vec3f& point, const std::array<Vec3f, 3>& triangle);

}  // namespace parallax
