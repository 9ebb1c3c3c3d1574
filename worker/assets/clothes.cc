// Shirts and trousers, laid down flat.
#include <algorithm>
#include <cmath>

#include "worker/assets/textiles.h"

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
        p = nearest + 0.04f * (p - nearest);  // Not quite: three in a line would have no area.
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

// One half of a shirt from the hem up to the middle of the neck; x > 0.
Path2 ShirtHalf(const ShirtParams& p, float droop_rad) {
  const float w = 0.5f * p.width_m, h = p.length_m;
  Path2 half{{p.flare * w, 0}, {0.97f * w, 0.45f * h}, {0.98f * w, 0.7f * h}};
  const Vec2f shoulder(0.96f * w, 0.93f * h);
  if (p.sleeve_m > 0) {
    const Vec2f along(std::cos(droop_rad), -std::sin(droop_rad)),
        up(std::sin(droop_rad), std::cos(droop_rad));
    const Vec2f end = shoulder + p.sleeve_m * along;
    half.push_back(end - p.cuff_m * up);
    half.push_back(end);
  } else {
    // A vest: the armhole is cut out.
    half.emplace_back(0.78f * w, 0.76f * h);
    half.emplace_back(0.72f * w, 0.86f * h);
  }
  half.push_back(p.sleeve_m > 0 ? shoulder : Vec2f(0.7f * w, 0.98f * h));
  half.emplace_back(0.42f * w, h);
  half.emplace_back(0.3f * w, 0.95f * h);
  return half;
}

}  // namespace

Asset MakeShirt(const ShirtParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "shirt");
  const Noise noise(rng);
  const float w = 0.5f * p.width_m, h = p.length_m;
  Path2 outline = ShirtHalf(p, p.droop_rad);
  outline.emplace_back(0.0f, h - p.neck_m);
  const Path2 left = ShirtHalf(p, p.droop_left_rad);
  for (size_t i = left.size(); i-- > 0;) outline.emplace_back(-left[i].x(), left[i].y());
  const MaterialSlot cloth = Slot("cloth", {"fabric"});
  b.Add(Garment(outline, 0.012f, noise), cloth);
  // The collar: a band round the neck, or two points that lie open.
  const float low = h - p.neck_m - 0.02f;
  const Path3 band = Spline(Path3{{0.34f * w, 0.965f * h, 0.02f},
                                  {0.2f * w, 0.5f * (0.965f * h + low), 0.025f},
                                  {0, low, 0.026f},
                                  {-0.2f * w, 0.5f * (0.965f * h + low), 0.025f},
                                  {-0.34f * w, 0.965f * h, 0.02f}},
                            6);
  SweepOptions flat;
  flat.keep_up = true;
  b.Add(Sweep(band, RectSection(0.022f, 0.006f, 0.0025f, 2), flat), cloth);
  if (p.collar) {
    const Path2 point{{0.02f, low - 0.045f},
                      {0.4f * w, 0.94f * h},
                      {0.34f * w, 0.985f * h},
                      {0.015f, low + 0.012f}};
    b.AddMirroredX(Extrude(point, 0.005f, 0.0018f).Moved(0, 0, 0.027f), cloth);
    // A strip with buttons down the front.
    const int buttons = 6;
    Path3 strip;
    for (int k = 0; k <= 24; ++k) {
      const float y = Lerp(0.01f, low - 0.03f, static_cast<float>(k) / 24.0f);
      strip.emplace_back(0, y, 0.027f + 0.0015f * noise.At({3, 14 * y, 1}));
    }
    b.Add(Sweep(strip, RectSection(0.032f, 0.004f, 0.0012f, 1), flat), cloth);
    for (int k = 0; k < buttons; ++k) {
      const float y = Lerp(0.06f, low - 0.06f, static_cast<float>(k) / (buttons - 1));
      b.Add(Cylinder(0.0055f, 0.0035f, 0.001f, 16).Moved(0, y, 0.028f), PlasticSlot("buttons"));
    }
  }
  return b.Finish();
}

Asset SampleShirt(Rng& rng) {
  ShirtParams p;
  p.width_m = Draw(rng, 0.46, 0.58);
  p.length_m = Draw(rng, 0.6, 0.74);
  const int kind = rng.UniformInt(0, 3);  // T-shirt, long sleeves, with collar, vest.
  p.sleeve_m = kind == 0 ? Draw(rng, 0.16, 0.24) : (kind == 3 ? 0.0f : Draw(rng, 0.44, 0.54));
  p.cuff_m = kind == 0 ? Draw(rng, 0.14, 0.17) : Draw(rng, 0.1, 0.12);
  p.droop_rad = Draw(rng, 0.35, 0.85);
  p.droop_left_rad = Draw(rng, 0.35, 0.85);
  p.neck_m = kind == 2 ? 0.09f : Draw(rng, 0.06, 0.16);
  p.flare = Draw(rng, 0.9, 1.05);
  p.collar = kind == 2;
  p.seed = rng.Seed();
  return MakeShirt(p);
}

Asset MakePants(const PantsParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "pants");
  const Noise noise(rng);
  const float w = 0.5f * p.waist_m, top = p.length_m, rise = p.rise_m, crotch = top - rise;
  const float hip = 1.12f * w;
  // Right leg: outer seam up, inner seam down; each leg lies as it fell.
  const auto foot = [&](float spread) { return spread + 0.02f; };
  const Path2 outline{{foot(p.spread_right_m), 0},
                      {foot(p.spread_right_m) + p.hem_m, 0.0f},
                      {0.6f * p.spread_right_m + hip, 0.62f * crotch},
                      {1.04f * hip, crotch + 0.2f * rise},
                      {w, top},
                      {-w, top},
                      {-1.04f * hip, crotch + 0.2f * rise},
                      {-0.6f * p.spread_left_m - hip, 0.62f * crotch},
                      {-foot(p.spread_left_m) - p.hem_m, 0},
                      {-foot(p.spread_left_m), 0},
                      {-0.012f, crotch},
                      {0.012f, crotch}};
  const MaterialSlot cloth = Slot("cloth", {"fabric"});
  b.Add(Garment(outline, 0.016f, noise), cloth);
  SweepOptions flat;
  flat.keep_up = true;
  const auto band = [&](float y, float half, float width, const MaterialSlot& slot) {
    const Path3 path{{-half, y, 0.02f}, {0, y, 0.025f}, {half, y, 0.02f}};
    b.Add(Sweep(Spline(path, 8), RectSection(width, 0.008f, 0.003f, 2), flat), slot);
  };
  band(top - 0.02f, 0.99f * w, 0.038f, cloth);
  if (p.belt) {
    band(top - 0.02f, 0.96f * w, 0.03f, Slot("belt", {"leather", "fabric"}));
    for (const float s : {-0.55f, 0.0f, 0.55f})
      b.Add(Board({s * w - 0.006f, top - 0.044f, 0.018f}, {s * w + 0.006f, top + 0.002f, 0.034f},
                  0.002f),
            cloth);
  } else {
    b.Add(Cylinder(0.008f, 0.004f, 0.001f, 16).Moved(0, top - 0.02f, 0.027f), MetalSlot("button"));
  }
  return b.Finish();
}

Asset SamplePants(Rng& rng) {
  PantsParams p;
  p.waist_m = Draw(rng, 0.34, 0.42);
  const bool shorts = rng.Bernoulli(0.3);
  p.rise_m = Draw(rng, 0.24, 0.3);
  p.length_m = shorts ? p.rise_m + Draw(rng, 0.14, 0.3) : Draw(rng, 0.9, 1.06);
  p.hem_m = shorts ? Draw(rng, 0.19, 0.24) : Draw(rng, 0.13, 0.22);
  p.spread_right_m = Draw(rng, 0.01, shorts ? 0.05 : 0.16);
  p.spread_left_m = Draw(rng, 0.01, shorts ? 0.05 : 0.16);
  p.belt = rng.Bernoulli(0.4);
  p.seed = rng.Seed();
  return MakePants(p);
}

}  // namespace parallax
