#include "worker/render/raster/clusters.h"

#include <algorithm>

namespace parallax {
namespace {

BoundingSphere SphereAround(const Mesh& mesh, const std::vector<uint32_t>& vertices) {
  Box3f box;
  for (const uint32_t v : vertices) box.extend(mesh.positions[v]);
  BoundingSphere sphere{box.center(), 0};
  for (const uint32_t v : vertices) {
    sphere.radius = std::max(sphere.radius, (mesh.positions[v] - sphere.center).norm());
  }
  return sphere;
}

template <typename T>
void PadToEight(std::vector<T>& row) {
  while (row.size() % 8 != 0) row.push_back(row.back());
}

}  // namespace

ClusteredMeshes::Range ClusteredMeshes::Add(const Mesh& mesh) {
  Range range{static_cast<uint32_t>(clusters.size()), 0, {}};
  std::vector<int32_t> place(mesh.positions.size(), -1);  // In the cluster; -1: not in it.
  std::vector<uint32_t> used;                             // The cluster's vertices.
  const auto add = [&](uint32_t vertex) {
    if (place[vertex] < 0) {
      place[vertex] = static_cast<int32_t>(used.size());
      used.push_back(vertex);
    }
    return static_cast<uint32_t>(place[vertex]);
  };
  for (size_t begin = 0, k = 0; begin < mesh.triangles.size(); begin = k) {
    Cluster cluster;
    cluster.first_vertex = static_cast<uint32_t>(x.size());
    cluster.first_triangle = static_cast<uint32_t>(triangles.size());
    cluster.mesh_triangle = static_cast<uint32_t>(begin);
    for (; k < mesh.triangles.size() && k - begin < Cluster::kMostTriangles; ++k) {
      if (used.size() + 3 > Cluster::kMostVertices) break;
      const Triangle& t = mesh.triangles[k];
      triangles.push_back(add(t.a) | add(t.b) << 8 | add(t.c) << 16);
    }
    for (const uint32_t v : used) {
      x.push_back(mesh.positions[v].x());
      y.push_back(mesh.positions[v].y());
      z.push_back(mesh.positions[v].z());
      place[v] = -1;
    }
    cluster.bounds = SphereAround(mesh, used);
    cluster.vertices = static_cast<uint16_t>(used.size());
    cluster.triangles = static_cast<uint16_t>(k - begin);
    clusters.push_back(cluster);
    for (std::vector<float>* row : {&x, &y, &z}) PadToEight(*row);
    PadToEight(triangles);
    used.clear();
  }
  range.end = static_cast<uint32_t>(clusters.size());
  const Box3f box = mesh.Bounds();
  if (range.begin == range.end) return range;
  range.bounds.center = box.center();
  for (uint32_t c = range.begin; c < range.end; ++c) {
    const BoundingSphere& part = clusters[c].bounds;
    range.bounds.radius =
        std::max(range.bounds.radius, (part.center - range.bounds.center).norm() + part.radius);
  }
  return range;
}

}  // namespace parallax
