#include "worker/assets/kernel/primitives.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "worker/assets/kernel/detail.h"

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
  BoxOptions options;
  options.bevel_m = std::min(bevel_m, 0.3f * (hi - lo).minCoeff());
  return RoundedBox(hi - lo, options).Moved(0.5f * (lo + hi));
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
  LatheOptions options;
  options.segments = segments;
  return Lathe(b > 0 ? Filleted(outline, b, 3) : outline, options);
}

Shape Ball(float radius, int segments) { return Ellipsoid(Vec3f::Constant(radius), segments); }

Shape Ellipsoid(const Vec3f& radii, int segments) {
  LatheOptions options;
  options.segments = segments > 0 ? segments : CircleSegments(radii.maxCoeff());
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

Shape Sheet(const std::function<Vec3f(float u, float v)>& surface, const SheetOptions& options) {
  const int nu = DetailedPieces(options.pieces_u, options.size_m.x(), 6),
            nv = DetailedPieces(options.pieces_v, options.size_m.y(), 6);
  const auto station = [](int i, int n) { return static_cast<float>(i) / static_cast<float>(n); };
  std::vector<Vec3f> top;
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) top.push_back(surface(station(i, nu), station(j, nv)));
  }
  const auto id = [&](int i, int j) { return static_cast<uint32_t>(j * (nu + 1) + i); };
  Shape shape;
  std::vector<Vec3f> normal(top.size());
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const Vec3f du = top[id(std::min(i + 1, nu), j)] - top[id(std::max(i - 1, 0), j)];
      const Vec3f dv = top[id(i, std::min(j + 1, nv))] - top[id(i, std::max(j - 1, 0))];
      const Vec3f n = du.cross(dv);
      normal[id(i, j)] = n.norm() > 1e-12f ? Vec3f(n.normalized()) : Vec3f(Vec3f::UnitZ());
      shape.AddPoint(top[id(i, j)],
                     {station(i, nu) * options.size_m.x(), station(j, nv) * options.size_m.y(), 0});
    }
  }
  const uint32_t below = static_cast<uint32_t>(top.size());
  for (size_t i = 0; i < top.size(); ++i) {
    const Vec3f t = shape.texture[i] - Vec3f(0, 0, options.thickness_m);
    shape.AddPoint(top[i] - options.thickness_m * normal[i], t);
  }
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      shape.AddQuad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1), options.top_group);
      if (options.print_uv) {
        const float u0 = station(i, nu), u1 = station(i + 1, nu), v0 = station(j, nv),
                    v1 = station(j + 1, nv);
        shape.faces.back().uv = {Vec2f(u0, v0), Vec2f(u1, v0), Vec2f(u1, v1), Vec2f(u0, v1)};
      }
      shape.AddQuad(below + id(i, j), below + id(i, j + 1), below + id(i + 1, j + 1),
                    below + id(i + 1, j), options.bottom_group);
    }
  }
  // The rim, counter-clockwise seen from above.
  std::vector<std::pair<int, int>> rim;
  for (int i = 0; i < nu; ++i) rim.emplace_back(i, 0);
  for (int j = 0; j < nv; ++j) rim.emplace_back(nu, j);
  for (int i = nu; i > 0; --i) rim.emplace_back(i, nv);
  for (int j = nv; j > 0; --j) rim.emplace_back(0, j);
  std::vector<uint32_t> edge;
  if (options.round_rim) {
    for (size_t k = 0; k < rim.size(); ++k) {
      const auto [i, j] = rim[k];
      const auto [a, b] = rim[(k + rim.size() - 1) % rim.size()];
      const auto [c, d] = rim[(k + 1) % rim.size()];
      const Vec3f along = top[id(c, d)] - top[id(a, b)];
      const Vec3f n = normal[id(i, j)];
      Vec3f out = along.cross(n);
      out = out.norm() > 1e-12f ? Vec3f(out.normalized()) : Vec3f(Vec3f::Zero());
      edge.push_back(shape.AddPoint(
          top[id(i, j)] - 0.5f * options.thickness_m * n + 0.5f * options.thickness_m * out,
          shape.texture[id(i, j)] - Vec3f(0, 0, 0.5f * options.thickness_m)));
    }
  }
  for (size_t k = 0; k < rim.size(); ++k) {
    const size_t l = (k + 1) % rim.size();
    const uint32_t a = id(rim[k].first, rim[k].second), b = id(rim[l].first, rim[l].second);
    if (options.round_rim) {
      shape.AddQuad(a, edge[k], edge[l], b, options.bottom_group);
      shape.AddQuad(edge[k], below + a, below + b, edge[l], options.bottom_group);
    } else {
      shape.AddQuad(a, below + a, below + b, b, options.bottom_group);
    }
  }
  return shape;
}

}  // namespace parallax::kernel
