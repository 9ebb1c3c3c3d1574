#include "worker/assets/nature/limb.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/kernel/shape.h"

namespace parallax {
namespace {

// Directions across a path, carried along without twist.
struct Frame {
  Vec3f along, x, y;
};
std::vector<Frame> FramesAlong(const std::vector<LimbRing>& rings) {
  std::vector<Frame> frames(rings.size());
  Vec3f x = Vec3f::Zero();
  for (size_t i = 0; i < rings.size(); ++i) {
    const size_t low = i > 0 ? i - 1 : 0, high = std::min(i + 1, rings.size() - 1);
    Vec3f along = rings[high].at - rings[low].at;
    along = along.squaredNorm() > 0 ? along.normalized()
                                    : (i > 0 ? frames[i - 1].along : Vec3f(Vec3f::UnitZ()));
    if (i == 0) x = std::abs(along.x()) < 0.8f ? Vec3f::UnitX() : Vec3f::UnitY();
    x = (x - x.dot(along) * along).normalized();
    frames[i] = {along, x, along.cross(x)};
  }
  return frames;
}

uint32_t AddVertex(Mesh& mesh, const Vec3f& at, const Vec3f& texture) {
  mesh.positions.push_back(at);
  mesh.normals.push_back(Vec3f::UnitZ());
  mesh.texture.push_back(texture);
  mesh.uv.push_back(Vec2f::Zero());
  return static_cast<uint32_t>(mesh.positions.size() - 1);
}

// A fan from the ring that starts at vertex `ring` to its middle, whose index it returns.
uint32_t AddEnd(Mesh& mesh, uint32_t ring, const Vec3f& middle, const Vec3f& texture, bool last,
                const LimbOptions& options) {
  const auto sides = static_cast<uint32_t>(options.sides);
  const bool cut = options.cut_slot >= 0;
  const uint16_t slot = cut ? static_cast<uint16_t>(options.cut_slot) : options.slot;
  uint32_t rim = ring;
  if (cut) {
    rim = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t k = 0; k < sides; ++k) {
      const Vec3f at = mesh.positions[ring + k], own = mesh.texture[ring + k];
      AddVertex(mesh, at, own);
    }
  }
  const uint32_t center = AddVertex(mesh, middle, texture);
  for (uint32_t k = 0; k < sides; ++k) {
    const uint32_t a = rim + k, b = rim + (k + 1) % sides;
    mesh.triangles.push_back(last ? Triangle{a, b, center, slot} : Triangle{b, a, center, slot});
  }
  return center;
}

}  // namespace

void SetNormals(Mesh& mesh, size_t first_vertex, size_t first_triangle) {
  for (size_t v = first_vertex; v < mesh.normals.size(); ++v) mesh.normals[v].setZero();
  for (size_t i = first_triangle; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const Vec3f n = (mesh.positions[t.b] - mesh.positions[t.a])
                        .cross(mesh.positions[t.c] - mesh.positions[t.a]);
    for (const uint32_t v : {t.a, t.b, t.c}) mesh.normals[v] += n;
  }
  for (size_t v = first_vertex; v < mesh.normals.size(); ++v) {
    Vec3f& n = mesh.normals[v];
    n = n.squaredNorm() > 1e-30f ? n.stableNormalized() : Vec3f(Vec3f::UnitZ());
  }
}

void AddLimb(Mesh& mesh, const std::vector<LimbRing>& rings, const LimbOptions& options) {
  const std::vector<Frame> frames = FramesAlong(rings);
  const size_t first_vertex = mesh.positions.size(), first_triangle = mesh.triangles.size();
  const auto sides = static_cast<uint32_t>(options.sides);
  const bool pointed = options.cut_slot < 0;
  const size_t count = pointed ? rings.size() - 1 : rings.size();  // The last is the tip.
  float along = 0;
  for (size_t i = 0; i < count; ++i) {
    if (i > 0) along += (rings[i].at - rings[i - 1].at).norm();
    for (uint32_t k = 0; k < sides; ++k) {
      const float a = 2 * kernel::kPi * static_cast<float>(k) / static_cast<float>(sides);
      const float factor = options.modulate ? options.modulate(a, along) : 1.0f;
      const float x = factor * rings[i].radius * std::cos(a),
                  y = factor * rings[i].radius * std::sin(a);
      AddVertex(mesh, rings[i].at + x * frames[i].x + y * frames[i].y,
                Vec3f(along, x, y) + options.texture_offset_m);
    }
  }
  const auto base = static_cast<uint32_t>(first_vertex);
  for (uint32_t i = 0; i + 1 < count; ++i) {
    for (uint32_t k = 0; k < sides; ++k) {
      const uint32_t a = base + i * sides + k, b = base + i * sides + (k + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides, options.slot});
      mesh.triangles.push_back({a, b + sides, a + sides, options.slot});
    }
  }
  const uint32_t start =
      AddEnd(mesh, base, rings.front().at, options.texture_offset_m, false, options);
  const Vec3f end = Vec3f((rings.back().at - rings[count - 1].at).norm() + along, 0, 0);
  const uint32_t tip = AddEnd(mesh, base + static_cast<uint32_t>(count - 1) * sides,
                              rings.back().at, end + options.texture_offset_m, true, options);
  SetNormals(mesh, first_vertex, first_triangle);
  // The sides of a slender tip nearly cancel out.
  mesh.normals[start] = -frames.front().along;
  mesh.normals[tip] = frames.back().along;
}

std::vector<LimbRing> SmoothRings(const std::vector<LimbRing>& rings, int steps) {
  kernel::Path3 path;
  for (const LimbRing& ring : rings) path.push_back(ring.at);
  const kernel::Path3 smooth = kernel::Spline(path, steps);
  std::vector<LimbRing> out;
  for (size_t i = 0; i < smooth.size(); ++i) {
    const size_t k = std::min(i / static_cast<size_t>(steps), rings.size() - 1);
    const float t = static_cast<float>(i % static_cast<size_t>(steps)) / static_cast<float>(steps);
    const float next = rings[std::min(k + 1, rings.size() - 1)].radius;
    out.push_back({smooth[i], kernel::Lerp(rings[k].radius, next, t)});
  }
  return out;
}

}  // namespace parallax
