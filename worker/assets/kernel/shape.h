// Shape: one solid part of an object while it is being modelled: shared points, polygon faces,
// texture coordinates.
//
// Invariants: faces are counter-clockwise seen from outside; a finished part is closed (each edge
// belongs to two faces that run it in opposite directions) unless it says otherwise; `texture` is
// as long as `points` and stays as made when the points are bent later, so the grain follows the
// bend. Values; not thread-safe to write.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/types.h"
#include "worker/geometry/mesh.h"

namespace parallax::kernel {

inline constexpr float kPi = 3.14159265358979f;
inline constexpr float kTau = 2 * kPi;

// A triangle or quad. `group` separates faces that get other slots (a book's cover and its pages).
struct Face {
  std::array<uint32_t, 4> v{};
  uint8_t corners = 4;  // 3 or 4.
  uint8_t group = 0;
  std::array<Vec2f, 4> uv{Vec2f::Zero(), Vec2f::Zero(), Vec2f::Zero(), Vec2f::Zero()};
};

// A solid part.
struct Shape {
  std::vector<Vec3f> points;   // Metres, part frame.
  std::vector<Vec3f> texture;  // Metres; x along the grain.
  std::vector<Face> faces;
  // Edges that bend more are sharp; 0.9 keeps a 45 degree bevel step smooth.
  float crease_rad = 0.9f;

  uint32_t AddPoint(const Vec3f& point) { return AddPoint(point, point); }
  uint32_t AddPoint(const Vec3f& point, const Vec3f& texture_m);
  void AddQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint8_t group = 0);
  // Ignores a triangle that names a point twice.
  void AddTriangle(uint32_t a, uint32_t b, uint32_t c, uint8_t group = 0);
  // Appends the other's points and faces.
  void Add(const Shape& other);

  Box3f Bounds() const;
  // Signed enclosed volume, m^3; positive when faces look outwards.
  float Volume() const;

  // The following return copies; only Scaled and Retextured change texture coordinates.
  Shape Moved(const Vec3f& by) const;
  Shape Moved(float x, float y, float z) const { return Moved(Vec3f(x, y, z)); }
  Shape Turned(const Vec3f& axis, float angle_rad) const;  // About the origin, right-handed.
  Shape TurnedX(float angle_rad) const { return Turned(Vec3f::UnitX(), angle_rad); }
  Shape TurnedY(float angle_rad) const { return Turned(Vec3f::UnitY(), angle_rad); }
  Shape TurnedZ(float angle_rad) const { return Turned(Vec3f::UnitZ(), angle_rad); }
  Shape Scaled(const Vec3f& factors) const;  // Factors > 0; texture coordinates are scaled too.
  Shape Placed(const Eigen::Affine3f& to) const;
  // A reflected part; its faces are reversed to look outwards.
  Shape MirroredX() const;
  Shape MirroredY() const;
  Shape Bent(const std::function<Vec3f(const Vec3f&)>& map) const;
  Shape Creased(float crease_rad) const;
  // Takes texture coordinates from the points again, x along the longest side.
  Shape Retextured() const;
  // Puts all faces into the group.
  Shape Grouped(uint8_t group) const;
};

// Sets texture x to the longest side of the shape, y and z to the other two in order.
void TextureAlongLongest(Shape& shape);

// Prints a picture on the faces whose normal is within 60 degrees of `normal`: they get `group`,
// and uv runs over [0, 1]^2 along `right` and `up` (unit, orthogonal) over those faces' extent.
void PrintFaces(Shape& shape, const Vec3f& normal, const Vec3f& right, const Vec3f& up,
                uint8_t group);

// Appends the shape to the mesh with smooth normals split at creases. `slot_of_group` maps face
// groups to mesh slots; groups beyond its end take its last entry. `texture_offset_m` is added to
// the texture coordinates.
void AppendShape(Mesh& mesh, const Shape& shape, const std::vector<uint16_t>& slot_of_group,
                 const Vec3f& texture_offset_m);

}  // namespace parallax::kernel
