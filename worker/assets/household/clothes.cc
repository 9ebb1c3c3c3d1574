// Shirts and trousers, laid down flat.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/kernel/subdivide.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Where a point of the pattern lies: on the floor, and in the cloth before it was put down.
struct Laid {
  Vec2f floor, cloth;
};

// A garment laid down flat: two layers over a pattern of cells, sewn at the rim, stuffed a little
// and wrinkled. Lies on z = 0.
Shape Garment(int columns, int rows, const std::function<bool(int, int)>& keep,
              const std::function<Laid(int, int)>& pattern, float thickness, const Noise& noise) {
  SlabOptions slab;
  slab.columns = columns;
  slab.rows = rows;
  slab.keep = keep;
  slab.point = [&](int i, int j) {
    const Vec2f p = pattern(i, j).floor;
    return Vec3f(p.x(), p.y(), thickness);
  };
  slab.thickness = [&](int, int) { return thickness; };
  slab.rim_sharpness = 2;
  Cage cage = Slab(slab);
  // The slab made its points in this order, the lower after the upper.
  size_t at = 0;
  const auto kept = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < columns && j < rows && keep(i, j);
  };
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      if (!(kept(i, j) || kept(i - 1, j) || kept(i, j - 1) || kept(i - 1, j - 1))) continue;
      const Vec2f c = pattern(i, j).cloth;
      cage.shape.texture[at++] = {c.x(), c.y(), thickness};
      cage.shape.texture[at++] = {c.x(), c.y(), 0};
    }
  }
  Shape out = Subdivided(cage, 3);
  for (size_t i = 0; i < out.points.size(); ++i) {
    Vec3f& p = out.points[i];
    const Vec3f& c = out.texture[i];
    const float up = p.z() / thickness;  // The rim is halfway.
    const float folds = noise.Ridges({p.x() * 7, p.y() * 4.5f, 0}) * 0.013f +
                        noise.Ridges({p.x() * 13 + 4, p.y() * 9, 2}) * 0.006f +
                        0.003f * noise.At({c.x() * 30, c.y() * 30, 0});
    const float lift = 0.006f * std::max(0.0f, noise.At({p.x() * 4, p.y() * 4, 9}));
    p.z() += lift + folds * Smooth01(2 * up - 1);
  }
  out.crease_rad = 1.3f;
  return out;
}

// The pattern of a shirt: a trunk of six cells by seven and, beside its upper two rows, a sleeve of
// four at each side.
constexpr int kTrunkRows = 7, kArmpit = 5, kSleeve = 4, kHalf = 3;

// A shirt or vest, lying flat.
struct ShirtParams {
  float width_m = 0.5f, length_m = 0.68f;         // Size of the trunk.
  float sleeve_m = 0.2f;                          // 0 = a vest.
  float cuff_m = 0.14f;                           // Width of the sleeve's end.
  float droop_rad = 0.5f, droop_left_rad = 0.5f;  // Angles of the sleeves below the shoulder line.
  float neck_m = 0.09f;                           // Depth of the neck's cut.
  float flare = 1.0f;                             // The hem's width in parts of the trunk's.
  bool collar = false;                            // With a strip of buttons.
  uint64_t seed = 0;
};

Laid ShirtPoint(const ShirtParams& p, int i, int j) {
  const int k = i - kSleeve - kHalf;  // From the middle.
  const float side = k < 0 ? -1.0f : 1.0f, w = 0.5f * p.width_m, h = p.length_m;
  const float across = std::min(1.0f, std::abs(static_cast<float>(k)) / kHalf);
  const float up = static_cast<float>(j) / kTrunkRows;
  // The trunk's outline at this level: hem, waist, armpit, and in to the shoulder's tip.
  const bool vest = p.sleeve_m <= 0;
  const float half = j >= kArmpit && vest ? w * (j == kArmpit ? 0.97f : 0.72f)
                                          : w * Lerp(p.flare, 0.98f, Smooth01(up / 0.6f));
  // Shoulders slope from the neck, whose cut is deepest in the middle.
  const float neck = Smooth01(1.5f * (1 - across / 0.45f));
  const float shoulder = Lerp(h, 0.93f * h, Smooth01((across - 0.3f) / 0.7f)) - p.neck_m * neck;
  const float armpit = 0.7f * h;
  const float y = j <= kArmpit ? armpit * static_cast<float>(j) / kArmpit
                               : Lerp(armpit, shoulder,
                                      static_cast<float>(j - kArmpit) / (kTrunkRows - kArmpit));
  const Vec2f flat(side * half * across, y);
  const int beyond = std::abs(k) - kHalf;
  if (beyond <= 0) return {flat, flat};
  // The sleeve runs on from the trunk's side to the cuff, and droops.
  const float droop = k > 0 ? p.droop_rad : p.droop_left_rad;
  const float t = static_cast<float>(beyond) / kSleeve,
              s = static_cast<float>(j - kArmpit) / (kTrunkRows - kArmpit);
  const auto sleeve = [&](float angle) {
    const Vec2f along(std::cos(angle), -std::sin(angle)), out(std::sin(angle), std::cos(angle));
    const Vec2f tip(half, 0.93f * h), end = tip + p.sleeve_m * along;
    const Vec2f cuff = end - p.cuff_m * (1 - s) * out;
    return Vec2f(Lerp(half, cuff.x(), t), Lerp(y, cuff.y(), t));
  };
  const Vec2f lies = sleeve(droop), straight = sleeve(0.15f);
  return {{side * lies.x(), lies.y()}, {side * straight.x(), straight.y()}};
}

Asset MakeShirt(const ShirtParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "shirt");
  const Noise noise(rng);
  const float w = 0.5f * p.width_m, h = p.length_m;
  const MaterialSlot cloth = Slot("cloth", {"fabric"});
  const auto keep = [&](int i, int j) {
    const bool trunk = i >= kSleeve && i < kSleeve + 2 * kHalf;
    return trunk || (j >= kArmpit && p.sleeve_m > 0);
  };
  b.Add(Garment(
            2 * (kSleeve + kHalf), kTrunkRows, keep,
            [&](int i, int j) { return ShirtPoint(p, i, j); }, 0.012f, noise),
        cloth);
  // The collar: a band round the neck, or two points that lie open.
  const float low = h - p.neck_m - 0.02f;
  const Path3 band = Spline(Path3{{0.34f * w, 0.965f * h, 0.02f},
                                  {0.2f * w, 0.5f * (0.965f * h + low), 0.025f},
                                  {0, low, 0.026f},
                                  {-0.2f * w, 0.5f * (0.965f * h + low), 0.025f},
                                  {-0.34f * w, 0.965f * h, 0.02f}},
                            6);
  const SweepOptions flat{.keep_up = true};
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

// Trousers, lying flat.
struct PantsParams {
  float waist_m = 0.38f, length_m = 1.0f;
  float rise_m = 0.27f;                                 // Waist to crotch.
  float hem_m = 0.18f;                                  // Width of a leg's end.
  float spread_right_m = 0.06f, spread_left_m = 0.06f;  // How far each leg lies from the middle.
  bool belt = false;
  uint64_t seed = 0;
};

Asset MakePants(const PantsParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "pants");
  const Noise noise(rng);
  const float w = 0.5f * p.waist_m, top = p.length_m, rise = p.rise_m, crotch = top - rise;
  const float hip = 1.12f * w;
  // Two cells a leg and one between them, which is there only above the crotch.
  constexpr int kLegRows = 7, kRows = 10;
  const auto laid = [&](int i, int j) {
    const bool right = i >= 3;
    const float spread = right ? p.spread_right_m : p.spread_left_m;
    // Runs from the inner seam to the outer one.
    const float share = 0.5f * static_cast<float>(right ? i - 3 : 2 - i);
    const auto row = [&](float apart) {
      if (j >= kLegRows) {
        const float t = static_cast<float>(j - kLegRows) / (kRows - kLegRows);
        return Vec2f(Lerp(0.012f, Lerp(1.04f * hip, w, t), Lerp(share, std::max(share, 0.3f), t)),
                     Lerp(crotch, top, t));
      }
      const float t = static_cast<float>(j) / kLegRows;  // Each leg lies as it fell.
      const float inner = Lerp(apart + 0.02f, 0.012f, t);
      const float outer = Lerp(apart + 0.02f + p.hem_m, 1.04f * hip, t);
      return Vec2f(Lerp(inner, outer, share), crotch * t);
    };
    const Vec2f lies = row(spread), straight = row(0.0f);
    const float side = right ? 1.0f : -1.0f;
    return Laid{{side * lies.x(), lies.y()}, {side * straight.x(), straight.y()}};
  };
  const MaterialSlot cloth = Slot("cloth", {"fabric"});
  b.Add(Garment(
            5, kRows, [](int i, int j) { return i != 2 || j >= kLegRows; }, laid, 0.016f, noise),
        cloth);
  const SweepOptions flat{.keep_up = true};
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

}  // namespace

Asset SampleShirt(Rng& rng) {
  ShirtParams p{.width_m = Draw(rng, 0.46, 0.58), .length_m = Draw(rng, 0.6, 0.74)};
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

Asset SamplePants(Rng& rng) {
  PantsParams p{.waist_m = Draw(rng, 0.34, 0.42)};
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
