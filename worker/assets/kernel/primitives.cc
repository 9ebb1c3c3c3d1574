#include "worker/assets/kernel/primitives.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax::kernel {
namespace {

// Grid stations along one axis of a rounded box: bevel, flat, bevel.
std::vector<float> Stations(float half, float radius, int bevel_steps, int pieces) {
  std::vector<float> out;
  const float flat = half - radius;
  if (radius > 0) {
    for (int i = 0; i < bevel_steps; ++i) {
      // Equal angles from 45 to 0 degrees.
      const float angle =
          0.25f * kPi * (1.0f - static_cast<float>(i) / static_cast<float>(bevel_steps));
      out.push_back(-flat - radius * std::tan(angle));
    }
  }
  for (int i = 0; i <= pieces; ++i) {
    out.push_back(Lerp(-flat, flat, static_cast<float>(i) / static_cast<float>(pieces)));
  }
  if (radius > 0) {
    for (int i = 1; i <= bevel_steps; ++i) {
      const float angle = 0.25f * kPi * static_cast<float>(i) / static_cast<float>(bevel_steps);
      out.push_back(flat + radius * std::tan(angle));
    }
  }
  return out;
}

}  // namespace

Shape RoundedBox(const Vec3f& size, const BoxOptions& options) {
  const Vec3f half = 0.5f * size;
  const float radius = std::min(options.bevel_m, 0.499f * size.minCoeff());
  const int steps = radius > 0 ? std::max(1, options.bevel_steps) : 0;
  std::array<std::vector<float>, 3> at;
  for (int axis = 0; axis < 3; ++axis) {
    const int pieces = DetailedPieces(options.pieces[axis], size[axis]);
    at[axis] = Stations(half[axis], std::max(radius, 0.0f), steps, pieces);
  }
  Shape shape;
  std::map<std::array<int, 3>, uint32_t> index;
  const auto point = [&](const std::array<int, 3>& key) {
    const auto [it, fresh] = index.try_emplace(key, 0u);
    if (fresh) {
      const Vec3f cube(at[0][key[0]], at[1][key[1]], at[2][key[2]]);
      const Vec3f core =
          cube.cwiseMax(-half + Vec3f::Constant(radius)).cwiseMin(half - Vec3f::Constant(radius));
      const Vec3f out = cube - core;
      it->second = shape.AddPoint(radius > 0 ? Vec3f(core + radius * out.normalized()) : cube);
    }
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int last = static_cast<int>(at[axis].size()) - 1;
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i + 1 < static_cast<int>(at[u].size()); ++i) {
        for (int j = 0; j + 1 < static_cast<int>(at[v].size()); ++j) {
          const auto key = [&](int du, int dv) {
            std::array<int, 3> k{};
            k[axis] = side ? last : 0;
            k[u] = i + du;
            k[v] = j + dv;
            return point(k);
          };
          if (side) {
            shape.AddQuad(key(0, 0), key(1, 0), key(1, 1), key(0, 1));
          } else {
            shape.AddQuad(key(0, 0), key(0, 1), key(1, 1), key(1, 0));
          }
        }
      }
    }
  }
  TextureAlongLongest(shape);
  return shape;
}

Shape Board(const Vec3f& a, const Vec3f& b, float bevel_m) {
  const Vec3f lo = a.cwiseMin(b), hi = a.cwiseMax(b);
  return RoundedBox(hi - lo, {.bevel_m = std::min(bevel_m, 0.3f * (hi - lo).minCoeff())})
      .Moved(0.5f * (lo + hi));
}

Shape Lathe(const Path2& given, const LatheOptions& options) {
  Path2 profile;
  for (const Vec2f& p : given) {
    if (profile.empty() || (p - profile.back()).norm() > 1e-6f) profile.push_back(p);
  }
  if (profile.front().x() > 1e-6f) profile.insert(profile.begin(), Vec2f(0, profile.front().y()));
  if (profile.back().x() > 1e-6f) profile.push_back(Vec2f(0, profile.back().y()));
  float largest = 0;
  for (const Vec2f& p : profile) largest = std::max(largest, p.x());
  // Flutes and corners need the segments that they were made for.
  const int n = options.segments <= 0 ? CircleSegments(largest)
                : options.modulate    ? options.segments
                                      : DetailedSegments(options.segments, largest);

  Shape shape;
  std::vector<std::vector<uint32_t>> rings;
  for (size_t i = 0; i < profile.size(); ++i) {
    const Vec2f& p = profile[i];
    std::vector<uint32_t> ring;
    if (p.x() <= 1e-6f) {
      ring.assign(static_cast<size_t>(n), shape.AddPoint({0, 0, p.y()}));
    } else {
      for (int s = 0; s < n; ++s) {
        const float theta = kTau * static_cast<float>(s) / static_cast<float>(n);
        const float r = p.x() * (options.modulate ? options.modulate(theta, p.y()) : 1.0f);
        ring.push_back(shape.AddPoint({r * std::cos(theta), r * std::sin(theta), p.y()}));
      }
    }
    rings.push_back(std::move(ring));
  }
  const bool prints = options.print_to_z > options.print_from_z;
  const float eps = 1e-5f;
  for (size_t i = 0; i + 1 < rings.size(); ++i) {
    const float z0 = profile[i].y(), z1 = profile[i + 1].y();
    const bool printed = prints && z1 > z0 + eps && z0 >= options.print_from_z - eps &&
                         z1 <= options.print_to_z + eps;
    for (int s = 0; s < n; ++s) {
      const int t = (s + 1) % n;
      const size_t before = shape.faces.size();
      shape.AddQuad(rings[i][s], rings[i][t], rings[i + 1][t], rings[i + 1][s],
                    printed ? options.print_group : options.group);
      if (printed && shape.faces.size() > before && shape.faces.back().corners == 4) {
        const float span = options.print_to_z - options.print_from_z;
        const int once = (n + options.print_repeats - 1) / options.print_repeats;
        const float u0 = static_cast<float>(s % once) / static_cast<float>(once);
        const float u1 = static_cast<float>(s % once + 1) / static_cast<float>(once);
        const float v0 = (z0 - options.print_from_z) / span,
                    v1 = (z1 - options.print_from_z) / span;
        shape.faces.back().uv = {Vec2f(u0, v0), Vec2f(u1, v0), Vec2f(u1, v1), Vec2f(u0, v1)};
      }
    }
  }
  TextureAlongLongest(shape);
  return shape;
}

Shape LatheRing(const Path2& section, int segments) {
  float largest = 0;
  for (const Vec2f& p : section) largest = std::max(largest, p.x());
  const int n = segments > 0 ? DetailedSegments(segments, largest) : CircleSegments(largest);
  const size_t m = section.size();
  Shape shape;
  for (const Vec2f& p : section) {
    for (int s = 0; s < n; ++s) {
      const float theta = kTau * static_cast<float>(s) / static_cast<float>(n);
      shape.AddPoint({p.x() * std::cos(theta), p.x() * std::sin(theta), p.y()});
    }
  }
  for (size_t i = 0; i < m; ++i) {
    const uint32_t a = static_cast<uint32_t>(i) * n, b = static_cast<uint32_t>((i + 1) % m) * n;
    for (uint32_t s = 0; s < static_cast<uint32_t>(n); ++s) {
      const uint32_t t = (s + 1) % static_cast<uint32_t>(n);
      shape.AddQuad(a + s, a + t, b + t, b + s);
    }
  }
  TextureAlongLongest(shape);
  return shape;
}

Path2 VesselProfile(const Path2& outer, float thickness, float floor_m) {
  // The inside wall: points moved along the left-hand normal of the way up.
  Path2 inner;
  const float floor_z = outer.front().y() + floor_m;
  for (size_t i = 0; i < outer.size(); ++i) {
    const Vec2f before = outer[i > 0 ? i - 1 : 0], after = outer[std::min(i + 1, outer.size() - 1)];
    const Vec2f along = (after - before).normalized();
    Vec2f p = outer[i] + thickness * Vec2f(-along.y(), along.x());
    if (p.x() < 0.15f * thickness || p.y() < floor_z) continue;
    if (!inner.empty() && p.y() < inner.back().y() && p.x() > inner.back().x()) continue;
    inner.push_back(p);
  }
  Path2 out = outer;
  const Vec2f rim = outer.back();
  const Vec2f inside = inner.empty() ? Vec2f(rim.x() - thickness, rim.y()) : inner.back();
  const Vec2f up(0, 1);
  const Vec2f middle = 0.5f * (rim + inside);
  const float r = 0.5f * (rim - inside).norm();
  for (int k = 1; k < 6; ++k) {
    const float a = kPi * static_cast<float>(k) / 6.0f;
    out.push_back(middle + std::cos(a) * (rim - middle) + std::sin(a) * r * up);
  }
  for (size_t i = inner.size(); i-- > 0;) out.push_back(inner[i]);
  const float end_z =
      inner.empty() ? floor_z : std::min(inner.front().y(), std::max(floor_z, inner.front().y()));
  out.push_back({0, end_z});
  return out;
}

Shape Cylinder(float radius, float height, float bevel_m, int segments) {
  return Cone(radius, radius, height, bevel_m, segments);
}

Shape Cone(float bottom_radius, float top_radius, float height, float bevel_m, int segments) {
  const float b = std::min({bevel_m, 0.45f * height, 0.9f * std::max(bottom_radius, top_radius)});
  Path2 outline{{0, 0}, {bottom_radius, 0}, {top_radius, height}, {0, height}};
  return Lathe(b > 0 ? Filleted(outline, b, 3) : outline, {.segments = segments});
}

Shape Ball(float radius, int segments) { return Ellipsoid(Vec3f::Constant(radius), segments); }

Shape Ellipsoid(const Vec3f& radii, int segments) {
  LatheOptions options{.segments = segments > 0 ? segments : CircleSegments(radii.maxCoeff())};
  const float radius = radii.maxCoeff();
  options.segments = DetailedSegments(options.segments, radius);
  Path2 outline = Arc(Vec2f::Zero(), 1, 1, -0.5f * kPi, 0.5f * kPi, options.segments / 2);
  outline.front().x() = outline.back().x() = 0;
  options.modulate = [](float, float) { return 1.0f; };  // The segments are chosen.
  Shape shape =
      Lathe(outline, options).Bent([&](const Vec3f& p) { return p.cwiseProduct(radii).eval(); });
  TextureAlongLongest(shape);
  return shape;
}

namespace {

// Makes a sheet with thickness from a surface over (u, v) in [0, 1]^2.
class SheetMaker {
 public:
  SheetMaker(const std::function<Vec3f(float u, float v)>& surface, const SheetOptions& options)
      : options_(options),
        nu_(DetailedPieces(options.pieces_u, options.size_m.x(), 6)),
        nv_(DetailedPieces(options.pieces_v, options.size_m.y(), 6)) {
    for (int j = 0; j <= nv_; ++j) {
      for (int i = 0; i <= nu_; ++i) top_.push_back(surface(U(i), V(j)));
    }
  }

  Shape Make() {
    AddTop();
    AddUnderside();
    for (int j = 0; j < nv_; ++j) {
      for (int i = 0; i < nu_; ++i) AddFaces(i, j);
    }
    AddRim();
    return std::move(shape_);
  }

 private:
  float U(int i) const { return static_cast<float>(i) / static_cast<float>(nu_); }
  float V(int j) const { return static_cast<float>(j) / static_cast<float>(nv_); }
  uint32_t Id(int i, int j) const { return static_cast<uint32_t>(j * (nu_ + 1) + i); }
  // Index of the point below a point of the top.
  uint32_t Below(uint32_t id) const { return static_cast<uint32_t>(top_.size()) + id; }

  void AddTop() {
    normal_.resize(top_.size());
    for (int j = 0; j <= nv_; ++j) {
      for (int i = 0; i <= nu_; ++i) {
        const Vec3f du = top_[Id(std::min(i + 1, nu_), j)] - top_[Id(std::max(i - 1, 0), j)];
        const Vec3f dv = top_[Id(i, std::min(j + 1, nv_))] - top_[Id(i, std::max(j - 1, 0))];
        const Vec3f n = du.cross(dv);
        normal_[Id(i, j)] = n.norm() > 1e-12f ? Vec3f(n.normalized()) : Vec3f(Vec3f::UnitZ());
        shape_.AddPoint(top_[Id(i, j)],
                        {U(i) * options_.size_m.x(), V(j) * options_.size_m.y(), 0});
      }
    }
  }

  void AddUnderside() {
    for (size_t i = 0; i < top_.size(); ++i) {
      const Vec3f t = shape_.texture[i] - Vec3f(0, 0, options_.thickness_m);
      shape_.AddPoint(top_[i] - options_.thickness_m * normal_[i], t);
    }
  }

  void AddFaces(int i, int j) {
    const uint32_t a = Id(i, j), b = Id(i + 1, j), c = Id(i + 1, j + 1), d = Id(i, j + 1);
    shape_.AddQuad(a, b, c, d, options_.top_group);
    if (options_.print_uv) {
      const float u0 = U(i), u1 = U(i + 1), v0 = V(j), v1 = V(j + 1);
      shape_.faces.back().uv = {Vec2f(u0, v0), Vec2f(u1, v0), Vec2f(u1, v1), Vec2f(u0, v1)};
    }
    shape_.AddQuad(Below(a), Below(d), Below(c), Below(b), options_.bottom_group);
  }

  // Points of the rim, counter-clockwise seen from above.
  std::vector<uint32_t> Rim() const {
    std::vector<uint32_t> rim;
    for (int i = 0; i < nu_; ++i) rim.push_back(Id(i, 0));
    for (int j = 0; j < nv_; ++j) rim.push_back(Id(nu_, j));
    for (int i = nu_; i > 0; --i) rim.push_back(Id(i, nv_));
    for (int j = nv_; j > 0; --j) rim.push_back(Id(0, j));
    return rim;
  }

  // The point outside of `at`, half-way down, that rounds the rim between its neighbours.
  uint32_t AddEdgePoint(uint32_t before, uint32_t at, uint32_t after) {
    const Vec3f along = top_[after] - top_[before];
    const Vec3f n = normal_[at];
    Vec3f out = along.cross(n);
    out = out.norm() > 1e-12f ? Vec3f(out.normalized()) : Vec3f(Vec3f::Zero());
    return shape_.AddPoint(
        top_[at] - 0.5f * options_.thickness_m * n + 0.5f * options_.thickness_m * out,
        shape_.texture[at] - Vec3f(0, 0, 0.5f * options_.thickness_m));
  }

  void AddRim() {
    const std::vector<uint32_t> rim = Rim();
    const size_t n = rim.size();
    std::vector<uint32_t> edge;
    for (size_t k = 0; k < n && options_.round_rim; ++k) {
      edge.push_back(AddEdgePoint(rim[(k + n - 1) % n], rim[k], rim[(k + 1) % n]));
    }
    for (size_t k = 0; k < n; ++k) {
      const size_t l = (k + 1) % n;
      const uint32_t a = rim[k], b = rim[l];
      if (options_.round_rim) {
        shape_.AddQuad(a, edge[k], edge[l], b, options_.bottom_group);
        shape_.AddQuad(edge[k], Below(a), Below(b), edge[l], options_.bottom_group);
      } else {
        shape_.AddQuad(a, Below(a), Below(b), b, options_.bottom_group);
      }
    }
  }

  const SheetOptions& options_;
  const int nu_, nv_;
  std::vector<Vec3f> top_, normal_;
  Shape shape_;
};

}  // namespace

Shape Sheet(const std::function<Vec3f(float u, float v)>& surface, const SheetOptions& options) {
  return SheetMaker(surface, options).Make();
}

}  // namespace parallax::kernel
