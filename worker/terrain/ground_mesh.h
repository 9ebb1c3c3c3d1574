// The ground as one triangle mesh for a whole walk: fine near the eyes, coarse far away, out to the
// horizon.
//
// A restricted quadtree (neighbouring leaves differ by at most one level). Each leaf is a fan about
// its centre that includes the corners of finer neighbours: no T-junctions, no cracks. The mesh is
// the same for all frames and both eyes, so nothing pops. Plants use HeightAt, the height of the
// rendered triangles rather than of the exact terrain.
//
// The same tree meshes the surface of water: with other heights, and only where water may be.
//
// Constant after construction; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "worker/geometry/mesh.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// The view of one frame of the walk, from above.
struct ViewCone {
  Vec2f apex = Vec2f::Zero();   // World, metres.
  float eye_height_m = 1.6f;    // Above the ground.
  float heading_rad = 0;        // Direction of the optical axis: 0 = +x, counter-clockwise.
  float half_angle_rad = 0.5f;  // Half of the horizontal field of view and a margin.
};

// The views and the budget of triangles.
struct GroundMeshOptions {
  std::vector<ViewCone> views;  // At least one.
  float focal_px = 2000;
  float edge_px = 6;      // The least length of an edge in any view.
  float out_of_view = 5;  // Factor on edges where no view looks.
  float least_edge_m = 0.03f;
  float reach_m = 28'000;        // Half of the mesh's side: to the horizon.
  int most_triangles = 700'000;  // Spent on the edges that look longest.
};

// A surface to be meshed. Its functions take world metres and are called only by the constructor.
struct MeshedSurface {
  std::string slot, family;  // Name and family of the mesh's only slot.
  std::function<float(const Vec2f& p, float footprint_m)> height;
  std::function<Vec2f(const Vec2f& p, float footprint_m)> slope;  // d/dx, d/dy.
  std::function<float(const Vec2f& p)> steepness;                 // Rise over run, without detail.
  // Factor on edges in the square about `center`, half a side long, because less of it is seen;
  // infinity: the square is not meshed. Null: 1.
  std::function<float(const Vec2f& center, float half_m)> coarser;
  // Horizontal displacement of a face, downhill, at a place and height, metres. Null: 0.
  std::function<float(const Vec2f& p, float height_m)> ledge;
  // The footprint with which edges of a length query the surface; it becomes the first number of
  // the vertices' uv. Null: the edge's length, and uv is 0.
  std::function<float(float edge_m)> footprint;
};
// Returns the ground as a surface to be meshed. `terrain` must outlive the result. Ground under
// deep water is coarse.
MeshedSurface GroundOf(const Terrain& terrain);
// Returns the water's surface, with the waves that the edges can show. Requires a terrain with
// water.
MeshedSurface WaterOf(const Terrain& terrain);

// The mesh and its quadtree.
class GroundMesh {
 public:
  GroundMesh(const Terrain& terrain, const GroundMeshOptions& options);
  GroundMesh(const MeshedSurface& surface, const GroundMeshOptions& options);

  // Returns the mesh in the world frame. Its texture coordinates are its positions; it has one
  // slot. Normals are those of the surface, not of the triangles.
  const Mesh& mesh() const { return mesh_; }
  // Returns the height of the mesh at `p`, metres, without ledges; outside the mesh, that of the
  // nearest point of its border. 0 in a square that is not meshed.
  float HeightAt(const Vec2f& p) const;
  // Returns the longest edge in any view, in pixels (edges of least_edge_m left out).
  float longest_edge_px() const { return longest_edge_px_; }

 private:
  // A square of the quadtree.
  struct Node {
    uint32_t first_child = 0;  // The first of four, ordered by y, then x; 0 = a leaf.
    uint32_t first_triangle = 0;
    uint16_t triangles = 0;  // A leaf's fan.
  };
  // A node and its place, in units of half of the finest leaf's side.
  struct Square {
    uint32_t node = 0;
    int x = 0, y = 0, side = 0;
  };
  // A vertex before it is made, in the same units.
  struct Vertex {
    int x = 0, y = 0;
    float footprint_m = 0;
  };

  // Returns the length covered by a pixel at the square, metres: the least over all views. Infinity
  // outside of the surface.
  float PixelAt(const MeshedSurface& surface, const Square& square) const;
  std::array<Square, 4> Split(const Square& square);
  void Refine(const MeshedSurface& surface);
  void Balance();
  Square LeafAt(int x, int y) const;
  bool Contains(int x, int y) const { return x >= 0 && y >= 0 && x < side_ && y < side_; }
  template <typename Visit>
  void ForEachLeaf(const Visit& visit) const;

  void Triangulate(const MeshedSurface& surface);
  // Moves the vertices of steep faces out to the ledges.
  void StandOut(const MeshedSurface& surface);
  void AddFan(const MeshedSurface& surface, const Square& leaf);
  // Returns the vertex's number, which is a new one for a new place.
  uint32_t VertexAt(int x, int y, float footprint_m);
  void MakeVertices(const MeshedSurface& surface);
  Vec2f PositionOf(int x, int y) const;

  GroundMeshOptions options_;
  float unit_m_ = 1;
  int side_ = 0;  // Side of the root, in units.
  float longest_edge_px_ = 0;
  std::vector<Node> nodes_;
  std::unordered_map<uint64_t, uint32_t> numbers_;  // Vertices' numbers by place; empty once made.
  std::vector<Vertex> vertices_;                    // By number; empty after construction.
  std::vector<Vec2f> plan_;  // Positions in plan before StandOut; empty: unchanged.
  Mesh mesh_;
};

}  // namespace parallax
