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
  Face face;
  face.v = {a, b, c, d};
  face.group = group;
  faces.push_back(face);
}

void Shape::AddTriangle(uint32_t a, uint32_t b, uint32_t c, uint8_t group) {
  if (a == b || b == c || c == a) return;
  Face face;
  face.v = {a, b, c, c};
  face.corners = 3;
  face.group = group;
  faces.push_back(face);
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

void AppendShape(Mesh& mesh, const Shape& shape, const std::vector<uint16_t>& slot_of_group,
                 const Vec3f& texture_offset_m) {
  // Faces around each point.
  const size_t point_count = shape.points.size();
  std::vector<uint32_t> start(point_count + 1, 0);
  for (const Face& f : shape.faces) {
    for (int k = 0; k < f.corners; ++k) ++start[f.v[k] + 1];
  }
  for (size_t i = 0; i < point_count; ++i) start[i + 1] += start[i];
  std::vector<uint32_t> around(start.back());
  std::vector<uint32_t> fill(start.begin(), start.end() - 1);
  std::vector<Vec3f> area_normal(shape.faces.size());
  std::vector<Vec3f> unit_normal(shape.faces.size());
  for (size_t i = 0; i < shape.faces.size(); ++i) {
    const Face& f = shape.faces[i];
    area_normal[i] = AreaNormal(shape, f);
    unit_normal[i] = UnitOr(area_normal[i], Vec3f::Zero());
    for (int k = 0; k < f.corners; ++k) around[fill[f.v[k]]++] = static_cast<uint32_t>(i);
  }

  // One vertex for each (point, normal, uv) that occurs; corners of a smooth surface share theirs.
  struct Corner {
    uint32_t vertex;
    Vec3f normal;
    Vec2f uv;
  };
  std::vector<std::vector<Corner>> made(point_count);
  const float cos_crease = std::cos(shape.crease_rad);
  const auto vertex_of = [&](size_t face_index, int corner) -> uint32_t {
    const Face& f = shape.faces[face_index];
    const uint32_t point = f.v[corner];
    Vec3f sum = Vec3f::Zero();
    for (uint32_t k = start[point]; k < start[point + 1]; ++k) {
      const uint32_t other = around[k];
      if (other == face_index || unit_normal[other].dot(unit_normal[face_index]) >= cos_crease) {
        sum += area_normal[other];
      }
    }
    const Vec3f normal = UnitOr(
        sum, unit_normal[face_index].isZero() ? Vec3f(Vec3f::UnitZ()) : unit_normal[face_index]);
    for (const Corner& c : made[point]) {
      if (c.normal.dot(normal) > 0.99995f && c.uv == f.uv[corner]) return c.vertex;
    }
    const uint32_t vertex = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.push_back(shape.points[point]);
    mesh.normals.push_back(normal);
    mesh.texture.push_back(shape.texture[point] + texture_offset_m);
    mesh.uv.push_back(f.uv[corner]);
    made[point].push_back({vertex, normal, f.uv[corner]});
    return vertex;
  };

  for (size_t i = 0; i < shape.faces.size(); ++i) {
    const Face& f = shape.faces[i];
    const uint16_t slot = slot_of_group[std::min<size_t>(f.group, slot_of_group.size() - 1)];
    // Where points coincide or lie in a line, a triangle would have no area: it is left out, or the
    // quad is cut the other way.
    const auto corner = [&](int k) -> const Vec3f& { return shape.points[f.v[k]]; };
    const auto area = [&](int a, int b, int c) {
      return (corner(b) - corner(a)).cross(corner(c) - corner(a)).norm();
    };
    const auto emit = [&](int a, int b, int c) {
      if (corner(a) == corner(b) || corner(b) == corner(c) || corner(c) == corner(a)) return;
      const uint32_t u = vertex_of(i, a), v = vertex_of(i, b), w = vertex_of(i, c);
      mesh.triangles.push_back({u, v, w, slot});
    };
    if (f.corners == 3) {
      emit(0, 1, 2);
      continue;
    }
    bool first = (corner(2) - corner(0)).squaredNorm() <= (corner(3) - corner(1)).squaredNorm();
    const float cut_first = std::min(area(0, 1, 2), area(0, 2, 3)),
                cut_second = std::min(area(0, 1, 3), area(1, 2, 3));
    if ((first ? cut_first : cut_second) < 1e-11f) first = cut_first >= cut_second;
    if (first) {
      emit(0, 1, 2);
      emit(0, 2, 3);
    } else {
      emit(0, 1, 3);
      emit(1, 2, 3);
    }
  }
}

}  // namespace parallax::kernel
