#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/lamps/lamp_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Shape RoundFoot() {
  return Lathe(Spline(Path2{{0.14f, 0},
                            {0.143f, 0.006f},
                            {0.135f, 0.014f},
                            {0.08f, 0.026f},
                            {0.03f, 0.04f},
                            {0.016f, 0.07f},
                            {0.012f, 0.12f}},
                      5));
}

// A standing lamp.
struct FloorLampParams {
  float height_m = 1.6f;
  float shade_radius_m = 0.2f;
  ShadeStyle shade = ShadeStyle::kEmpire;
  // 0 straight pole, 1 turned column, 2 tripod, 3 arc, 4 uplighter, 5 paper lantern, 6 three
  // globes up a pole.
  int stand = 0;
  uint64_t seed = 0;
};

// A bowl on a pole that lights the ceiling.
void AddUplighter(AssetBuilder& b, const FloorLampParams& p) {
  const MaterialSlot body = LampBodySlot();
  const float r = p.shade_radius_m, bowl = 0.55f * r, z = p.height_m - bowl, t = 0.003f;
  b.Add(RoundFoot(), body);
  b.Add(Cylinder(0.011f, z - 0.06f, 0.002f).Moved(0, 0, 0.08f), body);
  Path2 outer;
  for (int k = 0; k <= 10; ++k) {
    const float a = 0.5f * kPi * static_cast<float>(k) / 10.0f;
    outer.emplace_back(std::max(0.05f, r * std::sin(a)), bowl * (1 - std::cos(a)));
  }
  Path2 section = outer;
  for (size_t i = outer.size(); i-- > 0;) section.emplace_back(outer[i].x() - t, outer[i].y() + t);
  b.Add(LinedShade(section, outer.size(), 56).Moved(0, 0, z),
        {Slot("shade", {"metal", "ceramic"}), EmissiveSlot("shade_inside")});
  b.Add(Cylinder(0.052f, 0.02f, 0.004f).Moved(0, 0, z - 0.012f), body);
  AddBulb(b, {0, 0, z + 0.006f}, false, 0.026f);
}

// Paper over a wooden frame, standing on the floor; the paper itself glows.
void AddLantern(AssetBuilder& b, const FloorLampParams& p) {
  const MaterialSlot wood = Slot("body", {"wood", "metal"});
  const float half = 0.9f * p.shade_radius_m, h = 0.95f * p.height_m, post = 0.011f, foot = 0.05f;
  const int bars = 2 + static_cast<int>(p.seed % 4);
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      b.Add(Board({sx * half - post, sy * half - post, 0}, {sx * half + post, sy * half + post, h},
                  0.003f),
            wood);
    }
  }
  for (int k = 0; k <= bars; ++k) {
    const float z = Lerp(foot, h - 0.03f, static_cast<float>(k) / static_cast<float>(bars));
    for (const float s : {-1.0f, 1.0f}) {
      b.Add(Board({-half, s * half - 0.008f, z}, {half, s * half + 0.008f, z + 0.018f}, 0.002f),
            wood);
      b.Add(Board({s * half - 0.0075f, -half, z + 0.0005f}, {s * half + 0.0075f, half, z + 0.0175f},
                  0.002f),
            wood);
    }
  }
  const float in = half - 0.004f;
  b.Add(LatheRing({{1.4142f * in - 0.0015f, foot + 0.004f},
                   {1.4142f * in, foot + 0.004f},
                   {1.4142f * in, h - 0.016f},
                   {1.4142f * in - 0.0015f, h - 0.016f}},
                  4)
            .TurnedZ(0.25f * kPi),
        EmissiveSlot("shade_inside"));
}

// Globes on short arms at three heights.
void AddGlobes(AssetBuilder& b, const FloorLampParams& p) {
  const MaterialSlot body = LampBodySlot();
  b.Add(RoundFoot(), body);
  b.Add(Cylinder(0.012f, p.height_m - 0.08f, 0.005f).Moved(0, 0, 0.08f), body);
  for (int k = 0; k < 3; ++k) {
    const float a = 2.1f * static_cast<float>(k) + static_cast<float>(p.seed % 7),
                z = p.height_m * (0.62f + 0.16f * static_cast<float>(k));
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float r = 0.42f * p.shade_radius_m, reach = r + 0.05f;
    const Vec3f end = Vec3f(0, 0, z + 0.03f) + reach * out;
    b.Add(Tube(Spline(Path3{Vec3f(0, 0, z), Vec3f(0, 0, z) + 0.6f * reach * out, end}, 5), 0.006f,
               0.001f, 12),
          body);
    b.Add(Cylinder(0.028f, 0.02f, 0.003f).Moved(end - Vec3f(0, 0, 0.006f)), body);
    b.Add(Ball(r, 28).Moved(end + Vec3f(0, 0, r + 0.006f)), EmissiveSlot("bulb"));
  }
}

// A heavy foot, an arc, the shade hanging from its end.
void AddArcLamp(AssetBuilder& b, const FloorLampParams& p) {
  b.Add(Lathe(Filleted(Path2{{0, 0}, {0.17f, 0}, {0.17f, 0.045f}, {0.02f, 0.05f}, {0, 0.05f}},
                       0.006f, 4)),
        Slot("foot", {"stone", "metal"}));
  const float r = p.shade_radius_m, reach = 0.85f, top = p.height_m;
  const Path3 arc = Spline(Path3{{0, 0, 0.04f},
                                 {0, 0, 0.5f * top},
                                 {0.05f, 0, 0.8f * top},
                                 {0.3f * reach, 0, 0.965f * top},
                                 {0.65f * reach, 0, top},
                                 {0.9f * reach, 0, 0.95f * top},
                                 {reach, 0, 0.86f * top}},
                           8);
  b.Add(Tube(arc, 0.011f, 0, 14), MetalSlot("body"));
  b.Add(Tube({{reach, 0, 0.865f * top}, {reach, 0, 0.8f * top}}, 0.003f, 0, 8),
        Slot("cord", {"HousingPlastic", "fabric"}));
  const float hh = 0.7f * r;
  AddShade(b, ShadeStyle::kDome, r, hh, {reach, 0, 0.8f * top - hh}, false);
  b.Add(Cylinder(0.22f * r, 0.02f, 0.003f).Moved(reach, 0, 0.8f * top - 0.03f * r - 0.012f),
        MetalSlot("body"));
  AddBulb(b, {reach, 0, 0.8f * top - 0.02f}, true);
}

// Three legs with braces to their middle; a stem carries the bulb at height `neck`.
void AddTripod(AssetBuilder& b, float shade_z, float neck) {
  const float join = 0.62f * shade_z;
  for (int k = 0; k < 3; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 3.0f + 0.5f * kPi;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const Vec3f foot = 0.27f * out, head = Vec3f(0, 0, shade_z - 0.05f) + 0.03f * out;
    b.Add(Rod(foot, head, 0.011f, 0.017f, 0.004f), Slot("body", {"wood", "metal"}));
    const Vec3f brace = foot + (head - foot) * (join / head.z()) * 0.6f;
    b.Add(Rod(brace, Vec3f(0, 0, brace.z()), 0.005f, 0.005f), MetalSlot("socket"));
  }
  b.Add(Cylinder(0.05f, 0.05f, 0.005f).Moved(0, 0, shade_z - 0.075f), MetalSlot("socket"));
  b.Add(Cylinder(0.008f, neck - shade_z + 0.06f, 0.001f).Moved(0, 0, shade_z - 0.05f),
        MetalSlot("socket"));
}

void AddTurnedColumn(AssetBuilder& b, const FloorLampParams& p, float neck) {
  b.Add(RoundFoot(), LampBodySlot());
  const float column = neck - 0.1f;
  b.Add(TurnedLeg(column, 0.03f, static_cast<int>(p.seed % 4)).Moved(0, 0, 0.05f),
        Slot("body", {"wood", "metal"}));
  b.Add(Cylinder(0.007f, 0.1f, 0.001f).Moved(0, 0, column), MetalSlot("socket"));
}

// A straight pole, every second with a small tray table half-way.
void AddPole(AssetBuilder& b, const FloorLampParams& p, float neck) {
  const MaterialSlot body = LampBodySlot();
  b.Add(RoundFoot(), body);
  b.Add(Cylinder(0.011f, neck - 0.08f, 0.002f).Moved(0, 0, 0.08f), body);
  if (p.seed % 2 != 0) return;
  b.Add(Lathe(VesselProfile(Filleted(Path2{{0, 0}, {0.16f, 0}, {0.165f, 0.018f}}, 0.008f, 3),
                            0.003f, 0.004f))
            .Moved(0, 0, 0.52f),
        body);
  b.Add(Cylinder(0.02f, 0.02f, 0.003f).Moved(0, 0, 0.505f), body);
}

// The support of the shade: a harp over the bulb, up to `top`.
void AddHarp(AssetBuilder& b, float neck, float top) {
  for (const float s : {1.0f, -1.0f}) {
    b.Add(Tube(Spline(Path3{{s * 0.02f, 0, neck + 0.012f},
                            {s * 0.05f, 0, neck + 0.06f},
                            {s * 0.035f, 0, 0.5f * (neck + 0.06f + top)},
                            {0, 0, top - 0.012f}},
                      5),
               0.002f, 0, 8),
          MetalSlot("socket"));
  }
}

float ShadeHeight(const FloorLampParams& p) {
  const float r = p.shade_radius_m;
  if (p.shade == ShadeStyle::kDome) return 0.75f * r;
  if (p.shade == ShadeStyle::kGlobe) return 1.6f * r;
  return Lerp(1.1f, 1.5f, static_cast<float>(p.seed % 16) / 15.0f) * r;
}

// A stand under a shade with its bulb, and now and then a pull chain.
void AddShadedLamp(AssetBuilder& b, const FloorLampParams& p) {
  const float sh = ShadeHeight(p), shade_z = p.height_m - sh, neck = shade_z + 0.4f * sh;
  if (p.stand == 2) {
    AddTripod(b, shade_z, neck);
  } else if (p.stand == 1) {
    AddTurnedColumn(b, p, neck);
  } else {
    AddPole(b, p, neck);
  }
  AddBulb(b, {0, 0, neck}, false, 0.03f);
  AddShade(b, p.shade, p.shade_radius_m, sh, {0, 0, shade_z});
  AddHarp(b, neck, p.height_m);
  if (p.seed % 3 == 0)
    b.Add(Tube({{0.03f, 0.03f, neck}, {0.03f, 0.03f, shade_z - 0.08f}}, 0.0012f, 0, 6),
          MetalSlot("socket"));
}

Asset MakeFloorLamp(const FloorLampParams& p) {
  constexpr void (*kStands[])(AssetBuilder&, const FloorLampParams&) = {
      AddShadedLamp, AddShadedLamp, AddShadedLamp, AddArcLamp, AddUplighter, AddLantern, AddGlobes};
  AssetBuilder b(p.seed);
  kStands[p.stand](b, p);
  return b.Finish();
}

}  // namespace

Asset SampleFloorLamp(Rng& rng) {
  FloorLampParams p{.height_m = Draw(rng, 1.4, 1.8), .shade_radius_m = Draw(rng, 0.16, 0.25)};
  const ShadeStyle shades[] = {ShadeStyle::kDrum, ShadeStyle::kEmpire, ShadeStyle::kPleated};
  p.shade = shades[rng.UniformInt(0, 2)];
  p.stand = rng.UniformInt(0, 6);
  if (p.stand == 3) p.height_m = Draw(rng, 1.8, 2.1);
  p.seed = rng.Seed();
  return MakeFloorLamp(p);
}

}  // namespace parallax
