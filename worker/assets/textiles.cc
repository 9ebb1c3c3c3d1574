#include "worker/assets/textiles.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A flat garment: the outline stuffed a little, wrinkled, thicker at its hems. Lies on z = 0.
Shape Garment(const Path2& outline, float thickness, const Noise& noise) {
  // A grid over the bounding box, cells kept where their middle lies inside; the margin follows the
  // cells, which are fine enough to read as a hem.
  Box2f box;
  for (const Vec2f& p : outline) box.extend(p);
  const float cell = 0.011f;
  const int nx = static_cast<int>(std::ceil(box.sizes().x() / cell)),
            ny = static_cast<int>(std::ceil(box.sizes().y() / cell));
  const auto inside = [&](const Vec2f& p) {
    bool in = false;
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const Vec2f &a = outline[i], &c = outline[j];
      if ((a.y() > p.y()) != (c.y() > p.y()) &&
          p.x() < (c.x() - a.x()) * (p.y() - a.y()) / (c.y() - a.y()) + a.x())
        in = !in;
    }
    return in;
  };
  const auto to_edge = [&](const Vec2f& p, Vec2f& nearest) {
    float least = 1e9f;
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const Vec2f d = outline[i] - outline[j];
      const float t = std::clamp((p - outline[j]).dot(d) / d.squaredNorm(), 0.0f, 1.0f);
      const Vec2f q = outline[j] + t * d;
      if ((p - q).norm() < least) {
        least = (p - q).norm();
        nearest = q;
      }
    }
    return least;
  };
  std::vector<char> kept(static_cast<size_t>(nx * ny), 0);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i)
      kept[static_cast<size_t>(j * nx + i)] = inside(box.min() + cell * Vec2f(i + 0.5f, j + 0.5f));
  }
  const auto cell_at = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < nx && j < ny && kept[static_cast<size_t>(j * nx + i)];
  };
  Shape shape;
  std::vector<int> top(static_cast<size_t>((nx + 1) * (ny + 1)), -1), bottom = top;
  const auto id = [&](int i, int j) { return static_cast<size_t>(j * (nx + 1) + i); };
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const int around =
          cell_at(i, j) + cell_at(i - 1, j) + cell_at(i, j - 1) + cell_at(i - 1, j - 1);
      if (around == 0) continue;
      Vec2f p = box.min() + cell * Vec2f(static_cast<float>(i), static_cast<float>(j));
      Vec2f nearest = p;
      float d = to_edge(p, nearest);
      // Points of the margin slide onto the outline.
      if (around < 4) {
        p = nearest;
        d = 0;
      }
      const float body = Smooth01(d / 0.03f);
      const float hem = std::exp(-std::pow((d - 0.012f) / 0.006f, 2.0f));
      const Vec3f at(p.x(), p.y(), 0);
      const float folds = noise.Ridges({p.x() * 7, p.y() * 4.5f, 0}) * 0.012f +
                          noise.Ridges({p.x() * 13 + 4, p.y() * 9, 2}) * 0.005f +
                          0.004f * noise.At(at * 30.0f);
      const float lift = std::max(0.0f, 0.008f * noise.At({p.x() * 4, p.y() * 4, 9})) * (1 - body);
      const float z =
          thickness * (0.35f + 0.65f * body) + 0.0015f * hem + std::max(0.0f, folds) * body;
      top[id(i, j)] = static_cast<int>(shape.AddPoint({p.x(), p.y(), z + lift}, {p.x(), p.y(), z}));
      bottom[id(i, j)] = static_cast<int>(shape.AddPoint({p.x(), p.y(), lift}, {p.x(), p.y(), 0}));
    }
  }
  const auto u = [](int v) { return static_cast<uint32_t>(v); };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      if (!cell_at(i, j)) continue;
      const std::array<std::pair<int, int>, 4> c{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
      uint32_t t[4], s[4];
      for (int k = 0; k < 4; ++k) {
        t[k] = u(top[id(c[k].first, c[k].second)]);
        s[k] = u(bottom[id(c[k].first, c[k].second)]);
      }
      shape.AddQuad(t[0], t[1], t[2], t[3]);
      shape.AddQuad(s[3], s[2], s[1], s[0]);
      const bool open[4] = {!cell_at(i, j - 1), !cell_at(i + 1, j), !cell_at(i, j + 1),
                            !cell_at(i - 1, j)};
      for (int k = 0; k < 4; ++k) {
        const int n = (k + 1) % 4;
        if (open[k]) shape.AddQuad(s[k], s[n], t[n], t[k]);
      }
    }
  }
  shape.crease_rad = 1.3f;
  return shape;
}

}  // namespace

namespace {

// The distances to the sides and to the ends in metres, for patterns with a border (materials read
// them from uv).
void MarkBorder(Shape& rug, const std::function<Vec2f(const Vec3f&)>& to_edge) {
  for (Face& f : rug.faces) {
    for (int k = 0; k < f.corners; ++k) f.uv[k] = to_edge(rug.points[f.v[k]]).cwiseMax(1e-4f);
  }
}

// Lies a little uneven; corners and edges lift here and there.
Vec3f Laid(const Vec3f& q, const RugParams& p, const Noise& noise) {
  if (q.z() <= 0.5f * p.thickness_m) return q;
  const float edge = std::max(2 * std::abs(q.x()) / p.width_m, 2 * std::abs(q.y()) / p.depth_m);
  const float lift = Smooth01((edge - 0.9f) / 0.1f) * std::max(0.0f, noise.At(q * 1.2f));
  return Vec3f(q.x(), q.y(), q.z() + 0.0015f * noise.At(q * 3) + 0.002f * lift);
}

// Turned: circles, ovals, and hides whose outline wanders.
Shape RoundRug(const RugParams& p, const Noise& noise) {
  const float r = 0.5f * p.width_m, t = p.thickness_m, squash = p.depth_m / p.width_m;
  Path2 profile{{0, 0}, {r - 0.004f, 0}};
  const Path2 lip = Arc({r - 0.5f * t, 0.5f * t}, 0.5f * t, 0.5f * t, -0.5f * kPi, 0.5f * kPi, 6);
  profile.insert(profile.end(), lip.begin(), lip.end());
  for (int k = 12; k >= 0; --k)
    profile.emplace_back((r - 0.5f * t) * static_cast<float>(k) / 13.0f, t);
  LatheOptions options;
  options.segments = 96;
  if (p.style == RugStyle::kHide) {
    // Four legs, a neck and a tail stump.
    options.modulate = [&](float a, float) {
      const Vec3f way(std::cos(a), std::sin(a), 0.5f);
      return 0.8f + 0.1f * std::cos(4 * a + kPi) + 0.06f * std::cos(2 * a) +
             0.05f * noise.At(way * 2.1f) + 0.02f * noise.At(way * 6);
    };
  }
  Shape rug = Lathe(profile, options);
  MarkBorder(rug, [&](const Vec3f& q) {
    return Vec2f::Constant(squash * (r - std::hypot(q.x(), q.y()))).eval();
  });
  return rug.Bent([&](const Vec3f& q) { return Laid({q.x(), squash * q.y(), q.z()}, p, noise); });
}

Shape SquareRug(const RugParams& p, const Noise& noise) {
  BoxOptions box;
  box.bevel_m = 0.45f * p.thickness_m;
  box.bevel_steps = 2;
  box.pieces = {24, 16, 1};
  Shape rug =
      RoundedBox({p.width_m, p.depth_m, p.thickness_m}, box).Moved(0, 0, 0.5f * p.thickness_m);
  MarkBorder(rug, [&](const Vec3f& q) {
    return Vec2f(0.5f * p.width_m - std::abs(q.x()), 0.5f * p.depth_m - std::abs(q.y()));
  });
  return rug.Bent([&](const Vec3f& q) { return Laid(q, p, noise); });
}

// Threads at the short ends.
Shape RugFringe(const RugParams& p, Rng& rng) {
  const int count = static_cast<int>(p.depth_m / 0.022f);
  Shape fringe;
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < count; ++i) {
      const float y =
          p.depth_m * ((static_cast<float>(i) + 0.5f) / static_cast<float>(count) - 0.5f);
      const float x = side * (0.5f * p.width_m - 0.004f),
                  length = p.fringe_m * Draw(rng, 0.85, 1.15), sway = Draw(rng, -0.012, 0.012);
      fringe.Add(Tube({{x, y, 0.004f},
                       {x + side * 0.5f * length, y + 0.3f * sway, 0.0035f},
                       {x + side * length, y + sway, 0.003f}},
                      0.0026f, 0.001f, 6));
    }
  }
  return fringe;
}

}  // namespace

Asset MakeRug(const RugParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "rug");
  const Noise noise(rng);
  const bool square = p.style == RugStyle::kSquare || p.style == RugStyle::kRunner;
  b.Add(square ? SquareRug(p, noise) : RoundRug(p, noise), Slot("pile", {"carpet", "fabric"}));
  if (square && p.fringe_m > 0) b.Add(RugFringe(p, rng), Slot("fringe", {"fabric"}));
  return b.Finish();
}

Asset SampleRug(Rng& rng) {
  RugParams p;
  const RugStyle styles[] = {RugStyle::kSquare, RugStyle::kSquare, RugStyle::kRound,
                             RugStyle::kOval,   RugStyle::kRunner, RugStyle::kHide};
  p.style = rng.Pick(styles);
  p.width_m = Draw(rng, 1.6, 2.7);
  p.depth_m = p.width_m * Draw(rng, 0.58, 0.74);
  if (p.style == RugStyle::kRound) p.depth_m = p.width_m = Draw(rng, 1.2, 2.2);
  if (p.style == RugStyle::kRunner) p.depth_m = std::max(0.6f, 0.32f * p.width_m);
  if (p.style == RugStyle::kHide) p.depth_m = p.width_m * Draw(rng, 0.75, 0.95);
  p.thickness_m = Draw(rng, 0.007, 0.014);
  p.fringe_m = rng.Bernoulli(0.5) ? Draw(rng, 0.05, 0.07) : 0.0f;
  p.seed = rng.Seed();
  return MakeRug(p);
}

Asset SampleShirt(Rng& rng) {
  const float w = Draw(rng, 0.23, 0.28), h = Draw(rng, 0.62, 0.74), sleeve = Draw(rng, 0.14, 0.3);
  AssetBuilder b(rng.Seed());
  const Noise noise(rng);
  const float drop = 0.75f * sleeve;
  // Right half from the hem up, then mirrored.
  const Path2 half{{0.94f * w, 0},
                   {0.97f * w, 0.5f * h},
                   {w, 0.7f * h},
                   {w + 0.62f * sleeve, 0.72f * h - drop + 0.12f},
                   {w + sleeve, 0.84f * h - drop + 0.12f},
                   {0.98f * w + 0.02f, 0.93f * h},
                   {0.42f * w, h},
                   {0.3f * w, 0.94f * h}};
  Path2 outline = half;
  outline.emplace_back(0.0f, 0.9f * h);
  for (size_t i = half.size(); i-- > 0;) outline.emplace_back(-half[i].x(), half[i].y());
  Path2 round = outline;
  b.Add(Garment(round, 0.012f, noise), Slot("cloth", {"fabric"}));
  // Collar.
  const Path3 collar = Spline(Path3{{0.34f * w, 0.955f * h, 0.02f},
                                    {0.2f * w, 0.9f * h, 0.024f},
                                    {0, 0.875f * h, 0.024f},
                                    {-0.2f * w, 0.9f * h, 0.024f},
                                    {-0.34f * w, 0.955f * h, 0.02f}},
                              6);
  SweepOptions flat;
  flat.keep_up = true;
  b.Add(Sweep(collar, RectSection(0.022f, 0.006f, 0.0025f, 2), flat), Slot("cloth", {"fabric"}));
  return b.Finish();
}

Asset SamplePants(Rng& rng) {
  const float w = Draw(rng, 0.19, 0.23), h = Draw(rng, 0.85, 1.05), leg = w * Draw(rng, 0.75, 0.95);
  AssetBuilder b(rng.Seed());
  const Noise noise(rng);
  const float crotch = 0.7f * h, spread = 0.06f;
  const Path2 outline{{spread + 0.02f, 0},
                      {spread + leg, 0.0f},
                      {1.02f * w + 0.02f, 0.62f * h},
                      {1.05f * w, 0.78f * h},
                      {0.9f * w, h},
                      {-0.9f * w, h},
                      {-1.05f * w, 0.78f * h},
                      {-1.02f * w - 0.02f, 0.62f * h},
                      {-spread - leg, 0},
                      {-spread - 0.02f, 0},
                      {-0.012f, crotch},
                      {0.012f, crotch}};
  b.Add(Garment(outline, 0.016f, noise), Slot("cloth", {"fabric"}));
  const Path3 band{
      {-0.9f * w, h - 0.02f, 0.02f}, {0, h - 0.02f, 0.024f}, {0.9f * w, h - 0.02f, 0.02f}};
  SweepOptions flat;
  flat.keep_up = true;
  b.Add(Sweep(Spline(band, 8), RectSection(0.038f, 0.008f, 0.003f, 2), flat),
        Slot("cloth", {"fabric"}));
  b.Add(Cylinder(0.008f, 0.004f, 0.001f, 16).Moved(0, h - 0.02f, 0.026f), MetalSlot("button"));
  return b.Finish();
}

void RegisterTextiles(std::vector<AssetClass>& classes) {
  classes.push_back({"Rug", "textiles", Placement::kFloor, true, 0, SampleRug});
  classes.push_back({"Shirt", "textiles", Placement::kOnTop, true, 0, SampleShirt});
  classes.push_back({"Pants", "textiles", Placement::kOnTop, true, 0, SamplePants});
}

}  // namespace parallax
