#include <algorithm>
#include <cmath>

#include "worker/assets/tableware.h"
#include "worker/assets/vessel_parts.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Asset MakeVase(const VaseParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  Path2 wall;
  switch (p.form % 6) {
    case 0:
      wall = Profile({{0.5f, 0},
                      {0.62f, 0.04f},
                      {1, 0.3f},
                      {0.86f, 0.52f},
                      {0.3f, 0.72f},
                      {0.26f, 0.9f},
                      {0.36f, 1}},
                     r, h, 7);
      break;
    case 1:
      wall = Profile({{0.42f, 0},
                      {0.46f, 0.03f},
                      {0.8f, 0.35f},
                      {1, 0.62f},
                      {0.8f, 0.8f},
                      {0.46f, 0.88f},
                      {0.48f, 0.95f},
                      {0.6f, 1}},
                     r, h, 7);
      break;
    case 2:
      wall = Profile({{0.55f, 0},
                      {0.6f, 0.02f},
                      {0.38f, 0.12f},
                      {0.36f, 0.3f},
                      {0.5f, 0.62f},
                      {0.78f, 0.9f},
                      {1, 1}},
                     r, h, 7);
      break;
    case 3:
      wall = Profile({{0.6f, 0},
                      {0.72f, 0.03f},
                      {1, 0.24f},
                      {0.72f, 0.46f},
                      {0.4f, 0.56f},
                      {0.55f, 0.72f},
                      {0.5f, 0.84f},
                      {0.28f, 0.94f},
                      {0.34f, 1}},
                     r, h, 7);
      break;
    case 4:
      wall =
          Profile({{0.86f, 0}, {0.95f, 0.02f}, {1, 0.3f}, {0.98f, 0.7f}, {0.92f, 0.9f}, {0.94f, 1}},
                  r, h, 5);
      break;
    default:
      wall = Profile({{0.4f, 0},
                      {0.5f, 0.02f},
                      {0.9f, 0.2f},
                      {1, 0.46f},
                      {0.86f, 0.74f},
                      {0.5f, 0.9f},
                      {0.42f, 0.95f},
                      {0.48f, 1}},
                     r, h, 7);
  }
  LatheOptions options;
  options.segments = p.flutes > 0 ? 96 : 64;
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

Asset MakeBottle(const BottleParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  Path2 wall;
  float label0 = 0.16f, label1 = 0.48f;  // Of the height: the straight part.
  const auto straight = [&](float z0, float z1) {
    wall.emplace_back(0.93f * r, 0.0f);
    wall.emplace_back(0.99f * r, 0.004f);
    wall.emplace_back(r, 0.012f);
    wall.emplace_back(r, z0 * h);
    wall.emplace_back(r, z1 * h);
  };
  const auto on = [&](std::initializer_list<std::pair<float, float>> shares, int steps) {
    Path2 rest{wall.back()};
    for (const auto& [rr, z] : shares) rest.emplace_back(rr * r, z * h);
    rest = Spline(rest, steps);
    wall.insert(wall.end(), rest.begin() + 1, rest.end());
  };
  const float neck = 0.0145f / r;
  switch (p.form) {
    case 0:
      label1 = 0.52f;
      straight(label0, label1);
      on({{1, 0.6f}, {0.86f, 0.665f}, {0.5f, 0.71f}, {neck, 0.77f}, {0.97f * neck, 0.93f}}, 5);
      break;
    case 1:
      label1 = 0.42f;
      straight(label0, label1);
      on({{0.97f, 0.5f}, {0.76f, 0.62f}, {0.5f, 0.74f}, {neck, 0.84f}, {0.97f * neck, 0.94f}}, 6);
      break;
    case 2:
      label1 = 0.52f;
      straight(label0, label1);
      on({{0.98f, 0.58f}, {0.72f, 0.68f}, {0.5f, 0.8f}, {0.42f, 0.94f}}, 6);
      break;
    default:
      label0 = 0.3f;
      label1 = 0.55f;
      straight(label0, label1);
      on({{0.98f, 0.62f}, {0.8f, 0.74f}, {0.5f, 0.86f}, {0.42f, 0.95f}}, 6);
  }
  // Lip.
  const float nr = wall.back().x(), z = wall.back().y();
  for (const auto& [dr, dz] :
       {std::pair{0.0022f, 0.001f}, {0.0028f, 0.006f}, {0.0022f, 0.01f}, {0.0002f, 0.011f}})
    wall.emplace_back(nr + dr, z + dz);
  wall.emplace_back(nr, h);
  const bool plastic = p.form == 3;
  LatheOptions options;
  options.segments = 48;
  if (plastic) {
    options.modulate = [&](float a, float zz) {
      (void)a;
      const float t = zz / h;
      return t < 0.28f && t > 0.05f ? 1 - 0.025f * (0.5f + 0.5f * std::cos(2 * kPi * t * 26))
                                    : 1.0f;
    };
    Path2 dense;
    for (size_t i = 0; i < wall.size(); ++i) {
      dense.push_back(wall[i]);
      if (i + 1 < wall.size() && wall[i].y() < 0.27f * h && wall[i + 1].y() - wall[i].y() > 0.02f) {
        for (int k = 1; k < 40; ++k)
          dense.push_back(wall[i] + (wall[i + 1] - wall[i]) * (static_cast<float>(k) / 40.0f));
      }
    }
    wall = dense;
  }
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.0028f, 0.006f), options),
        plastic ? Slot("body", {"plastic", "glass"}) : GlassSlot("body"));
  // Closure: cork, foil capsule or cap, standing on the lip.
  if (p.form <= 1) {
    b.Add(Cylinder(nr - 0.0022f, 0.03f, 0.001f, 20).Moved(0, 0, h - 0.016f),
          Slot("cork", {"wood", "bark", "plastic"}));
    b.Add(LatheRing({{nr + 0.0002f, 0.8f * h},
                     {nr + 0.0032f, 0.8f * h},
                     {nr + 0.0034f, h - 0.001f},
                     {nr + 0.0002f, h - 0.001f}},
                    32),
          Slot("foil", {"metal", "paper"}));
  } else {
    LatheOptions ribs;
    ribs.segments = p.form == 2 ? 63 : 72;
    ribs.modulate = [&](float a, float zz) {
      return zz < 0.006f ? 1 + 0.03f * std::cos((p.form == 2 ? 21.0f : 36.0f) * a) : 1.0f;
    };
    const float cr = nr + 0.0035f, ch = p.form == 2 ? 0.008f : 0.016f;
    b.Add(Lathe(Filleted(Path2{{0, 0}, {cr, 0}, {cr, 0.5f * ch}, {cr, ch}, {0, ch}}, 0.0015f, 3),
                ribs)
              .Moved(0, 0, h - 0.5f * ch),
          Slot("cap", {"metal", "plastic"}));
  }
  if (p.label) {
    // A paper band just off the glass.
    LatheOptions band;
    band.segments = 48;
    Shape label = LatheRing({{r - 0.0003f, label0 * h + 0.004f},
                             {r + 0.0004f, label0 * h + 0.004f},
                             {r + 0.0004f, label1 * h - 0.003f},
                             {r - 0.0003f, label1 * h - 0.003f}},
                            48);
    const size_t n = 48;
    for (size_t s = 0; s < n; ++s) {
      Face& f = label.faces[n + s];  // The outer wall.
      f.group = 1;
      const float u0 = static_cast<float>(s) / n, u1 = static_cast<float>(s + 1) / n;
      f.uv = {Vec2f(u0, 0), Vec2f(u1, 0), Vec2f(u1, 1), Vec2f(u0, 1)};
    }
    b.Add(label, {Slot("label_edge", {"paper"}), PictureSlot("label")});
  }
  return b.Finish();
}

Asset SampleBottle(Rng& rng) {
  BottleParams p;
  p.form = rng.UniformInt(0, 3);
  p.height_m = p.form <= 1 ? Draw(rng, 0.28, 0.33)
                           : (p.form == 2 ? Draw(rng, 0.19, 0.26) : Draw(rng, 0.2, 0.32));
  p.radius_m = p.height_m * Draw(rng, 0.118, 0.14);
  p.label = rng.Bernoulli(0.85);
  p.seed = rng.Seed();
  return MakeBottle(p);
}

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

Asset SampleCup(Rng& rng) {
  CupParams p;
  p.form = rng.UniformInt(0, 3);
  p.height_m = p.form == 1 ? Draw(rng, 0.055, 0.07) : Draw(rng, 0.08, 0.13);
  p.radius_m = p.form == 1 ? Draw(rng, 0.042, 0.052) : Draw(rng, 0.036, 0.046);
  p.handle = p.form == 0 || p.form == 1 || (p.form == 3 && rng.Bernoulli(0.4));
  p.seed = rng.Seed();
  return MakeCup(p);
}

}  // namespace parallax
