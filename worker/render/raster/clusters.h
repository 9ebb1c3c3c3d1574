// Meshes cut into clusters: the pieces that the rasteriser culls and draws as a whole.
//
// A cluster is a run of a mesh's triangles in their order, with its own copy of their vertices, in
// the frame of the mesh. Constant once made; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/geometry/mesh.h"

namespace parallax {

// Encloses points; radius in metres.
struct BoundingSphere {
  Vec3f center = Vec3f::Zero();
  float radius = 0;
};

struct Cluster {
  static constexpr uint32_t kMostTriangles = 128;
  static constexpr uint32_t kMostVertices = 255;  // An index is a byte.

  BoundingSphere bounds;        // Mesh's frame.
  uint32_t first_vertex = 0;    // Into ClusteredMeshes::x; a multiple of eight.
  uint32_t first_triangle = 0;  // Into ClusteredMeshes::triangles; a multiple of eight.
  uint32_t mesh_triangle = 0;   // Index of its first triangle in the mesh.
  uint16_t vertices = 0, triangles = 0;
};

// The clusters of some meshes. Rows of vertices and triangles are padded to eight with copies of
// the last, so that vector lanes may read whole rows.
struct ClusteredMeshes {
  // The clusters of a mesh, as indices.
  struct Range {
    uint32_t begin = 0, end = 0;
    BoundingSphere bounds;  // Mesh's frame.
  };

  std::vector<float> x, y, z;       // Vertices, metres, mesh's frame.
  std::vector<uint32_t> triangles;  // Three indices of a cluster's vertices, a byte each.
  std::vector<Cluster> clusters;

  // Appends the clusters of a mesh.
  Range Add(const Mesh& mesh);
};

}  // namespace parallax
