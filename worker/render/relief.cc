#include "worker/render/relief.h"

#include "worker/render/sampling.h"

namespace parallax {
namespace {

// Relief is a few millimetres high: a wider footprint than this averages it away.
constexpr float kWidestRelief_m = 0.1f;

}  // namespace

PARALLAX_LANE_CLONES Vec3x8 BendNormals(const Material& material, const SurfacePoint8& points,
                                        const Faces8& faces, const Vec3x8& normals) {
  const Vec3x8 &e1 = faces.edge[0], &e2 = faces.edge[1];
  const Float8 g11 = Inner(e1, e1), g12 = Inner(e1, e2), g22 = Inner(e2, e2);
  const Float8 determinant = g11 * g22 - g12 * g12;
  const Mask8 seen = (determinant > 1e-10f * g11 * g22) &  // A sliver has no plane.
                     (points.footprint_m <= kWidestRelief_m);
  if (!Any(seen)) return normals;

  const Float8 height = material.Height(points);
  const Float8 step = Clamp(0.5f * points.footprint_m, 5e-5f, 0.02f);
  const auto slope = [&](const Vec3x8& tangent) {
    // The tangent in terms of the triangle's edges, then the same step in texture space.
    const Float8 b1 = Inner(tangent, e1), b2 = Inner(tangent, e2), none = Splat(0);
    const Float8 s = seen ? (g22 * b1 - g12 * b2) / determinant * step : none;
    const Float8 r = seen ? (g11 * b2 - g12 * b1) / determinant * step : none;
    SurfacePoint8 moved = points;
    moved.texture_m = points.texture_m + (faces.texture_edge[0] * s + faces.texture_edge[1] * r);
    moved.u += s * faces.u_edge[0] + r * faces.u_edge[1];
    moved.v += s * faces.v_edge[0] + r * faces.v_edge[1];
    return Clamp((material.Height(moved) - height) / step, -4.0f, 4.0f);
  };
  const Frame8 frame(normals);
  const Float8 dx = slope(frame.x), dy = slope(frame.y);
  const Mask8 bent = seen & ((dx != 0) | (dy != 0));
  const Vec3x8 normal = frame.z - frame.x * dx - frame.y * dy;
  return Select(bent, normal / Norm(normal), normals);
}

}  // namespace parallax
