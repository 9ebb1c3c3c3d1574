// Normals and triangles of meshes whose files have none.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

#include "worker/assets/files/mesh_parts.h"

namespace parallax {
namespace {

// Groups of numbers that can be joined.
class Groups {
 public:
  explicit Groups(size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }
  uint32_t Of(uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void Join(uint32_t a, uint32_t b) { parents_[Of(a)] = Of(b); }

 private:
  std::vector<uint32_t> parents_;
};

// An edge of a triangle, between two places; corners are numbered 3 * triangle + k.
struct Edge {
  uint32_t low = 0, high = 0;                // Places.
  uint32_t low_corner = 0, high_corner = 0;  // The triangle's corners there.
};

std::vector<Edge> SortedEdges(const MeshPart& part) {
  const std::vector<uint32_t> places = PlacesOf(part.positions);
  std::vector<Edge> edges;
  edges.reserve(3 * part.triangles.size());
  for (uint32_t t = 0; t < part.triangles.size(); ++t) {
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t from = 3 * t + k, to = 3 * t + (k + 1) % 3;
      Edge edge{places[part.triangles[t][k]], places[part.triangles[t][(k + 1) % 3]], from, to};
      if (edge.low > edge.high) {
        std::swap(edge.low, edge.high);
        std::swap(edge.low_corner, edge.high_corner);
      }
      edges.push_back(edge);
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.low_corner) < std::tie(b.low, b.high, b.low_corner);
  });
  return edges;
}

// The triangle's unit normal, 0 where it has no area.
Vec3d NormalOf(const MeshPart& part, const std::array<uint32_t, 3>& t) {
  const Vec3d& a = part.positions[t[0]];
  const Vec3d normal = (part.positions[t[1]] - a).cross(part.positions[t[2]] - a);
  const double length = normal.norm();
  return length > 0 && std::isfinite(length) ? Vec3d(normal / length) : Vec3d::Zero();
}

double AngleAt(const MeshPart& part, const std::array<uint32_t, 3>& t, size_t k) {
  const Vec3d& at = part.positions[t[k]];
  const Vec3d a = part.positions[t[(k + 1) % 3]] - at, b = part.positions[t[(k + 2) % 3]] - at;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

bool HasDirection(const Vec3f& normal) {
  const float length = normal.norm();
  return length > 1e-6f && std::isfinite(length);
}

// Replaces normals without a direction by those of their triangles.
void MendNormals(MeshPart& part) {
  std::vector<bool> mended(part.normals.size());
  for (const auto& t : part.triangles) {
    for (const uint32_t corner : t) {
      if (!mended[corner] && HasDirection(part.normals[corner])) continue;
      if (!mended[corner]) part.normals[corner].setZero();
      mended[corner] = true;
      part.normals[corner] += NormalOf(part, t).cast<float>();
    }
  }
}

// Whether p lies in the triangle, or on its edge.
bool Encloses(const Vec2d& a, const Vec2d& b, const Vec2d& c, const Vec2d& p) {
  const auto side = [&p](const Vec2d& from, const Vec2d& to) {
    return (to.x() - from.x()) * (p.y() - from.y()) - (to.y() - from.y()) * (p.x() - from.x());
  };
  return side(a, b) >= 0 && side(b, c) >= 0 && side(c, a) >= 0;
}

// Corners of a polygon in its own plane, counter-clockwise.
std::vector<Vec2d> InPlane(const std::vector<Vec3d>& positions,
                           const std::vector<uint32_t>& corners) {
  Vec3d normal = Vec3d::Zero();  // Newell's.
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3d a = positions[corners[i]] - positions[corners[0]];
    normal += a.cross(positions[corners[(i + 1) % corners.size()]] - positions[corners[0]]);
  }
  int drop = 0;
  normal.cwiseAbs().maxCoeff(&drop);
  const int u = (drop + 1) % 3, v = (drop + 2) % 3;
  std::vector<Vec2d> flat;
  for (const uint32_t corner : corners) {
    const Vec3d at = positions[corner] - positions[corners[0]];
    flat.emplace_back(normal[drop] < 0 ? Vec2d(at[v], at[u]) : Vec2d(at[u], at[v]));
  }
  return flat;
}

// Cuts off ears until three corners are left.   Source: Meisters, "Polygons have ears", 1975.
class EarClipper {
 public:
  explicit EarClipper(const std::vector<Vec2d>& flat) : flat_(flat), left_(flat.size()) {
    std::iota(left_.begin(), left_.end(), size_t{0});
  }

  // Calls `add` with places of corners.
  template <typename Add>
  void Clip(Add add) {
    size_t at = 1;  // A convex polygon becomes a fan about its first corner.
    for (size_t tries = 0; left_.size() > 3;) {
      const size_t n = left_.size(), i = at % n;
      const size_t before = left_[(i + n - 1) % n], after = left_[(i + 1) % n];
      // Where nothing is an ear, or few are, the polygon crosses itself: any corner will do.
      if (looks_ > 4 * flat_.size() || tries >= n || IsEar(before, left_[i], after)) {
        add(before, left_[i], after);
        left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i));
        tries = 0;
      } else {
        ++at;
        ++tries;
      }
    }
    add(left_[0], left_[1], left_[2]);
  }

 private:
  bool IsEar(size_t a, size_t b, size_t c) {
    ++looks_;
    const Vec2d ab = flat_[b] - flat_[a], bc = flat_[c] - flat_[b];
    if (ab.x() * bc.y() - ab.y() * bc.x() <= 0) return false;
    return std::none_of(left_.begin(), left_.end(), [&](size_t i) {
      return i != a && i != b && i != c && flat_[i] != flat_[a] && flat_[i] != flat_[b] &&
             flat_[i] != flat_[c] && Encloses(flat_[a], flat_[b], flat_[c], flat_[i]);
    });
  }

  const std::vector<Vec2d>& flat_;
  std::vector<size_t> left_;
  size_t looks_ = 0;
};

}  // namespace

double FloatStep(const std::vector<Vec3d>& positions) {
  double far = 0;
  for (const Vec3d& at : positions) far = std::max(far, at.cwiseAbs().maxCoeff());
  return far * std::numeric_limits<float>::epsilon();
}

std::vector<uint32_t> PlacesOf(const std::vector<Vec3d>& positions) {
  const auto key = [&](uint32_t v) {
    return std::tuple(positions[v].x(), positions[v].y(), positions[v].z());
  };
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  std::vector<uint32_t> places(positions.size());
  uint32_t place = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && key(order[i]) != key(order[i - 1])) ++place;
    places[order[i]] = place;
  }
  return places;
}

void AddNormals(MeshPart& part, double crease_deg) {
  if (!part.normals.empty()) return MendNormals(part);
  std::vector<Vec3d> normals;
  for (const auto& t : part.triangles) normals.push_back(NormalOf(part, t));
  Groups groups(3 * part.triangles.size());
  if (crease_deg >= 0) {
    const double least = std::cos(crease_deg * std::numbers::pi / 180);
    const std::vector<Edge> edges = SortedEdges(part);
    for (size_t i = 1; i < edges.size(); ++i) {
      const Edge &a = edges[i - 1], &b = edges[i];
      if (a.low != b.low || a.high != b.high) continue;
      if (normals[a.low_corner / 3].dot(normals[b.low_corner / 3]) <= least) continue;
      groups.Join(a.low_corner, b.low_corner);
      groups.Join(a.high_corner, b.high_corner);
    }
  }
  std::vector<Vec3d> sums(3 * part.triangles.size(), Vec3d::Zero());
  for (uint32_t c = 0; c < sums.size(); ++c) {
    sums[groups.Of(c)] += AngleAt(part, part.triangles[c / 3], c % 3) * normals[c / 3];
  }
  MeshPart split;
  split.material = part.material;
  split.triangles = part.triangles;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> vertices;  // By vertex and group.
  for (uint32_t c = 0; c < sums.size(); ++c) {
    uint32_t& corner = split.triangles[c / 3][c % 3];
    const uint32_t group = groups.Of(c);
    const auto [entry, is_new] =
        vertices.try_emplace({corner, group}, static_cast<uint32_t>(split.positions.size()));
    if (is_new) {
      split.positions.push_back(part.positions[corner]);
      split.normals.push_back(sums[group].cast<float>());
      if (!part.uv.empty()) split.uv.push_back(part.uv[corner]);
    }
    corner = entry->second;
  }
  part = std::move(split);
}

void AddPolygon(const std::vector<Vec3d>& positions, const std::vector<uint32_t>& corners,
                std::vector<std::array<uint32_t, 3>>& triangles) {
  constexpr size_t kMostClipped = 5'000;
  const auto add = [&](size_t a, size_t b, size_t c) {
    triangles.push_back({corners[a], corners[b], corners[c]});
  };
  if (corners.size() < 3) return;
  if (corners.size() == 3) return add(0, 1, 2);
  if (corners.size() > kMostClipped) {
    for (size_t i = 2; i < corners.size(); ++i) add(0, i - 1, i);
    return;
  }
  EarClipper(InPlane(positions, corners)).Clip(add);
}

}  // namespace parallax
