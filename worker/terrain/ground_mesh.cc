#include "worker/terrain/ground_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "worker/materials/kernel/noise.h"

namespace parallax {
namespace {

// Balancing and corners of neighbours make about this many triangles of a leaf.
constexpr float kTrianglesPerLeaf = 5.2f;
// The bed is visible, through water or in the troughs of waves, up to kShownBed_m from the shore;
// beyond, edges are kHidden times longer.
constexpr float kShownBed_m = 1.5f, kHidden = 12;
// Depth to which water reaches below the land beside it.
constexpr float kUnderLand_m = 9;
// Width of an edge of water's mesh below the eye, SeenWidth's.
constexpr float kSquareEdge_m = 0.03f;
// A square's diagonal over its side, and what lines that bend add.
constexpr float kSquareSpan = 2.4f;
constexpr float kFace_m = 2.5f;  // Faces look where the ground falls over this length.

// Angle between two headings, in [0, pi].
float Turn(float a, float b) {
  constexpr float kFull = 2 * std::numbers::pi_v<float>;
  const float turn = std::fabs(std::remainder(a - b, kFull));
  return turn;
}

// Ledges whose edge steps from one column of vertices to the next would look like combs, so the
// reach of neighbouring columns is smoothed kSmoothings times.
constexpr int kSmoothings = 3;

// Returns the mean reach of the ledges within `reach_m` of a height.
float MeanLedge(const MeshedSurface& surface, const Vec2f& p, float height_m, float reach_m) {
  constexpr int kHeights = 9;
  float sum = 0;
  for (int k = 0; k < kHeights; ++k) {
    const float away = (static_cast<float>(k) + 0.5f) / kHeights * 2 - 1;
    sum += surface.ledge(p, height_m + away * reach_m);
  }
  return sum / kHeights;
}

// Replaces each vertex's value by the mean of the corners of the triangles around it.
void Smooth(const std::vector<Triangle>& triangles, std::vector<Vec2f>& values) {
  std::vector<Vec2f> sums(values.size(), Vec2f::Zero());
  std::vector<float> counts(values.size());
  for (const Triangle& t : triangles) {
    const Vec2f sum = values[t.a] + values[t.b] + values[t.c];
    for (const uint32_t v : {t.a, t.b, t.c}) {
      sums[v] += sum;
      counts[v] += 3;
    }
  }
  for (size_t i = 0; i < values.size(); ++i) {
    if (counts[i] > 0) values[i] = sums[i] / counts[i];
  }
}

}  // namespace

MeshedSurface GroundOf(const Terrain& terrain) {
  MeshedSurface ground;
  ground.slot = "ground";
  ground.family = "soil";
  ground.height = [&](const Vec2f& p, float footprint_m) { return terrain.Height(p, footprint_m); };
  ground.slope = [&](const Vec2f& p, float footprint_m) { return terrain.Slope(p, footprint_m); };
  ground.steepness = [&](const Vec2f& p) { return terrain.Steepness(p); };
  if (terrain.has_ledges()) {
    ground.ledge = [&](const Vec2f& p, float height_m) { return terrain.Ledge(p, height_m); };
  }
  if (terrain.water() != nullptr) {
    ground.coarser = [&](const Vec2f& center, float half_m) {
      return terrain.water()->FromShore(center) < -kShownBed_m - kSquareSpan * half_m ? kHidden
                                                                                      : 1.0f;
    };
  }
  return ground;
}

MeshedSurface WaterOf(const Terrain& terrain) {
  const Water& water = *terrain.water();
  MeshedSurface surface;
  surface.slot = surface.family = "water";
  surface.footprint = [](float edge_m) { return SeenWidth(edge_m, kSquareEdge_m); };
  surface.height = [&](const Vec2f& p, float footprint_m) {
    return water.Level(p) + water.Waves(p, footprint_m);
  };
  surface.slope = [&](const Vec2f& p, float footprint_m) {
    const float half = std::max(0.25f * footprint_m, 0.01f);
    const Vec2f x(half, 0), y(0, half);
    const auto height = [&](const Vec2f& at) { return water.Waves(at, footprint_m); };
    return Vec2f(Vec2f(height(p + x) - height(p - x), height(p + y) - height(p - y)) / (2 * half));
  };
  surface.steepness = [](const Vec2f&) { return 0.0f; };
  surface.coarser = [&](const Vec2f& center, float half_m) {
    const float least_m = water.FromShore(center) - kSquareSpan * half_m;
    return least_m > kUnderLand_m ? std::numeric_limits<float>::infinity() : 1.0f;
  };
  return surface;
}

GroundMesh::GroundMesh(const Terrain& terrain, const GroundMeshOptions& options)
    : GroundMesh(GroundOf(terrain), options) {}

GroundMesh::GroundMesh(const MeshedSurface& surface, const GroundMeshOptions& options)
    : options_(options) {
  side_ = 2;
  unit_m_ = options.reach_m;
  while (unit_m_ > 0.5f * options.least_edge_m) {
    side_ *= 2;
    unit_m_ *= 0.5f;
  }
  Refine(surface);
  Balance();
  Triangulate(surface);
  if (surface.ledge) StandOut(surface);
}

Vec2f GroundMesh::PositionOf(int x, int y) const {
  return Vec2f(static_cast<float>(x - side_ / 2), static_cast<float>(y - side_ / 2)) * unit_m_;
}

float GroundMesh::PixelAt(const MeshedSurface& surface, const Square& square) const {
  const float half_m = 0.5f * static_cast<float>(square.side) * unit_m_;
  const Vec2f center = PositionOf(square.x + square.side / 2, square.y + square.side / 2);
  const float coarser = surface.coarser ? surface.coarser(center, half_m) : 1;
  float least_m = options_.reach_m;
  for (const ViewCone& view : options_.views) {
    const Vec2f away = center - view.apex;
    const float nearest_m = (away.cwiseAbs() - Vec2f::Constant(half_m)).cwiseMax(0.0f).norm();
    const float distance_m = std::hypot(nearest_m, view.eye_height_m);
    const float radius_m = half_m * std::numbers::sqrt2_v<float>;
    const float spread = away.norm() > radius_m ? std::asin(radius_m / away.norm()) : 4.0f;
    const bool seen =
        Turn(std::atan2(away.y(), away.x()), view.heading_rad) <= view.half_angle_rad + spread;
    least_m = std::min(least_m, distance_m / options_.focal_px * (seen ? 1 : options_.out_of_view));
  }
  // Steep ground turns its face to the walk and has edges; flat ground is seen at a glancing angle.
  const float steepness = surface.steepness(center);
  const float steep = noise::SmoothStep(0.2f, 0.9f, steepness);
  least_m *= coarser * noise::Lerp(1.3f, 0.55f, steep);
  // Faces are longer than they look from above.
  return surface.ledge ? least_m / std::hypot(1.0f, 0.7f * steepness) : least_m;
}

std::array<GroundMesh::Square, 4> GroundMesh::Split(const Square& square) {
  const auto first = static_cast<uint32_t>(nodes_.size());
  nodes_[square.node].first_child = first;
  nodes_.resize(nodes_.size() + 4);
  const int half = square.side / 2;
  std::array<Square, 4> children;
  for (uint32_t k = 0; k < 4; ++k) {
    children[k] = {first + k, square.x + (k % 2 ? half : 0), square.y + (k / 2 ? half : 0), half};
  }
  return children;
}

// Divides the square whose edge looks longest until the budget is spent or all are short enough.
void GroundMesh::Refine(const MeshedSurface& surface) {
  struct Candidate {
    float edge_px;
    Square square;
    bool operator<(const Candidate& other) const {
      return edge_px != other.edge_px ? edge_px < other.edge_px : square.node > other.square.node;
    }
  };
  const auto candidate = [&](const Square& square) {
    return Candidate{static_cast<float>(square.side) * unit_m_ / PixelAt(surface, square), square};
  };
  const auto most_leaves =
      static_cast<size_t>(static_cast<float>(options_.most_triangles) / kTrianglesPerLeaf);
  nodes_.assign(1, {});
  std::priority_queue<Candidate> queue;
  queue.push(candidate({0, 0, 0, side_}));
  for (size_t leaves = 1; leaves + 3 <= most_leaves && !queue.empty(); leaves += 3) {
    const Candidate longest = queue.top();
    if (longest.edge_px <= options_.edge_px) break;
    queue.pop();
    for (const Square& child : Split(longest.square)) {
      if (child.side > 2) queue.push(candidate(child));
    }
  }
  longest_edge_px_ = queue.empty() ? 0 : queue.top().edge_px;
}

GroundMesh::Square GroundMesh::LeafAt(int x, int y) const {
  Square square{0, 0, 0, side_};
  while (nodes_[square.node].first_child != 0) {
    square.side /= 2;
    const bool right = x >= square.x + square.side, upper = y >= square.y + square.side;
    square.node = nodes_[square.node].first_child + (right ? 1 : 0) + (upper ? 2 : 0);
    square.x += right ? square.side : 0;
    square.y += upper ? square.side : 0;
  }
  return square;
}

template <typename Visit>
void GroundMesh::ForEachLeaf(const Visit& visit) const {
  std::vector<Square> open = {{0, 0, 0, side_}};
  while (!open.empty()) {
    const Square square = open.back();
    open.pop_back();
    const uint32_t first = nodes_[square.node].first_child;
    if (first == 0) {
      visit(square);
      continue;
    }
    const int half = square.side / 2;
    for (uint32_t k = 4; k-- > 0;) {
      open.push_back(
          {first + k, square.x + (k % 2 ? half : 0), square.y + (k / 2 ? half : 0), half});
    }
  }
}

// Divides leaves until no one is more than twice as long as its neighbour.
void GroundMesh::Balance() {
  std::vector<Square> open;
  ForEachLeaf([&](const Square& leaf) { open.push_back(leaf); });
  while (!open.empty()) {
    const Square leaf = open.back();
    open.pop_back();
    if (nodes_[leaf.node].first_child != 0) continue;
    const std::array<std::array<int, 2>, 4> beside = {{{leaf.x - 1, leaf.y},
                                                       {leaf.x + leaf.side, leaf.y},
                                                       {leaf.x, leaf.y - 1},
                                                       {leaf.x, leaf.y + leaf.side}}};
    for (const auto& [x, y] : beside) {
      if (!Contains(x, y)) continue;
      for (Square other = LeafAt(x, y); other.side > 2 * leaf.side; other = LeafAt(x, y)) {
        for (const Square& child : Split(other)) open.push_back(child);
      }
    }
  }
}

uint32_t GroundMesh::VertexAt(int x, int y, float footprint_m) {
  const uint64_t key = static_cast<uint64_t>(x) << 32 | static_cast<uint32_t>(y);
  const auto [found, added] = numbers_.try_emplace(key, static_cast<uint32_t>(vertices_.size()));
  if (added) vertices_.push_back({x, y, footprint_m});
  return found->second;
}

// Heights and slopes are most of a mesh's cost.
void GroundMesh::MakeVertices(const MeshedSurface& surface) {
  const size_t count = vertices_.size();
  mesh_.positions.resize(count);
  mesh_.normals.resize(count);
  mesh_.uv.resize(count);
  tbb::parallel_for(size_t{0}, count, [&](size_t i) {
    const Vertex& vertex = vertices_[i];
    const Vec2f p = PositionOf(vertex.x, vertex.y);
    const Vec2f slope = surface.slope(p, vertex.footprint_m);
    mesh_.positions[i] = Vec3f(p.x(), p.y(), surface.height(p, vertex.footprint_m));
    mesh_.normals[i] = Vec3f(-slope.x(), -slope.y(), 1).normalized();
    mesh_.uv[i] = Vec2f(surface.footprint ? vertex.footprint_m : 0.0f, 0.0f);
  });
  mesh_.texture = mesh_.positions;
}

void GroundMesh::AddFan(const MeshedSurface& surface, const Square& leaf) {
  const float edge_m = static_cast<float>(leaf.side) * unit_m_;
  const float footprint_m = surface.footprint ? surface.footprint(edge_m) : edge_m;
  const int half = leaf.side / 2, end_x = leaf.x + leaf.side, end_y = leaf.y + leaf.side;
  // Corners counter-clockwise, each followed by the edge's middle where a finer neighbour has it.
  struct Corner {
    int x, y, beside_x, beside_y, middle_x, middle_y;
  };
  const std::array<Corner, 4> corners = {{
      {leaf.x, leaf.y, leaf.x, leaf.y - 1, leaf.x + half, leaf.y},
      {end_x, leaf.y, end_x, leaf.y, end_x, leaf.y + half},
      {end_x, end_y, leaf.x, end_y, leaf.x + half, end_y},
      {leaf.x, end_y, leaf.x - 1, leaf.y, leaf.x, leaf.y + half},
  }};
  std::array<uint32_t, 8> ring;
  size_t count = 0;
  for (const Corner& corner : corners) {
    ring[count++] = VertexAt(corner.x, corner.y, footprint_m);
    if (Contains(corner.beside_x, corner.beside_y) &&
        LeafAt(corner.beside_x, corner.beside_y).side < leaf.side) {
      ring[count++] = VertexAt(corner.middle_x, corner.middle_y, footprint_m);
    }
  }
  const uint32_t center = VertexAt(leaf.x + half, leaf.y + half, footprint_m);
  Node& node = nodes_[leaf.node];
  node.first_triangle = static_cast<uint32_t>(mesh_.triangles.size());
  node.triangles = static_cast<uint16_t>(count);
  for (size_t k = 0; k < count; ++k) {
    mesh_.triangles.push_back({center, ring[k], ring[(k + 1) % count], 0});
  }
}

void GroundMesh::Triangulate(const MeshedSurface& surface) {
  mesh_.slots = {{surface.slot, {surface.family}, false}};
  ForEachLeaf([&](const Square& leaf) {
    const float half_m = 0.5f * static_cast<float>(leaf.side) * unit_m_;
    const Vec2f center = PositionOf(leaf.x + leaf.side / 2, leaf.y + leaf.side / 2);
    if (surface.coarser && std::isinf(surface.coarser(center, half_m))) return;
    AddFan(surface, leaf);
  });
  MakeVertices(surface);
  numbers_ = {};
  vertices_ = {};
}

void GroundMesh::StandOut(const MeshedSurface& surface) {
  plan_.reserve(mesh_.positions.size());
  for (const Vec3f& at : mesh_.positions) plan_.push_back(at.head<2>());
  // The largest difference in height between each vertex and its neighbours.
  std::vector<float> rise_m(mesh_.positions.size());
  for (const Triangle& t : mesh_.triangles) {
    for (const auto& [v, w] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
      const float rise = std::fabs(mesh_.positions[v].z() - mesh_.positions[w].z());
      rise_m[v] = std::max(rise_m[v], rise);
      rise_m[w] = std::max(rise_m[w], rise);
    }
  }
  std::vector<Vec2f> out_m(plan_.size(), Vec2f::Zero());
  tbb::parallel_for(size_t{0}, plan_.size(), [&](size_t i) {
    const float out = MeanLedge(surface, plan_[i], mesh_.positions[i].z(), rise_m[i]);
    if (out <= 0) return;
    const Vec2f downhill = -surface.slope(plan_[i], kFace_m);
    if (downhill.squaredNorm() >= 1e-4f) out_m[i] = out * downhill.normalized();
  });
  for (int pass = 0; pass < kSmoothings; ++pass) Smooth(mesh_.triangles, out_m);
  std::vector<bool> moved(mesh_.positions.size());
  for (size_t i = 0; i < plan_.size(); ++i) {
    if (out_m[i].squaredNorm() < 1e-8f) continue;
    mesh_.positions[i].head<2>() += out_m[i];
    mesh_.texture[i] = mesh_.positions[i];
    moved[i] = true;
  }
  // The terrain does not know these normals.
  std::vector<Vec3f> sums(mesh_.positions.size(), Vec3f::Zero());
  for (const Triangle& t : mesh_.triangles) {
    const Vec3f normal = (mesh_.positions[t.b] - mesh_.positions[t.a])
                             .cross(mesh_.positions[t.c] - mesh_.positions[t.a]);
    for (const uint32_t v : {t.a, t.b, t.c}) sums[v] += normal;
  }
  for (size_t i = 0; i < sums.size(); ++i) {
    if (moved[i] && sums[i].squaredNorm() > 1e-20f) mesh_.normals[i] = sums[i].stableNormalized();
  }
}

float GroundMesh::HeightAt(const Vec2f& p) const {
  const float half_m = 0.5f * static_cast<float>(side_) * unit_m_;
  const Vec2f inside = p.cwiseMax(-half_m).cwiseMin(half_m);
  const Vec2f units = (inside + Vec2f::Constant(half_m)) / unit_m_;
  const Node& leaf = nodes_[LeafAt(std::min(static_cast<int>(units.x()), side_ - 1),
                                   std::min(static_cast<int>(units.y()), side_ - 1))
                                .node];
  // The triangle that holds the point, or is nearest to holding it when rounding says none does.
  float best = -1e30f, height = 0;
  for (uint32_t k = 0; k < leaf.triangles; ++k) {
    const Triangle& triangle = mesh_.triangles[leaf.first_triangle + k];
    const Vec3f &a = mesh_.positions[triangle.a], &b = mesh_.positions[triangle.b],
                &c = mesh_.positions[triangle.c];
    const auto plan = [&](uint32_t v, const Vec3f& at) -> Vec2f {
      return plan_.empty() ? Vec2f(at.head<2>()) : plan_[v];
    };
    const Vec2f pa = plan(triangle.a, a);
    const Vec2f ab = plan(triangle.b, b) - pa, ac = plan(triangle.c, c) - pa, ap = inside - pa;
    const float area = ab.x() * ac.y() - ab.y() * ac.x();
    const float v = (ap.x() * ac.y() - ap.y() * ac.x()) / area;
    const float w = (ab.x() * ap.y() - ab.y() * ap.x()) / area;
    const float inside_by = std::min({1 - v - w, v, w});
    if (inside_by <= best) continue;
    best = inside_by;
    height = a.z() + v * (b.z() - a.z()) + w * (c.z() - a.z());
  }
  return height;
}

}  // namespace parallax
