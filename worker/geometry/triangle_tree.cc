#include "worker/geometry/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace parallax {
namespace {

constexpr uint32_t kLeafSize = 4;
constexpr size_t kMaxPartPoints = 48;

// Irrational directions, so that rays rarely meet edges of axis-aligned furniture.
const Vec3f kProbes[3] = {Vec3f(0.8017837f, 0.2672612f, 0.5345225f),
                          Vec3f(-0.4242641f, 0.7071068f, 0.5656854f),
                          Vec3f(0.1690309f, -0.5070926f, -0.8451543f)};

bool RayMeetsBox(const Box3f& box, const Vec3f& origin, const Vec3f& inverse) {
  const Eigen::Array3f t0 = (box.min() - origin).array() * inverse.array();
  const Eigen::Array3f t1 = (box.max() - origin).array() * inverse.array();
  const float enter = t0.min(t1).maxCoeff();
  const float leave = t0.max(t1).minCoeff();
  return leave >= std::max(enter, 0.0f);
}

// The part of line L = planes' intersection that lies in a triangle, from projections and signed
// distances.
struct Interval {
  float low, high;
};
Interval LineInterval(const std::array<float, 3>& along, const std::array<float, 3>& distance) {
  // The vertex that is alone on its side.
  int alone = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if ((distance[j] > 0) == (distance[k] > 0)) {
      alone = i;
      break;
    }
  }
  const auto cut = [&](int other) {
    const float span = distance[alone] - distance[other];
    return along[alone] + (along[other] - along[alone]) * (distance[alone] / span);
  };
  const float p = cut((alone + 1) % 3), q = cut((alone + 2) % 3);
  return {std::min(p, q), std::max(p, q)};
}

std::array<Vec3f, 3> Corners(const TriangleTree& tree, uint32_t triangle) {
  const auto& t = tree.triangles()[triangle];
  return {tree.positions()[t[0]], tree.positions()[t[1]], tree.positions()[t[2]]};
}

bool SurfacesCross(const TriangleTree& a, const TriangleTree& b, const Eigen::Affine3f& a_from_b,
                   float tolerance) {
  std::vector<std::pair<uint32_t, uint32_t>> stack = {{0, 0}};
  while (!stack.empty()) {
    const auto [ia, ib] = stack.back();
    stack.pop_back();
    const TriangleTree::Node& na = a.nodes()[ia];
    const TriangleTree::Node& nb = b.nodes()[ib];
    const Box3f box_b = TransformBox(a_from_b, nb.box);
    if (!na.box.intersects(box_b)) continue;
    if (na.count > 0 && nb.count > 0) {
      for (uint32_t j = nb.first; j < nb.first + nb.count; ++j) {
        auto tb = Corners(b, b.order()[j]);
        for (Vec3f& corner : tb) corner = a_from_b * corner;
        for (uint32_t i = na.first; i < na.first + na.count; ++i) {
          if (TrianglesCross(Corners(a, a.order()[i]), tb, tolerance)) return true;
        }
      }
    } else if (nb.count > 0 || (na.count == 0 && na.box.diagonal().squaredNorm() >=
                                                     box_b.diagonal().squaredNorm())) {
      stack.push_back({na.first, ib});
      stack.push_back({na.first + 1, ib});
    } else {
      stack.push_back({ia, nb.first});
      stack.push_back({ia, nb.first + 1});
    }
  }
  return false;
}

bool HoldsPartOf(const TriangleTree& outer, const TriangleTree& inner,
                 const Eigen::Affine3f& outer_from_inner) {
  return std::any_of(inner.part_points().begin(), inner.part_points().end(),
                     [&](const Vec3f& point) { return outer.Inside(outer_from_inner * point); });
}

}  // namespace

bool TrianglesCross(const std::array<Vec3f, 3>& s, const std::array<Vec3f, 3>& t,
                    float tolerance_m) {
  // Computes relative to one corner: the planes' offsets stay small and precise.
  const Vec3f origin = s[0];
  const std::array<Vec3f, 3> p = {Vec3f::Zero(), s[1] - origin, s[2] - origin};
  const std::array<Vec3f, 3> q = {t[0] - origin, t[1] - origin, t[2] - origin};
  const Vec3f np = (p[1] - p[0]).cross(p[2] - p[0]).stableNormalized();
  const Vec3f nq = (q[1] - q[0]).cross(q[2] - q[0]).stableNormalized();
  const float tolerance = std::max(tolerance_m, 1e-6f);
  std::array<float, 3> dq, dp;
  for (int i = 0; i < 3; ++i) dq[i] = np.dot(q[i]);
  const auto straddles = [&](const std::array<float, 3>& d) {
    return std::min({d[0], d[1], d[2]}) < -tolerance && std::max({d[0], d[1], d[2]}) > tolerance;
  };
  if (!straddles(dq)) return false;
  for (int i = 0; i < 3; ++i) dp[i] = nq.dot(p[i] - q[0]);
  if (!straddles(dp)) return false;
  const Vec3f line = np.cross(nq);
  const float length = line.norm();
  if (length < 1e-9f) return false;
  std::array<float, 3> ap, aq;
  for (int i = 0; i < 3; ++i) {
    ap[i] = line.dot(p[i]) / length;
    aq[i] = line.dot(q[i]) / length;
  }
  const Interval ip = LineInterval(ap, dp), iq = LineInterval(aq, dq);
  return std::min(ip.high, iq.high) - std::max(ip.low, iq.low) > tolerance;
}

Box3f TransformBox(const Eigen::Affine3f& world_from_object, const Box3f& box) {
  if (box.isEmpty()) return box;
  const Vec3f center = world_from_object * box.center();
  const Vec3f half = world_from_object.linear().cwiseAbs() * (0.5f * box.diagonal());
  return Box3f(Vec3f(center - half), Vec3f(center + half));
}

float PointTriangleDistance(const Vec3f& point, const std::array<Vec3f, 3>& triangle) {
  // Source: Ericson, "Real-Time Collision Detection", 5.1.5: the regions of Voronoi.
  const auto& [a, b, c] = triangle;
  const Vec3f ab = b - a, ac = c - a, ap = point - a;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  const Vec3f bp = point - b;
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (point - (a + ab * (d1 / (d1 - d3)))).norm();
  const Vec3f cp = point - c;
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (point - (a + ac * (d2 / (d2 - d6)))).norm();
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return (point - (b + (c - b) * w)).norm();
  }
  const float sum = va + vb + vc;
  return (point - (a + ab * (vb / sum) + ac * (vc / sum))).norm();
}

TriangleTree::TriangleTree(const Mesh& mesh) : positions_(mesh.positions) {
  triangles_.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) triangles_.push_back({t.a, t.b, t.c});
  if (std::any_of(mesh.slots.begin(), mesh.slots.end(),
                  [](const MaterialSlot& slot) { return slot.sheet; })) {
    sheet_.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
      sheet_.push_back(t.slot < mesh.slots.size() && mesh.slots[t.slot].sheet);
    }
  }
  bounds_ = mesh.Bounds();
  if (triangles_.empty()) return;
  FindParts();
  Build();
  positions_.push_back(Vec3f::Zero());
}

void TriangleTree::FindParts() {
  std::vector<uint32_t> root(positions_.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : triangles_) {
    for (int i = 1; i < 3; ++i) {
      const uint32_t p = find(t[0]), q = find(t[i]);
      if (p != q) root[std::max(p, q)] = std::min(p, q);
    }
  }
  std::vector<Vec3f> points;
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    if (root[v] == v) points.push_back(positions_[v]);
  }
  const size_t stride = (points.size() + kMaxPartPoints - 1) / kMaxPartPoints;
  for (size_t i = 0; i < points.size(); i += stride) part_points_.push_back(points[i]);
}

void TriangleTree::Build() {
  const size_t count = triangles_.size();
  std::vector<Box3f> boxes(count);
  std::vector<Vec3f> centers(count);
  for (size_t i = 0; i < count; ++i) {
    for (const uint32_t v : triangles_[i]) boxes[i].extend(positions_[v]);
    centers[i] = boxes[i].center();
  }
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);

  // Object median along the longest side of the centres' box: a balanced tree, quickly.
  nodes_.reserve(count);
  nodes_.push_back({});
  struct Task {
    uint32_t node, first, last;
  };
  std::vector<Task> tasks = {{0, 0, static_cast<uint32_t>(count)}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    Box3f box, center_box;
    for (uint32_t i = task.first; i < task.last; ++i) {
      box.extend(boxes[order_[i]]);
      center_box.extend(centers[order_[i]]);
    }
    Node& node = nodes_[task.node];
    node.box = box;
    if (task.last - task.first <= kLeafSize) {
      node.first = task.first;
      node.count = task.last - task.first;
      continue;
    }
    int axis = 0;
    center_box.diagonal().maxCoeff(&axis);
    const uint32_t middle = (task.first + task.last) / 2;
    std::nth_element(order_.begin() + task.first, order_.begin() + middle,
                     order_.begin() + task.last, [&](uint32_t p, uint32_t q) {
                       const float cp = centers[p][axis], cq = centers[q][axis];
                       return cp < cq || (cp == cq && p < q);
                     });
    const uint32_t left = static_cast<uint32_t>(nodes_.size());
    node.first = left;
    node.count = 0;
    nodes_.push_back({});
    nodes_.push_back({});
    tasks.push_back({left, task.first, middle});
    tasks.push_back({left + 1, middle, task.last});
  }
}

int TriangleTree::SignedCrossings(const Vec3f& origin, const Vec3f& direction) const {
  const Vec3f inverse = direction.cwiseInverse();
  int crossings = 0;
  std::vector<uint32_t> stack = {0};
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    if (!RayMeetsBox(node.box, origin, inverse)) continue;
    if (node.count == 0) {
      stack.push_back(node.first);
      stack.push_back(node.first + 1);
      continue;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      if (!sheet_.empty() && sheet_[order_[i]]) continue;
      const auto [a, b, c] = Corners(*this, order_[i]);
      const Vec3f ab = b - a, ac = c - a;
      const Vec3f p = direction.cross(ac);
      const float determinant = ab.dot(p);
      if (determinant == 0) continue;
      const Vec3f from = origin - a;
      const float u = from.dot(p) / determinant;
      const Vec3f q = from.cross(ab);
      const float v = direction.dot(q) / determinant;
      const float distance = ac.dot(q) / determinant;
      if (u < 0 || v < 0 || u + v > 1 || distance <= 0) continue;
      crossings += determinant > 0 ? -1 : 1;  // Positive: the ray goes in against the normal.
    }
  }
  return crossings;
}

bool TriangleTree::Inside(const Vec3f& point) const {
  if (triangles_.empty() || !bounds_.contains(point)) return false;
  int votes = 0;
  for (const Vec3f& probe : kProbes) votes += SignedCrossings(point, probe) > 0 ? 1 : 0;
  return votes >= 2;
}

bool Overlap(const TriangleTree& a, const Eigen::Affine3f& world_from_a, const TriangleTree& b,
             const Eigen::Affine3f& world_from_b, float tolerance_m) {
  if (a.nodes().empty() || b.nodes().empty()) return false;
  if (!TransformBox(world_from_a, a.bounds()).intersects(TransformBox(world_from_b, b.bounds()))) {
    return false;
  }
  const Eigen::Affine3f a_from_b = world_from_a.inverse() * world_from_b;
  const float scale_a = std::cbrt(std::abs(world_from_a.linear().determinant()));
  return SurfacesCross(a, b, a_from_b, tolerance_m / scale_a) || HoldsPartOf(a, b, a_from_b) ||
         HoldsPartOf(b, a, a_from_b.inverse());
}

}  // namespace parallax
