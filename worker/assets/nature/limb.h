// Trunks, limbs, twigs and stalks: closed tubes along a line of points, each with its radius.
#pragma once

#include <functional>
#include <vector>

#include "worker/geometry/mesh.h"

namespace parallax {

// One ring of a tube.
struct LimbRing {
  Vec3f at = Vec3f::Zero();
  float radius = 0.01f;
};

// The cross-section and ends of a tube.
struct LimbOptions {
  int sides = 6;
  // Factor on the radius at an angle and a distance from the first ring; null: 1.
  std::function<float(float angle_rad, float along_m)> modulate;
  // Slot of flat ends with sharp rims; negative: ends that taper or hide in other parts.
  int cut_slot = -1;
  uint16_t slot = 0;
  Vec3f texture_offset_m = Vec3f::Zero();
};

// Appends the tube; its texture is solid: x along it, y and z across. Requires two rings apart.
void AddLimb(Mesh& mesh, const std::vector<LimbRing>& rings, const LimbOptions& options);

// A smooth line through the rings, `steps` pieces between two.
std::vector<LimbRing> SmoothRings(const std::vector<LimbRing>& rings, int steps);

// Sets the normals of the vertices from `first` on from the triangles that share them.
void SetNormals(Mesh& mesh, size_t first_vertex, size_t first_triangle);

}  // namespace parallax
