#include "worker/assets/kernel/shape.h"

#include <algorithm>
#include <cmath>

namespace parallax::kernel {
namespace {

// Normal times area; for quads by the diagonals, which is right for bent quads too.
Vec3f AreaNormal(const Shape& shape, const Face& face) {
  const auto& p = shape.points;
  if (face.corners == 3) {
    return 0.5f * (p[face.v[1]] - p[face.v[0]]).cross(p[face.v[2]] - p[face.v[0]]);
  }
  return 0.5f * (p[face.v[2]] - p[face.v[0]]).cross(p[face.v[3]] - p[face.v[1]]);
}

Vec3f UnitOr(const Vec3f& v, const Vec3f& fallback) {
  const float length = v.norm();
  return length > 1e-20f ? Vec3f(v / length) : fallback;
}

Shape Reflected(const Shape& shape, int axis) {
  Shape out = shape;
  for (Vec3f& p : out.points) p[axis] = -p[axis];
  for (Face& f : out.faces) {
    std::reverse(f.v.begin(), f.v.begin() + f.corners);
    std::reverse(f.uv.begin(), f.uv.begin() + f.corners);
  }
  return out;
}

}  // namespace

uint32_t Shape::AddPoint(const Vec3f& point, const Vec3f& texture_m) {
  points.push_back(point);
  texture.push_back(texture_m);
  return static_cast<uint32_t>(points.size() - 1);
}

void Shape::AddQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint8_t group) {
  if (a == b || b == c || c == d || d == a) {
    if (a == b) AddTriangle(b, c, d, group);
    if (b == c) AddTriangle(a, b, d, group);
    if (c == d) AddTriangle(a, b, c, group);
    if (d == a) AddTriangle(a, b, c, group);
    return;
  }
  faces.push_back({.v = {a, b, c, d}, .group = group});
}

void Shape::AddTriangle(uint32_t a, uint32_t b, uint32_t c, uint8_t group) {
  if (a == b || b == c || c == a) return;
  faces.push_back({.v = {a, b, c, c}, .corners = 3, .group = group});
}

void Shape::Add(const Shape& other) {
  const uint32_t base = static_cast<uint32_t>(points.size());
  points.insert(points.end(), other.points.begin(), other.points.end());
  texture.insert(texture.end(), other.texture.begin(), other.texture.end());
  faces.reserve(faces.size() + other.faces.size());
  for (Face f : other.faces) {
    for (uint32_t& v : f.v) v += base;
    faces.push_back(f);
  }
}

Box3f Shape::Bounds() const {
  Box3f box;
  for (const Vec3f& p : points) box.extend(p);
  return box;
}

float Shape::Volume() const {
  double six = 0;
  for (const Face& f : faces) {
    for (int i = 1; i + 1 < f.corners; ++i) {
      six += points[f.v[0]].cross(points[f.v[i]]).dot(points[f.v[i + 1]]);
    }
  }
  return static_cast<float>(six / 6.0);
}

Shape Shape::Moved(const Vec3f& by) const {
  Shape out = *this;
  for (Vec3f& p : out.points) p += by;
  return out;
}

Shape Shape::Turned(const Vec3f& axis, float angle_rad) const {
  const Mat3f rotation = Eigen::AngleAxisf(angle_rad, axis).toRotationMatrix();
  Shape out = *this;
  for (Vec3f& p : out.points) p = rotation * p;
  return out;
}

Shape Shape::Scaled(const Vec3f& factors) const {
  Shape out = *this;
  for (Vec3f& p : out.points) p = p.cwiseProduct(factors);
  const float mean = std::cbrt(factors.prod());
  for (Vec3f& t : out.texture) t *= mean;
  return out;
}

Shape Shape::Placed(const Eigen::Affine3f& to) const {
  Shape out = *this;
  for (Vec3f& p : out.points) p = to * p;
  return out;
}

Shape Shape::MirroredX() const { return Reflected(*this, 0); }
Shape Shape::MirroredY() const { return Reflected(*this, 1); }

Shape Shape::Bent(const std::function<Vec3f(const Vec3f&)>& map) const {
  Shape out = *this;
  for (Vec3f& p : out.points) p = map(p);
  return out;
}

Shape Shape::Creased(float angle_rad) const {
  Shape out = *this;
  out.crease_rad = angle_rad;
  return out;
}

Shape Shape::Retextured() const {
  Shape out = *this;
  TextureAlongLongest(out);
  return out;
}

Shape Shape::Grouped(uint8_t group) const {
  Shape out = *this;
  for (Face& f : out.faces) f.group = group;
  return out;
}

void TextureAlongLongest(Shape& shape) {
  const Vec3f size = shape.Bounds().sizes();
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (size[axis] > size[longest] * 1.0001f) longest = axis;
  }
  // Cyclic, so that the frame stays right-handed.
  const int second = (longest + 1) % 3, third = (longest + 2) % 3;
  for (size_t i = 0; i < shape.points.size(); ++i) {
    const Vec3f& p = shape.points[i];
    shape.texture[i] = {p[longest], p[second], p[third]};
  }
}

void PrintFaces(Shape& shape, const Vec3f& normal, const Vec3f& right, const Vec3f& up,
                uint8_t group) {
  std::vector<size_t> chosen;
  Box2f extent;
  for (size_t i = 0; i < shape.faces.size(); ++i) {
    const Vec3f n = AreaNormal(shape, shape.faces[i]);
    if (n.dot(normal) <= 0.5f * n.norm()) continue;
    chosen.push_back(i);
    for (int k = 0; k < shape.faces[i].corners; ++k) {
      const Vec3f& p = shape.points[shape.faces[i].v[k]];
      extent.extend(Vec2f(p.dot(right), p.dot(up)));
    }
  }
  if (chosen.empty()) return;
  const Vec2f size = extent.sizes().cwiseMax(1e-9f);
  for (size_t i : chosen) {
    Face& f = shape.faces[i];
    f.group = group;
    for (int k = 0; k < f.corners; ++k) {
      const Vec3f& p = shape.points[f.v[k]];
      f.uv[k] = (Vec2f(p.dot(right), p.dot(up)) - extent.min()).cwiseQuotient(size);
    }
  }
}

namespace {

// Normals of the faces, and the faces around each point.
struct FaceRing {
  explicit FaceRing(const Shape& shape)
      : start(shape.points.size() + 1, 0),
        area_normal(shape.faces.size()),
        unit_normal(shape.faces.size()) {
    for (const Face& f : shape.faces) {
      for (int k = 0; k < f.corners; ++k) ++start[f.v[k] + 1];
    }
    for (size_t i = 0; i < shape.points.size(); ++i) start[i + 1] += start[i];
    around.resize(start.back());
    std::vector<uint32_t> fill(start.begin(), start.end() - 1);
    for (size_t i = 0; i < shape.faces.size(); ++i) {
      const Face& f = shape.faces[i];
      area_normal[i] = AreaNormal(shape, f);
      unit_normal[i] = UnitOr(area_normal[i], Vec3f::Zero());
      for (int k = 0; k < f.corners; ++k) around[fill[f.v[k]]++] = static_cast<uint32_t>(i);
    }
  }

  // The normal of a face at a point: weighted by area over the faces that no crease divides from
  // it.
  Vec3f NormalAt(uint32_t point, size_t face, float cos_crease) const {
    Vec3f sum = Vec3f::Zero();
    for (uint32_t k = start[point]; k < start[point + 1]; ++k) {
      const uint32_t other = around[k];
      if (other == face || unit_normal[other].dot(unit_normal[face]) >= cos_crease) {
        sum += area_normal[other];
      }
    }
    return UnitOr(sum, unit_normal[face].isZero() ? Vec3f(Vec3f::UnitZ()) : unit_normal[face]);
  }

  std::vector<uint32_t> start,
      around;  // Faces around point i: around[start[i]] up to start[i + 1].
  std::vector<Vec3f> area_normal, unit_normal;
};

// Writes a shape's faces into a mesh as triangles. One vertex for each (point, normal, uv) that
// occurs; corners of a smooth surface share theirs.
class FaceWriter {
 public:
  FaceWriter(Mesh& mesh, const Shape& shape, const Vec3f& texture_offset_m)
      : mesh_(mesh),
        shape_(shape),
        offset_(texture_offset_m),
        ring_(shape),
        cos_crease_(std::cos(shape.crease_rad)),
        made_(shape.points.size()) {}

  void Write(size_t face, uint16_t slot) {
    if (shape_.faces[face].corners == 3) {
      Emit(face, slot, 0, 1, 2);
    } else if (CutAtFirst(face)) {
      Emit(face, slot, 0, 1, 2);
      Emit(face, slot, 0, 2, 3);
    } else {
      Emit(face, slot, 0, 1, 3);
      Emit(face, slot, 1, 2, 3);
    }
  }

 private:
  struct Corner {
    uint32_t vertex;
    Vec3f normal;
    Vec2f uv;
  };

  const Vec3f& Point(size_t face, int corner) const {
    return shape_.points[shape_.faces[face].v[corner]];
  }
  float Area(size_t face, int a, int b, int c) const {
    return (Point(face, b) - Point(face, a)).cross(Point(face, c) - Point(face, a)).norm();
  }

  // Whether a quad is cut from its first to its third corner: the shorter diagonal, unless a
  // triangle would have no area because points coincide or lie in a line.
  bool CutAtFirst(size_t face) const {
    const bool first = (Point(face, 2) - Point(face, 0)).squaredNorm() <=
                       (Point(face, 3) - Point(face, 1)).squaredNorm();
    const float cut_first = std::min(Area(face, 0, 1, 2), Area(face, 0, 2, 3)),
                cut_second = std::min(Area(face, 0, 1, 3), Area(face, 1, 2, 3));
    return (first ? cut_first : cut_second) < 1e-11f ? cut_first >= cut_second : first;
  }

  // Leaves out triangles whose points coincide.
  void Emit(size_t face, uint16_t slot, int a, int b, int c) {
    const Vec3f &p = Point(face, a), &q = Point(face, b), &r = Point(face, c);
    if (p == q || q == r || r == p) return;
    const uint32_t u = VertexOf(face, a), v = VertexOf(face, b), w = VertexOf(face, c);
    mesh_.triangles.push_back({u, v, w, slot});
  }

  uint32_t VertexOf(size_t face, int corner) {
    const Face& f = shape_.faces[face];
    const uint32_t point = f.v[corner];
    const Vec3f normal = ring_.NormalAt(point, face, cos_crease_);
    for (const Corner& c : made_[point]) {
      if (c.normal.dot(normal) > 0.99995f && c.uv == f.uv[corner]) return c.vertex;
    }
    const uint32_t vertex = static_cast<uint32_t>(mesh_.positions.size());
    mesh_.positions.push_back(shape_.points[point]);
    mesh_.normals.push_back(normal);
    mesh_.texture.push_back(shape_.texture[point] + offset_);
    mesh_.uv.push_back(f.uv[corner]);
    made_[point].push_back({vertex, normal, f.uv[corner]});
    return vertex;
  }

  Mesh& mesh_;
  const Shape& shape_;
  const Vec3f offset_;
  const FaceRing ring_;
  const float cos_crease_;
  std::vector<std::vector<Corner>> made_;  // Vertices of each point.
};

}  // namespace

void AppendShape(Mesh& mesh, const Shape& shape, const std::vector<uint16_t>& slot_of_group,
                 const Vec3f& texture_offset_m) {
  FaceWriter writer(mesh, shape, texture_offset_m);
  for (size_t i = 0; i < shape.faces.size(); ++i) {
    const size_t group = std::min<size_t>(shape.faces[i].group, slot_of_group.size() - 1);
    writer.Write(i, slot_of_group[group]);
  }
}

}  // namespace parallax::kernel
