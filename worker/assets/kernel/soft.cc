#include "worker/assets/kernel/soft.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/kernel/sweep.h"

namespace parallax::kernel {
namespace {

float Bulge(float x) {
  return 1 - x * x * (0.4f + 0.6f * x * x);
}  // 1 in the middle, 0 at the seam.

// Moves the points of a block to where those of a soft cushion are.
struct Softness {
  const Vec3f& size;
  const CushionOptions& o;
  const Noise& noise;

  Vec3f operator()(const Vec3f& p) const {
    const Vec3f half = 0.5f * size;
    const Vec3f q = p.cwiseQuotient(half).cwiseMax(-1.0f).cwiseMin(1.0f);
    const float ax = std::abs(q.x()), ay = std::abs(q.y()), az = std::abs(q.z());
    const float dome = Bulge(ax) * Bulge(ay);
    Vec3f out = p;
    const float lift = q.z() > 0 ? o.bulge_top_m : o.bulge_bottom_m;
    out.z() += q.z() * lift * dome;
    out.x() += q.x() * o.bulge_side_m * Bulge(ay) * Bulge(az);
    out.y() += q.y() * o.bulge_side_m * Bulge(ax) * Bulge(az);
    // Corners are pulled in by their seams, which also slacken the cloth beside them.
    const float corner = std::pow(ax * ay, 6.0f);
    out.z() -= q.z() * 0.25f * o.bulge_top_m * corner;
    const float seam = std::max(std::pow(ax, 4.0f), std::pow(ay, 4.0f));
    const Vec3f at = p / o.wrinkle_size_m;
    const float fine = noise.At(Vec3f(at.x() * 1.9f, at.y() * 1.9f, at.z()));
    const float slack = noise.Ridges(Vec3f(at.x(), at.y(), 0.4f * at.z())) - 0.3f;
    const float depth = o.wrinkle_m * (0.35f + 0.65f * seam);
    out.z() += (q.z() > 0 ? 1.0f : -0.2f) * az * depth * (0.7f * slack + 0.5f * fine);
    out.y() += q.y() * ay * ay * depth * 0.8f * noise.At(at * 1.3f + Vec3f(5, 0, 0));
    out.x() += q.x() * ax * ax * depth * 0.8f * noise.At(at * 1.3f + Vec3f(0, 5, 0));
    if (o.tufts_x > 0 && q.z() > 0) out.z() -= q.z() * o.tuft_depth_m * TuftDip(q);
    return out;
  }

  // How deep the nearest tuft pulls at q in [-1, 1]^2: 1 at its button.
  float TuftDip(const Vec3f& q) const {
    const Vec2f half = 0.5f * size.head<2>();
    float dip = 0;
    for (int i = 0; i < o.tufts_x; ++i) {
      for (int j = 0; j < o.tufts_y; ++j) {
        const Vec2f at_tuft((2.0f * static_cast<float>(i) + 1) / static_cast<float>(o.tufts_x) - 1,
                            (2.0f * static_cast<float>(j) + 1) / static_cast<float>(o.tufts_y) - 1);
        const Vec2f d = (Vec2f(q.x(), q.y()) - at_tuft).cwiseProduct(half);
        const float span = 0.8f * std::min(size.x() / static_cast<float>(o.tufts_x),
                                           size.y() / static_cast<float>(o.tufts_y));
        dip = std::max(dip, std::exp(-9.0f * d.norm() / span));
      }
    }
    return dip;
  }
};

// A cord round the upper (`side` = 1) or lower edge, whose radius is `r`.
Shape Piping(const Softness& soften, float r, float side) {
  const Vec3f& size = soften.size;
  const CushionOptions& o = soften.o;
  const float drop = r * (1 - std::sqrt(0.5f));
  Path3 path;
  for (const Vec2f& p : RectSection(size.x() - 2 * drop, size.y() - 2 * drop, r, 4))
    path.emplace_back(p.x(), p.y(), side * (0.5f * size.z() - drop));
  path.push_back(path.front());
  path = Resampled(path, DetailedEdge(o.target_edge_m));
  path.pop_back();
  for (Vec3f& p : path) p = soften(p);
  return Ring(path, o.piping_m, 8).Grouped(o.piping_group);
}

}  // namespace

Shape Cushion(const Vec3f& size, const CushionOptions& o, const Noise& noise) {
  BoxOptions box{.bevel_m = std::min(o.edge_radius_m, 0.48f * size.minCoeff()), .bevel_steps = 2};
  for (int axis = 0; axis < 3; ++axis) {
    const float flat = size[axis] - 2 * box.bevel_m;
    box.pieces[axis] = std::clamp(static_cast<int>(std::ceil(flat / o.target_edge_m)), 2, 64);
  }
  const Softness soften{size, o, noise};
  Shape shape = RoundedBox(size, box).Bent(soften);
  // Cloth runs across the width whatever the cushion's shape.
  for (size_t i = 0; i < shape.points.size(); ++i) shape.texture[i] = shape.points[i];
  if (o.piping_m > 0) {
    for (const float side : {-1.0f, 1.0f}) shape.Add(Piping(soften, box.bevel_m, side));
  }
  return shape;
}

Shape Pillow(float width, float depth, float thickness, const PillowOptions& o,
             const Noise& noise) {
  const int n = DetailedPieces(o.pieces, std::max(width, depth), 6);
  const auto station = [&](int i) {
    return std::sin(0.5f * kPi * (2.0f * static_cast<float>(i) / static_cast<float>(n) - 1.0f));
  };
  const float hx = 0.5f * width, hy = 0.5f * depth;
  Shape shape;
  std::vector<uint32_t> top, bottom;
  for (int side = 0; side < 2; ++side) {
    std::vector<uint32_t>& ids = side ? bottom : top;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const bool rim = i == 0 || j == 0 || i == n || j == n;
        if (side && rim) {
          ids.push_back(top[static_cast<size_t>(j * (n + 1) + i)]);
          continue;
        }
        const float u = station(i), v = station(j);
        const float x = hx * u * (1 - o.corner_pull * (1 - v * v) * u * u);
        const float y = hy * v * (1 - o.corner_pull * (1 - u * u) * v * v);
        const float inside = std::max(0.0f, (1 - u * u) * (1 - v * v));
        float z = 0.5f * thickness * std::pow(inside, o.sharpness);
        const Vec3f at(x, y, side ? 3.0f : 0.0f);
        // Wrinkles run from the seams inwards: short along the seam, long across it.
        const float seam_x = std::pow(std::abs(u), 3.0f), seam_y = std::pow(std::abs(v), 3.0f);
        const float radial = noise.At({x / 0.2f, y / 0.045f, at.z()}) * seam_x +
                             noise.At({x / 0.045f, y / 0.2f, at.z() + 7}) * seam_y;
        const float broad = noise.At({x / 0.17f, y / 0.17f, at.z() + 3});
        z += o.wrinkle_m * std::sqrt(inside) * (1.1f * radial + 1.2f * broad);
        if (!rim) z = std::max(z, 0.02f * thickness);
        const float wave = 0.15f * thickness * noise.At({x / 0.25f, y / 0.25f, 11});
        ids.push_back(
            shape.AddPoint({x, y, (side ? -z : z) + wave}, {hx * u, hy * v, side ? -0.05f : 0.0f}));
      }
    }
  }
  const auto id = [&](int i, int j) { return static_cast<size_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      shape.AddQuad(top[id(i, j)], top[id(i + 1, j)], top[id(i + 1, j + 1)], top[id(i, j + 1)]);
      shape.AddQuad(bottom[id(i, j)], bottom[id(i, j + 1)], bottom[id(i + 1, j + 1)],
                    bottom[id(i + 1, j)]);
    }
  }
  // The seam is a crease; the rest is smooth.
  shape.crease_rad = 1.6f;
  return shape;
}

Shape Drape(const DrapeOptions& o, const Noise& noise) {
  const float hx = 0.5f * o.table.x(), hy = 0.5f * o.table.y();
  const float s0 = -hx - o.hang[0], s1 = hx + o.hang[1], t0 = -hy - o.hang[2], t1 = hy + o.hang[3];
  const float r = o.edge_radius_m;
  // Cloth coordinate along one axis -> (outwards, down).
  const auto bend = [&](float s, float half) {
    const float beyond = std::abs(s) - (half - r);
    if (beyond <= 0) return Vec2f(s, 0);
    const float arc = 0.5f * kPi * r;
    float out, down;
    if (beyond < arc) {
      const float a = beyond / r;
      out = half - r + r * std::sin(a);
      down = r * (1 - std::cos(a));
    } else {
      down = r + (beyond - arc);
      out = half + o.flare * (beyond - arc);
    }
    return Vec2f(std::copysign(out, s), down);
  };
  const auto surface = [&](float u, float v) -> Vec3f {
    const float s = Lerp(s0, s1, u), t = Lerp(t0, t1, v);
    const Vec2f x = bend(s, hx), y = bend(t, hy);
    Vec3f p(x.x(), y.x(), o.thickness_m - std::max(x.y(), y.y()));
    // At a corner the cloth hangs in one deep fold: both overhangs pull it down and in.
    const float both = std::min(x.y(), y.y());
    if (both > 0) {
      p.x() -= std::copysign(0.35f * both, p.x());
      p.y() -= std::copysign(0.35f * both, p.y());
      p.z() -= 0.25f * both;
    }
    const float fall_x = Smooth01(x.y() / 0.2f), fall_y = Smooth01(y.y() / 0.2f);
    const float fold_x = noise.At({p.y() / o.fold_size_m, 0.3f * p.z() / o.fold_size_m, 1.5f});
    const float fold_y = noise.At({p.x() / o.fold_size_m, 0.3f * p.z() / o.fold_size_m, 8.5f});
    p.x() += std::copysign(o.fold_m * fall_x * (fold_x + 0.3f), p.x());
    p.y() += std::copysign(o.fold_m * fall_y * (fold_y + 0.3f), p.y());
    const float flat = (1 - Smooth01(x.y() / 0.05f)) * (1 - Smooth01(y.y() / 0.05f));
    const Vec3f at(s / o.wrinkle_size_m, t / o.wrinkle_size_m, 0.7f);
    p.z() += flat * o.wrinkle_m *
             (0.8f * noise.Ridges(at) + 0.8f * noise.Ridges(0.6f * at + Vec3f(0, 0, 4)) + 0.3f +
              0.3f * noise.At(2.7f * at));
    return p;
  };
  SheetOptions sheet;
  sheet.size_m = {s1 - s0, t1 - t0};
  sheet.pieces_u = std::clamp(static_cast<int>((s1 - s0) / o.target_edge_m), 8, 110);
  sheet.pieces_v = std::clamp(static_cast<int>((t1 - t0) / o.target_edge_m), 8, 110);
  sheet.thickness_m = o.thickness_m;
  return Sheet(surface, sheet);
}

}  // namespace parallax::kernel
