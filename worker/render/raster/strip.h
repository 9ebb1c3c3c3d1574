// Rows of a picture while they are rasterised. Only for rasteriser.cc and strip.cc.
#pragma once

#include <span>
#include <vector>

#include "common/math/lanes.h"
#include "worker/render/raster/clusters.h"
#include "worker/render/raster/visibility_buffer.h"

namespace parallax {

// A rectangle of tiles, or of pixels; both ends belong to it.
struct TileRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// A cluster that may be seen, as a body places it.
struct PlacedCluster {
  // Homogeneous image point (pixels times z, z) of a point of the mesh's frame.
  const Eigen::Matrix<float, 3, 4>* image_from_mesh = nullptr;
  uint32_t cluster = 0;
  // The greatest 1/z it may have, 1/m; infinite where it may cross the near plane.
  float nearest = 0;
  TileRect tiles;  // All that it may cover.
};

// Draws clusters into rows of a visibility buffer.
class Strip {
 public:
  static constexpr int kRows = 64;
  static constexpr int kTile = 8;  // Pixels; the unit in which hidden clusters are found.

  explicit Strip(int width);

  // Draws those of the clusters whose indices are in `order` into rows [first_row, first_row +
  // kRows) of the picture. An index is the draw of the buffer. `order` changes the cost only: the
  // nearest should come first.
  void Draw(const ClusteredMeshes& meshes, std::span<const PlacedCluster> clusters,
            std::span<const uint32_t> order, int first_row, VisibilityBuffer* buffer);

 private:
  struct Triangles8;

  void Clear(int first_row, int rows);
  bool Hidden(const PlacedCluster& placed);
  float FarthestOf(int tile_x, int tile_y);
  void DrawCluster(const ClusteredMeshes& meshes, const PlacedCluster& placed, uint32_t draw);
  void Project(const ClusteredMeshes& meshes, const PlacedCluster& placed, bool divide);
  void DrawClipped(const uint32_t* triangles, uint32_t count, uint32_t first_id);
  void DrawEight(Vec3x8 a, Vec3x8 b, Vec3x8 c, Mask8 lanes, uint32_t first_id);
  void DrawTriangle(const Triangles8& triangles, int lane, uint32_t id);
  bool Comes(uint32_t id, uint32_t before) const;
  Mask8 BeforeThoseThere(Mask8 equal, Int8 there, uint32_t id) const;

  const int width_, tiles_x_;
  int first_row_ = 0, rows_ = 0;
  VisibilityBuffer* buffer_ = nullptr;
  std::vector<float> inverse_z_;         // 1/z by sample; 0: nothing.
  std::vector<float> farthest_;          // The least of each pixel's.
  std::vector<float> farthest_of_tile_;  // The least of each tile's, unless stale.
  std::vector<uint8_t> stale_;
  alignas(32) float corners_[(Cluster::kMostVertices + 1) * 4];  // x, y, 1/z (or times z, z) and 0.
};

}  // namespace parallax
