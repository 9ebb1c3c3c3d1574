// RenderScene's storage of bodies, for the sources that fill it and read it.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Embree reads 16 bytes at a float3: one more float must follow the last vertex.
using Positions = std::vector<Vec3f>;

// One vertex in 32 bytes, loaded into lanes at once.
struct alignas(32) RenderScene::Vertex {
  Vec3f normal;
  Vec3f texture;
  Vec2f uv;

  Vertex() = default;
  Vertex(const Vec3f& n, const Vec3f& t, const Vec2f& at) : normal(n), texture(t), uv(at) {}
  Float8 Load() const { return _mm256_load_ps(normal.data()); }
};

// The part of a body that every hit reads, half a cache line: shading waits for memory more than it
// computes.
struct alignas(32) RenderScene::Body {
  const Triangle* triangles = nullptr;
  const Vertex* vertices = nullptr;  // Object frame.
  const Vec3f* positions = nullptr;  // World frame, or object frame when instanced.
  uint32_t first_material = 0;       // In materials_, by slot.
  uint16_t slots = 0;
  bool instanced = false;
};

// A body's placement: for normals, and the scale of footprints.
struct alignas(64) RenderScene::Place {
  Mat3f normal_from_object = Mat3f::Identity();
  float scale = 1;
};

// The arrays that a mesh or a prototype owns; bodies point into them.
struct RenderScene::Stored {
  std::shared_ptr<const Positions> owned_positions;
  std::shared_ptr<const std::vector<Vertex>> owned_vertices;
};

}  // namespace parallax
