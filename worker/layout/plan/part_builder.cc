#include "worker/layout/plan/part_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace parallax {
namespace {

Vec3f TextureOf(const Vec3f& p, PartBuilder::Grain grain) {
  switch (grain) {
    case PartBuilder::Grain::kX:
      return p;
    case PartBuilder::Grain::kY:
      return {p.y(), p.z(), p.x()};
    case PartBuilder::Grain::kZ:
      return {p.z(), p.x(), p.y()};
  }
  return p;
}

}  // namespace

uint16_t PartBuilder::Slot(const std::string& name, const std::vector<std::string>& families) {
  for (size_t i = 0; i < mesh_.slots.size(); ++i) {
    if (mesh_.slots[i].name == name) return static_cast<uint16_t>(i);
  }
  mesh_.slots.push_back({name, families, false});
  return static_cast<uint16_t>(mesh_.slots.size() - 1);
}

uint32_t PartBuilder::Vertex(const Vec3f& local, const Vec3f& normal, Grain grain) {
  mesh_.positions.push_back(world_from_local_ * local);
  mesh_.normals.push_back((world_from_local_.linear() * normal).normalized());
  mesh_.texture.push_back(TextureOf(local, grain));
  mesh_.uv.push_back(Vec2f::Zero());
  return static_cast<uint32_t>(mesh_.positions.size() - 1);
}

void PartBuilder::Polygon(uint16_t slot, const std::vector<Vec3f>& points, Grain grain) {
  const Vec3f normal = (points[1] - points[0]).cross(points[2] - points[0]).normalized();
  std::vector<uint32_t> v;
  for (const Vec3f& p : points) v.push_back(Vertex(p, normal, grain));
  for (size_t i = 2; i < v.size(); ++i) mesh_.triangles.push_back({v[0], v[i - 1], v[i], slot});
}

void PartBuilder::Box(uint16_t slot, const Vec3f& low, const Vec3f& high, float bevel_m,
                      Grain grain) {
  const Vec3f center = 0.5f * (low + high), half = 0.5f * (high - low);
  const float bevel = std::min(bevel_m, 0.4f * half.minCoeff());
  // Corner (sx, sy, sz) as seen by the face of `axis`: in that axis it stands out in full.
  const auto corner = [&](int axis, const Vec3f& sign) {
    Vec3f p = half - Vec3f::Constant(bevel);
    p[axis] = half[axis];
    return Vec3f(center + sign.cwiseProduct(p));
  };
  const auto outward = [&](std::vector<Vec3f> points) {
    const Vec3f normal = (points[1] - points[0]).cross(points[2] - points[0]);
    Vec3f middle = Vec3f::Zero();
    for (const Vec3f& p : points) middle += p;
    middle /= static_cast<float>(points.size());
    if (normal.dot(middle - center) < 0) std::reverse(points.begin(), points.end());
    Polygon(slot, points, grain);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const float side : {-1.0f, 1.0f}) {
      std::vector<Vec3f> face;
      for (const auto& [su, sv] : {std::pair{-1.f, -1.f}, {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
        Vec3f sign;
        sign[axis] = side;
        sign[u] = su;
        sign[v] = sv;
        face.push_back(corner(axis, sign));
      }
      outward(face);
    }
  }
  if (bevel <= 0) return;
  for (int axis = 0; axis < 3; ++axis) {  // Edges along `axis`.
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const float su : {-1.0f, 1.0f}) {
      for (const float sv : {-1.0f, 1.0f}) {
        Vec3f near, far;
        near[axis] = -1;
        far[axis] = 1;
        near[u] = far[u] = su;
        near[v] = far[v] = sv;
        outward({corner(u, near), corner(u, far), corner(v, far), corner(v, near)});
      }
    }
  }
  for (int i = 0; i < 8; ++i) {
    const Vec3f sign(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
    outward({corner(0, sign), corner(1, sign), corner(2, sign)});
  }
}

void PartBuilder::ExtrudeX(uint16_t slot, const std::vector<Vec2f>& profile, float from, float to) {
  const size_t n = profile.size();
  std::vector<Vec3f> start, end;
  for (size_t i = 0; i < n; ++i) {
    const Vec2f &p = profile[i], &q = profile[(i + 1) % n];
    Quad(slot, {from, p.x(), p.y()}, {from, q.x(), q.y()}, {to, q.x(), q.y()}, {to, p.x(), p.y()});
    end.push_back({to, p.x(), p.y()});
    start.push_back({from, profile[n - 1 - i].x(), profile[n - 1 - i].y()});
  }
  Polygon(slot, start);
  Polygon(slot, end);
}

void PartBuilder::Cylinder(uint16_t slot, const Vec3f& from, const Vec3f& to, float radius_m,
                           int sides) {
  const Vec3f axis = (to - from).normalized();
  const Vec3f u = axis.unitOrthogonal(), v = axis.cross(u);
  const float length = (to - from).norm(), rim = std::min(0.25f * radius_m, 0.3f * length);
  struct Ring {
    float along, radius;
    float out;  // Normal: cosine with the radius.
  };
  const Ring rings[] = {{0, radius_m - rim, 0.4f},
                        {rim, radius_m, 0.9f},
                        {length - rim, radius_m, 0.9f},
                        {length, radius_m - rim, 0.4f}};
  std::vector<std::vector<uint32_t>> at;
  for (int r = 0; r < 4; ++r) {
    std::vector<uint32_t> ring;
    for (int i = 0; i < sides; ++i) {
      const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / sides;
      const Vec3f out = u * std::cos(angle) + v * std::sin(angle);
      const float lean = std::sqrt(1 - rings[r].out * rings[r].out) * (r < 2 ? -1.0f : 1.0f);
      ring.push_back(Vertex(from + axis * rings[r].along + out * rings[r].radius,
                            out * rings[r].out + axis * lean, Grain::kX));
    }
    at.push_back(ring);
  }
  for (int r = 0; r < 3; ++r) {
    for (int i = 0; i < sides; ++i) {
      const int j = (i + 1) % sides;
      mesh_.triangles.push_back({at[r][i], at[r][j], at[r + 1][j], slot});
      mesh_.triangles.push_back({at[r][i], at[r + 1][j], at[r + 1][i], slot});
    }
  }
  std::vector<Vec3f> bottom, top;
  for (int i = 0; i < sides; ++i) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / sides;
    const Vec3f out = u * std::cos(angle) + v * std::sin(angle);
    top.push_back(to + out * rings[3].radius);
    bottom.insert(bottom.begin(), from + out * rings[0].radius);
  }
  Polygon(slot, bottom);
  Polygon(slot, top);
}

}  // namespace parallax
