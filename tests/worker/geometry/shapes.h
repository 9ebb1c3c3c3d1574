// Simple closed meshes for geometry tests.
#pragma once

#include <cmath>
#include <numbers>

#include "worker/geometry/mesh.h"

namespace parallax::testing {

inline void AddVertex(Mesh& mesh, const Vec3f& p, const Vec3f& n) {
  mesh.positions.push_back(p);
  mesh.normals.push_back(n.normalized());
  mesh.texture.push_back(p);
  mesh.uv.push_back(Vec2f::Zero());
}

// An axis-aligned box about the origin, outward winding, shared corners.
inline Mesh BoxMesh(const Vec3f& half) {
  Mesh mesh;
  mesh.slots.push_back({"body", {"paint"}, false});
  for (int i = 0; i < 8; ++i) {
    const Vec3f p(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                  i & 4 ? half.z() : -half.z());
    AddVertex(mesh, p, p);
  }
  const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2], 0});
    mesh.triangles.push_back({q[0], q[2], q[3], 0});
  }
  return mesh;
}

// A torus about z.
inline Mesh TorusMesh(float major, float minor, int around = 24, int across = 12) {
  Mesh mesh;
  mesh.slots.push_back({"body", {"paint"}, false});
  const float tau = 2 * std::numbers::pi_v<float>;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const float a = tau * i / around, b = tau * j / across;
      const Vec3f out(std::cos(a), std::sin(a), 0);
      const Vec3f n = out * std::cos(b) + Vec3f(0, 0, std::sin(b));
      AddVertex(mesh, out * major + n * minor, n);
    }
  }
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const auto at = [&](int p, int q) {
        return static_cast<uint32_t>((p % around) * across + q % across);
      };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), 0});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1), 0});
    }
  }
  return mesh;
}

}  // namespace parallax::testing
