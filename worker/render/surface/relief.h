// Bump mapping: a material's heights bend the shading normals of eight hits.
// Source: Blinn, "Simulation of wrinkled surfaces", SIGGRAPH 1978.
#pragma once

#include "worker/materials/kernel/material.h"

namespace parallax {

// The triangles of eight hits: two edges of each, in the world and as the material sees them.
struct Faces8 {
  Vec3x8 edge[2];          // Metres.
  Vec3x8 texture_edge[2];  // Metres.
  Float8 u_edge[2], v_edge[2];
};

// Bends `normals` (world, unit) and returns them, world and unit. Normals of slivers and of wide
// footprints stay as they are.
Vec3x8 BendNormals(const Material& material, const SurfacePoint8& points, const Faces8& faces,
                   const Vec3x8& normals);

}  // namespace parallax
