#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/household/vessel_parts.h"
#include "worker/assets/kernel/subdivide.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Walls of vases in shares of radius and height: baluster, amphora, trumpet, double gourd,
// cylinder, globe.
std::vector<std::pair<float, float>> VaseShares(int form) {
  switch (form) {
    case 0:
      return {{0.5f, 0},     {0.62f, 0.04f}, {1, 0.3f}, {0.86f, 0.52f},
              {0.3f, 0.72f}, {0.26f, 0.9f},  {0.36f, 1}};
    case 1:
      return {{0.42f, 0},   {0.46f, 0.03f}, {0.8f, 0.35f},  {1, 0.62f},
              {0.8f, 0.8f}, {0.46f, 0.88f}, {0.48f, 0.95f}, {0.6f, 1}};
    case 2:
      return {{0.55f, 0},    {0.6f, 0.02f}, {0.38f, 0.12f}, {0.36f, 0.3f},
              {0.5f, 0.62f}, {0.78f, 0.9f}, {1, 1}};
    case 3:
      return {{0.6f, 0},      {0.72f, 0.03f}, {1, 0.24f},     {0.72f, 0.46f}, {0.4f, 0.56f},
              {0.55f, 0.72f}, {0.5f, 0.84f},  {0.28f, 0.94f}, {0.34f, 1}};
    case 4:
      return {{0.86f, 0}, {0.95f, 0.02f}, {1, 0.3f}, {0.98f, 0.7f}, {0.92f, 0.9f}, {0.94f, 1}};
    default:
      return {{0.4f, 0},      {0.5f, 0.02f}, {0.9f, 0.2f},   {1, 0.46f},
              {0.86f, 0.74f}, {0.5f, 0.9f},  {0.42f, 0.95f}, {0.48f, 1}};
  }
}

// A vase, turned about z.
struct VaseParams {
  float height_m = 0.3f;
  float radius_m = 0.09f;  // The widest.
  int form = 0;            // 0 bottle, 1 amphora, 2 trumpet, 3 gourd, 4 cylinder, 5 ball.
  int flutes = 0;          // Vertical ribs; 0 = smooth.
  float twist_rad = 0;     // Twist of the ribs over the height.
  bool handles = false;
  uint64_t seed = 0;
};

Asset MakeVase(const VaseParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  const Path2 wall = Profile(VaseShares(p.form % 6), r, h, p.form % 6 == 4 ? 5 : 7);
  LatheOptions options{.segments = p.flutes > 0 ? 96 : 64};
  if (p.flutes > 0) {
    options.modulate = [&](float a, float z) {
      const float t = std::clamp(z / h, 0.0f, 1.0f);
      const float fade = Smooth01(t * 8) * Smooth01((1 - t) * 6);
      return 1 + 0.045f * fade *
                     std::cos(static_cast<float>(p.flutes) * a +
                              p.twist_rad * t * static_cast<float>(p.flutes));
    };
  }
  b.Add(Lathe(VesselProfile(WithFoot(wall), std::min(0.005f, 0.1f * r), 0.008f), options),
        Slot("body", {"ceramic", "glass", "stone", "metal"}));
  if (p.handles) {
    const float z0 = 0.5f * h, z1 = 0.86f * h;
    b.AddMirroredX(
        LoopHandle({RadiusAt(wall, z0), z0, RadiusAt(wall, z1), z1, 0.4f * r, 0.02f, 0.011f}),
        Slot("body", {"ceramic"}));
  }
  return b.Finish();
}

// The outside of a bottle from its foot to the lip, and where its label sticks (heights in metres).
struct BottleWall {
  Path2 wall;
  float label_low = 0, label_high = 0;
};

// A bottle with cap and label.
struct BottleParams {
  float height_m = 0.3f;
  float radius_m = 0.037f;
  // 0 wine with shoulders, 1 sloping, 2 beer, 3 water with ribs, 4 soap with pump, 5 oval flask of
  // washing-up liquid or shampoo.
  int form = 0;
  float shoulder = 0;  // The shoulder moves up by this share of the height.
  float neck = 1;      // Factor on the neck's radius.
  float square = 0;    // 0 round, 1 nearly square in plan; of a flask: how flat it is.
  bool label = true;
  uint64_t seed = 0;
};

BottleWall MakeBottleWall(const BottleParams& p) {
  const float r = p.radius_m, h = p.height_m, neck = p.neck * 0.0145f / r;
  // Shares of radius and height above the straight part.
  using Shares = std::vector<std::pair<float, float>>;
  float low = 0.16f, high = 0.52f;
  Shares rest;
  switch (p.form) {
    case 0:
      rest = {{1, 0.6f}, {0.86f, 0.665f}, {0.5f, 0.71f}, {neck, 0.77f}, {0.97f * neck, 0.93f}};
      break;
    case 1:
      high = 0.42f;
      rest = {{0.97f, 0.5f}, {0.76f, 0.62f}, {0.5f, 0.74f}, {neck, 0.84f}, {0.97f * neck, 0.94f}};
      break;
    case 2:
      rest = {{0.98f, 0.58f}, {0.72f, 0.68f}, {0.5f, 0.8f}, {0.42f * p.neck, 0.94f}};
      break;
    case 3:
      low = 0.3f;
      high = 0.55f;
      rest = {{0.98f, 0.62f}, {0.8f, 0.74f}, {0.5f, 0.86f}, {0.42f * p.neck, 0.95f}};
      break;
    default:
      high = 0.7f;
      rest = {{0.97f, 0.78f}, {0.8f, 0.86f}, {0.45f, 0.9f}, {0.36f, 0.93f}};
  }
  const float base = high;
  const auto lifted = [&](float z) {
    return z + p.shoulder * std::clamp((0.95f - z) / (0.95f - base), 0.0f, 1.0f);
  };
  high = lifted(high);
  BottleWall out;
  out.wall = {{0.93f * r, 0.0f}, {0.99f * r, 0.004f}, {r, 0.012f}, {r, low * h}, {r, high * h}};
  Path2 curve{out.wall.back()};
  for (const auto& [rr, z] : rest) curve.emplace_back(rr * r, lifted(z) * h);
  curve = Spline(curve, 6);
  out.wall.insert(out.wall.end(), curve.begin() + 1, curve.end());
  // Lip.
  const float nr = out.wall.back().x(), z = out.wall.back().y();
  for (const auto& [dr, dz] :
       {std::pair{0.0022f, 0.001f}, {0.0028f, 0.006f}, {0.0022f, 0.01f}, {0.0002f, 0.011f}})
    out.wall.emplace_back(nr + dr, z + dz);
  out.wall.emplace_back(nr, std::max(h, z + 0.0115f));
  out.label_low = low * h + 0.004f;
  out.label_high = high * h - 0.003f;
  return out;
}

// Points every few millimetres where the ribs of a plastic bottle are.
Path2 DenseBelow(const Path2& wall, float z) {
  Path2 dense;
  for (size_t i = 0; i < wall.size(); ++i) {
    dense.push_back(wall[i]);
    if (i + 1 < wall.size() && wall[i].y() < z && wall[i + 1].y() - wall[i].y() > 0.02f) {
      for (int k = 1; k < 40; ++k)
        dense.push_back(wall[i] + (wall[i + 1] - wall[i]) * (static_cast<float>(k) / 40.0f));
    }
  }
  return dense;
}

// Cork and foil, crown or screw cap, or a pump; `nr` is the radius of the neck.
void AddClosure(AssetBuilder& b, const BottleParams& p, float nr, float top) {
  if (p.form <= 1) {
    b.Add(Cylinder(nr - 0.0022f, 0.03f, 0.001f, 20).Moved(0, 0, top - 0.016f),
          Slot("cork", {"wood", "bark", "plastic"}));
    b.Add(LatheRing({{nr + 0.0002f, 0.84f * top},
                     {nr + 0.0032f, 0.84f * top},
                     {nr + 0.0034f, top - 0.001f},
                     {nr + 0.0002f, top - 0.001f}},
                    32),
          Slot("foil", {"metal", "paper"}));
    return;
  }
  if (p.form == 4) {
    const MaterialSlot pump = Slot("pump", {"plastic", "metal"});
    b.Add(Cylinder(nr + 0.005f, 0.016f, 0.002f).Moved(0, 0, top - 0.012f), pump);
    b.Add(Cylinder(0.0045f, 0.03f, 0.001f).Moved(0, 0, top), pump);
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.011f, 0}, {0.0105f, 0.009f}, {0, 0.01f}}, 0.003f, 3))
              .Moved(0, 0, top + 0.026f),
          pump);
    b.Add(Sweep(Spline(Path3{{0, 0, top + 0.031f},
                             {0, 0.022f, top + 0.031f},
                             {0, 0.038f, top + 0.026f},
                             {0, 0.042f, top + 0.019f}},
                       5),
                RectSection(0.008f, 0.007f, 0.0025f, 3), {.end_round_m = 0.002f, .keep_up = true}),
          pump);
    return;
  }
  LatheOptions ribs;
  ribs.segments = p.form == 2 ? 63 : 72;
  ribs.modulate = [&](float a, float zz) {
    return zz < 0.006f ? 1 + 0.03f * std::cos((p.form == 2 ? 21.0f : 36.0f) * a) : 1.0f;
  };
  const float cr = nr + 0.0035f, ch = p.form == 2 ? 0.008f : 0.016f;
  b.Add(
      Lathe(Filleted(Path2{{0, 0}, {cr, 0}, {cr, 0.5f * ch}, {cr, ch}, {0, ch}}, 0.0015f, 3), ribs)
          .Moved(0, 0, top - 0.5f * ch),
      Slot("cap", {"metal", "plastic"}));
}

// A paper band just off the glass.
void AddLabel(AssetBuilder& b, float r, float low, float high) {
  constexpr int kSegments = 48;
  Shape label =
      LatheRing({{r - 0.0003f, low}, {r + 0.0004f, low}, {r + 0.0004f, high}, {r - 0.0003f, high}},
                kSegments);
  const size_t n = label.faces.size() / 4;
  const size_t once = n / static_cast<size_t>(LabelCopies(r, high - low));
  for (size_t s = 0; s < n; ++s) {
    Face& f = label.faces[n + s];  // The outer wall.
    f.group = 1;
    const float u0 = static_cast<float>(s % once) / static_cast<float>(once),
                u1 = static_cast<float>(s % once + 1) / static_cast<float>(once);
    f.uv = {Vec2f(u0, 0), Vec2f(u1, 0), Vec2f(u1, 1), Vec2f(u0, 1)};
  }
  b.Add(label, {Slot("label_edge", {"paper"}), PictureSlot("label")});
}

// A flask with an oval foot, a waist for the hand and a round neck; its labels are printed on the
// cage, before and behind.
Asset MakeFlask(const BottleParams& p) {
  AssetBuilder b(p.seed);
  const float h = p.height_m, wide = 1.3f * p.radius_m, flat = wide * Lerp(0.75f, 0.5f, p.square);
  const float neck = p.neck * 0.012f, waist = 1 - std::max(0.0f, p.shoulder + 0.08f);
  std::vector<CageRing> rings;
  const auto level = [&](float share, float z, float exponent, float sharpness = 0) {
    const Vec2f half(share * wide, share * flat);
    rings.push_back({EightPoints(-half, half, z * h, exponent), sharpness, 0});
  };
  level(0.8f, 0, 3);
  level(0.97f, 0.002f, 3, 1);
  level(1, 0.05f, 3);
  level(1, 0.14f, 3);
  level(waist, 0.42f, 2.8f);
  level(Lerp(waist, 1.0f, 0.8f), 0.62f, 2.6f);
  level(0.82f, 0.74f, 2.4f);
  for (const auto& [r, z] : {std::pair{1.15f, 0.81f}, {1.0f, 0.83f}, {1.0f, 0.9f}})
    rings.push_back({EightPoints(Vec2f::Constant(-r * neck), Vec2f::Constant(r * neck), z * h, 2),
                     z > 0.85f ? 2.0f : 0.0f, 0});
  Cage cage = Loft(rings);
  constexpr int kLow = 3, kHigh = 5;
  for (size_t ring = kLow; ring < kHigh && p.label; ++ring) {
    for (const size_t k : {1u, 2u, 5u, 6u}) {
      Face& f = cage.shape.faces[8 * ring + k];
      const float u0 = k % 4 == 1 ? 0.0f : 0.5f, v0 = static_cast<float>(ring - kLow) / 2;
      f.group = 1;
      f.uv = {Vec2f(u0, v0), Vec2f(u0 + 0.5f, v0), Vec2f(u0 + 0.5f, v0 + 0.5f),
              Vec2f(u0, v0 + 0.5f)};
    }
  }
  b.Add(Subdivided(cage, 3), {Slot("body", {"plastic", "glass"}), PictureSlot("label")});
  AddClosure(b, p, neck, 0.9f * h);
  return b.Finish();
}

Asset MakeBottle(const BottleParams& p) {
  if (p.form == 5) return MakeFlask(p);
  AssetBuilder b(p.seed);
  const BottleWall body = MakeBottleWall(p);
  const bool plastic = p.form == 3;
  const float shoulder = body.label_high;
  LatheOptions options{.segments = p.square > 0 ? 72 : 48};
  if (plastic || p.square > 0) {
    options.modulate = [&](float a, float z) {
      const float t = z / p.height_m;
      const float rib = plastic && t < 0.28f && t > 0.05f
                            ? 1 - 0.025f * (0.5f + 0.5f * std::cos(2 * kPi * t * 26))
                            : 1.0f;
      // A squircle of the same width, round again at the neck.
      const float c = std::abs(std::cos(a)), s = std::abs(std::sin(a));
      const float corner = 0.9f / std::pow(std::pow(c, 5.0f) + std::pow(s, 5.0f), 0.2f);
      const float much = p.square * (1 - Smooth01((z - shoulder) / (0.2f * p.height_m)));
      return rib * Lerp(1.0f, corner, much);
    };
  }
  const Path2 wall = plastic ? DenseBelow(body.wall, 0.27f * p.height_m) : body.wall;
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.0028f, 0.006f), options),
        plastic || p.form == 4 ? Slot("body", {"plastic", "glass"}) : GlassSlot("body"));
  AddClosure(b, p, body.wall.back().x(), body.wall.back().y());
  if (p.label) AddLabel(b, p.radius_m, body.label_low, body.label_high);
  return b.Finish();
}

// A drinking vessel.
struct CupParams {
  float height_m = 0.095f;
  float radius_m = 0.042f;
  int form = 0;  // 0 mug, 1 tea cup with saucer, 2 tumbler, 3 tapered.
  bool handle = true;
  uint64_t seed = 0;
};

Asset MakeCup(const CupParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  const MaterialSlot body =
      p.form == 2 ? Slot("body", {"glass", "ceramic", "plastic"}) : CeramicSlot("body");
  Path2 wall;
  float base = 0;
  switch (p.form) {
    case 0:
      wall =
          Filleted(Path2{{0.7f * r, 0}, {0.98f * r, 0.002f}, {r, 0.5f * h}, {r, h}}, 0.25f * r, 5);
      break;
    case 1:
      wall = Profile(
          {{0.5f, 0}, {0.52f, 0.05f}, {0.56f, 0.1f}, {0.84f, 0.38f}, {0.95f, 0.7f}, {1.06f, 1}}, r,
          h, 5);
      break;
    case 2:
      wall =
          Filleted(Path2{{0.5f * r, 0}, {0.84f * r, 0}, {0.9f * r, 0.4f * h}, {r, h}}, 0.006f, 3);
      break;
    default:
      wall = Profile({{0.62f, 0}, {0.66f, 0.03f}, {0.78f, 0.4f}, {0.9f, 0.8f}, {1, 1}}, r, h, 4);
  }
  if (p.form == 1) {
    // The saucer, with a well that holds the cup.
    const float sr = 1.75f * r;
    const Path2 saucer = Spline(Path2{{0.6f * r, 0},
                                      {0.62f * r, 0.003f},
                                      {0.75f * r, 0.005f},
                                      {1.3f * r, 0.012f},
                                      {sr, 0.02f}},
                                5);
    b.Add(Lathe(VesselProfile(WithFoot(saucer), 0.0032f, 0.005f)), body);
    base = 0.0051f;
  }
  b.Add(Lathe(VesselProfile(WithFoot(wall), p.form == 2 ? 0.0024f : 0.0034f,
                            p.form == 2 ? 0.008f : 0.005f),
              {.segments = 56})
            .Moved(0, 0, base),
        body);
  if (p.handle) {
    const float z0 = 0.24f * h, z1 = (p.form == 1 ? 0.86f : 0.82f) * h;
    const float x0 = RadiusAt(wall, z0), x1 = RadiusAt(wall, z1);
    b.Add(LoopHandle({x0, z0 + base, x1, z1 + base, p.form == 1 ? 0.5f * r : 0.62f * r,
                      p.form == 1 ? 0.007f : 0.0125f, 0.0075f}),
          body);
  }
  return b.Finish();
}

}  // namespace

Asset SampleVase(Rng& rng) {
  VaseParams p;
  p.form = rng.UniformInt(0, 5);
  p.height_m = Draw(rng, 0.16, 0.42);
  p.radius_m = p.height_m * (p.form == 5 ? Draw(rng, 0.42, 0.52) : Draw(rng, 0.22, 0.36));
  if (rng.Bernoulli(0.35)) p.flutes = rng.UniformInt(6, 16);
  p.twist_rad = rng.Bernoulli(0.5) ? Draw(rng, 0.2, 0.9) : 0.0f;
  p.handles = (p.form == 1 || p.form == 0) && p.flutes == 0 && rng.Bernoulli(0.4);
  p.seed = rng.Seed();
  return MakeVase(p);
}

Asset SampleBottle(Rng& rng) {
  BottleParams p{.form = rng.UniformInt(0, 5)};
  constexpr double kHeights[][2] = {{0.27, 0.34}, {0.27, 0.35}, {0.17, 0.28},
                                    {0.18, 0.33}, {0.12, 0.19}, {0.16, 0.27}};
  p.height_m = Draw(rng, kHeights[p.form][0], kHeights[p.form][1]);
  p.radius_m = p.height_m * (p.form >= 4 ? Draw(rng, 0.19, 0.26) : Draw(rng, 0.105, 0.15));
  p.shoulder = Draw(rng, -0.1, 0.08);
  p.neck = Draw(rng, 0.85, 1.25);
  p.square = rng.Bernoulli(0.25) ? Draw(rng, 0.7, 1.0) : 0.0f;
  p.label = p.square == 0 && rng.Bernoulli(0.85);
  if (p.form == 5) {
    p.radius_m = std::min(p.radius_m, 0.044f);
    p.square = Draw(rng, 0.0, 1.0);
    p.label = true;
  }
  p.seed = rng.Seed();
  return MakeBottle(p);
}

Asset SampleCup(Rng& rng) {
  CupParams p{.form = rng.UniformInt(0, 3)};
  p.height_m = p.form == 1 ? Draw(rng, 0.055, 0.07) : Draw(rng, 0.08, 0.13);
  p.radius_m = p.form == 1 ? Draw(rng, 0.042, 0.052) : Draw(rng, 0.036, 0.046);
  p.handle = p.form == 0 || p.form == 1 || (p.form == 3 && rng.Bernoulli(0.4));
  p.seed = rng.Seed();
  return MakeCup(p);
}

}  // namespace parallax
