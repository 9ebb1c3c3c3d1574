// Builds architecture from closed, flat-shaded solids: boxes with small bevels, extruded profiles,
// turned handles, for worker/layout and worker/scene. Texture coordinates are metres with x along
// the grain that the caller names.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "worker/geometry/mesh.h"

namespace parallax {

// Collects solids into one mesh with material slots.
class PartBuilder {
 public:
  // The axis of the local frame along which the texture's x runs; its y and z are the next two axes
  // in order.
  enum class Grain { kX, kY, kZ };

  // Sets the placement of all solids added later.
  void SetFrame(const Eigen::Affine3f& world_from_local) { world_from_local_ = world_from_local; }

  uint16_t Slot(const std::string& name, const std::vector<std::string>& families);

  // Adds a convex polygon, counter-clockwise from outside. Texture coordinates are the local
  // points, turned to the grain.
  void Polygon(uint16_t slot, const std::vector<Vec3f>& points, Grain grain = Grain::kX);
  void Quad(uint16_t slot, const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
            Grain grain = Grain::kX) {
    Polygon(slot, {a, b, c, d}, grain);
  }
  // Adds a box whose twelve edges are cut at 45 degrees, `bevel_m` wide; 0 leaves them sharp.
  void Box(uint16_t slot, const Vec3f& low, const Vec3f& high, float bevel_m, Grain grain);
  // Adds a convex profile in the local (y, z) plane, counter-clockwise seen from +x, extruded from
  // x = `from` to `to`.
  void ExtrudeX(uint16_t slot, const std::vector<Vec2f>& profile, float from, float to);
  // Adds a closed cylinder with rounded rims between two local points, with smooth shading around
  // it.
  void Cylinder(uint16_t slot, const Vec3f& from, const Vec3f& to, float radius_m, int sides = 20);

  Mesh Take() { return std::move(mesh_); }

 private:
  uint32_t Vertex(const Vec3f& local, const Vec3f& normal, Grain grain);

  Mesh mesh_;
  Eigen::Affine3f world_from_local_ = Eigen::Affine3f::Identity();
};

}  // namespace parallax
