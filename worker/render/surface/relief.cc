#include "worker/render/surface/relief.h"

#include "worker/render/surface/sampling.h"

namespace parallax {

PARALLAX_LANE_CLONES Vec3x8 BendNormals(const Material& material, const SurfacePoint8& points,
                                        const Faces8& faces, const Vec3x8& normals) {
  const Vec3x8 &e1 = faces.edge[0], &e2 = faces.edge[1];
  const Float8 g11 = Inner(e1, e1), g12 = Inner(e1, e2), g22 = Inner(e2, e2);
  const Float8 determinant = g11 * g22 - g12 * g12;
  const Mask8 seen = (determinant > 1e-10f * g11 * g22) &  // A sliver has no plane.
                     (points.footprint_m <= material.widest_relief_m());
  if (!Any(seen)) return normals;

  const Frame8 frame(normals);
  Tangents8 tangents;
  for (const int along : {0, 1}) {
    // Expresses the direction by the triangle's edges, and maps it to texture space.
    const Vec3x8& direction = along == 0 ? frame.x : frame.y;
    const Float8 b1 = Inner(direction, e1), b2 = Inner(direction, e2);
    const Float8 s = seen ? (g22 * b1 - g12 * b2) / determinant : Splat(0);
    const Float8 r = seen ? (g11 * b2 - g12 * b1) / determinant : Splat(0);
    tangents.texture[along] = faces.texture_edge[0] * s + faces.texture_edge[1] * r;
    tangents.u[along] = s * faces.u_edge[0] + r * faces.u_edge[1];
    tangents.v[along] = s * faces.v_edge[0] + r * faces.v_edge[1];
  }
  const Dual8 height = material.Relief(points, tangents);
  const Float8 dx = Clamp(height.dx, -4.0f, 4.0f), dy = Clamp(height.dy, -4.0f, 4.0f);
  const Mask8 bent = seen & ((dx != 0) | (dy != 0));
  const Vec3x8 normal = frame.z - frame.x * dx - frame.y * dy;
  return Select(bent, normal / Norm(normal), normals);
}

}  // namespace parallax
