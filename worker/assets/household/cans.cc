#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/household/vessel_parts.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

const MaterialSlot& Tinplate() {
  static const MaterialSlot& slot = *new MaterialSlot(Slot("metal", {"metal"}));
  return slot;
}

// A ring to pull on a lid whose top is at z, and its rivet.
Shape RingPull(float z, float lift_rad) {
  Path3 ring;
  for (int k = 0; k < 20; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 20.0f;
    ring.emplace_back(0.008f * std::cos(a), 0.0105f * std::sin(a) + 0.0105f, 0);
  }
  Shape out = Ring(ring, 0.0013f, 8).TurnedX(lift_rad).Moved(0, -0.0065f, z + 0.0012f);
  out.Add(Cylinder(0.003f, 0.0026f, 0.0006f, 12).Moved(0, -0.0065f, z - 0.0012f));
  return out;
}

// Aluminium, necked in at both ends.
Path2 DrinkProfile(float r, float h, float p0, float p1) {
  return {{0, 0.006f},
          {0.5f * r, 0.005f},
          {0.7f * r, 0.001f},
          {0.74f * r, 0},
          {0.78f * r, 0.001f},
          {0.96f * r, 0.008f},
          {r, p0},
          {r, p1},
          {0.97f * r, h - 0.011f},
          {0.82f * r, h - 0.003f},
          {0.83f * r, h - 0.001f},
          {0.81f * r, h},
          {0.78f * r, h - 0.001f},
          {0.77f * r, h - 0.006f},
          {0, h - 0.0062f}};
}

// Tinplate: seamed rims, beads round the body.
Path2 TinProfile(float r, float h, float p0, float p1, int beads, bool open) {
  Path2 profile{{0, 0.003f},           {r - 0.002f, 0.003f}, {r - 0.001f, 0}, {r + 0.001f, 0.0005f},
                {r + 0.0012f, 0.003f}, {r, 0.0045f},         {r, p0}};
  for (int k = 1; k <= 6 * beads; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(6 * beads);
    const float wave = 0.5f - 0.5f * std::cos(2 * kPi * s * static_cast<float>(beads));
    profile.emplace_back(r - 0.0007f * wave, Lerp(p0, p1, s));
  }
  if (beads == 0) profile.emplace_back(r, p1);
  for (const Vec2f& q : Path2{{r, h - 0.0045f},
                              {r + 0.0012f, h - 0.003f},
                              {r + 0.001f, h - 0.0005f},
                              {r - 0.001f, h},
                              {r - 0.002f, h - 0.003f}})
    profile.push_back(q);
  if (open) {
    profile.emplace_back(r - 0.002f, 0.7f * h);
    profile.emplace_back(0, 0.7f * h);
  } else {
    profile.emplace_back(0.8f * r, h - 0.0032f);
    profile.emplace_back(0.76f * r, h - 0.002f);
    profile.emplace_back(0, h - 0.0021f);
  }
  return profile;
}

// The lid of an opened tin, held by the last bit of its seam at the back.
Shape BentLid(float r, float h) {
  const Shape lid = Lathe(Path2{{0, 0},
                                {0.74f * r, 0},
                                {0.8f * r, -0.001f},
                                {0.95f * r, 0},
                                {0.96f * r, 0.0006f},
                                {0.8f * r, -0.0002f},
                                {0.74f * r, 0.0008f},
                                {0, 0.0008f}});
  return lid
      .Bent([&](const Vec3f& q) {
        const float s = (q.y() + r) / (2 * r);
        return Vec3f(q.x(), q.y(), q.z() + 0.12f * r * std::sin(kPi * s));
      })
      .Moved(0, 0.97f * r, 0)
      .TurnedX(1.1f)
      .Moved(0, -0.97f * r, h - 0.0015f);
}

enum class CanStyle { kDrink, kSlimDrink, kTin, kFlatTin, kFishTin, kSpray, kCount };

// A can or tin.
struct CanParams {
  CanStyle style = CanStyle::kDrink;
  float radius_m = 0.033f;  // Half of the width for the fish tin.
  float height_m = 0.12f;
  bool opened = false;  // A tin's lid bent up, a drink's tab raised.
  uint64_t seed = 0;
};

void AddFishTin(AssetBuilder& b, const CanParams& p) {
  const float w = 2 * p.radius_m, d = 0.62f * w, h = p.height_m;
  Shape body = Extrude(RectSection(w, d, 0.3f * d, 8), h - 0.002f, 0.002f).Moved(0, 0, 0.001f);
  PrintFaces(body, Vec3f::UnitZ(), Vec3f::UnitX(), Vec3f::UnitY(), 1);
  b.Add(body, {Tinplate(), PictureSlot("label")});
  for (const float z : {0.0015f, h - 0.0015f}) {
    Path3 seam;
    for (const Vec2f& q : RectSection(w, d, 0.3f * d, 8)) seam.emplace_back(q.x(), q.y(), z);
    b.Add(Ring(seam, 0.0015f, 8), Tinplate());
  }
  b.Add(RingPull(h + 0.0003f, p.opened ? 0.9f : 0.12f).TurnedZ(-0.5f * kPi).Moved(0.34f * w, 0, 0),
        Tinplate());
}

void AddSprayCan(AssetBuilder& b, const CanParams& p) {
  const float r = p.radius_m, h = p.height_m, p0 = 0.006f, p1 = 0.72f * h;
  const Path2 profile{{0, 0.008f},
                      {0.8f * r, 0.003f},
                      {r - 0.001f, 0},
                      {r + 0.0012f, 0.002f},
                      {r, p0},
                      {r, p1},
                      {r + 0.001f, p1 + 0.001f},
                      {0.99f * r, p1 + 0.003f},
                      {0.62f * r, p1 + 0.016f},
                      {0.6f * r, p1 + 0.02f},
                      {0, p1 + 0.02f}};
  b.Add(Lathe(profile, {.segments = 56,
                        .print_from_z = p0,
                        .print_to_z = p1,
                        .print_repeats = LabelCopies(r, p1 - p0)}),
        {Tinplate(), PictureSlot("label")});
  const MaterialSlot plastic = PlasticSlot("cap");
  if (p.opened) {
    // The nozzle.
    b.Add(Cylinder(0.0045f, 0.02f, 0.001f).Moved(0, 0, p1 + 0.016f), Tinplate());
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.008f, 0}, {0.0075f, 0.014f}, {0, 0.016f}}, 0.002f, 3))
              .Moved(0, 0, p1 + 0.026f),
          plastic);
    b.Add(Rod({0, 0.004f, p1 + 0.034f}, {0, 0.0095f, p1 + 0.034f}, 0.002f, 0.0015f), plastic);
  } else {
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.9f * r, 0}, {0.86f * r, h - p1 - 0.004f}, {0, h - p1}},
                         0.006f, 5))
              .Moved(0, 0, p1 + 0.0045f),
          plastic);
  }
}

Asset MakeCan(const CanParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  if (p.style == CanStyle::kFishTin) {
    AddFishTin(b, p);
    return b.Finish();
  }
  if (p.style == CanStyle::kSpray) {
    AddSprayCan(b, p);
    return b.Finish();
  }
  const bool drink = p.style == CanStyle::kDrink || p.style == CanStyle::kSlimDrink;
  LatheOptions options;
  options.segments = 56;
  options.print_from_z = drink ? 0.012f : 0.006f;
  options.print_to_z = drink ? h - 0.016f : h - 0.006f;
  options.print_repeats = LabelCopies(r, options.print_to_z - options.print_from_z);
  const int beads = p.style == CanStyle::kFlatTin ? 0 : 9;
  const Path2 profile =
      drink ? DrinkProfile(r, h, options.print_from_z, options.print_to_z)
            : TinProfile(r, h, options.print_from_z, options.print_to_z, beads, p.opened);
  b.Add(Lathe(profile, options), {Tinplate(), PictureSlot("label")});
  if (drink) {
    b.Add(RingPull(h - 0.006f, p.opened ? 1.1f : 0.05f), Tinplate());
  } else if (p.opened) {
    b.Add(BentLid(r, h), Tinplate());
  } else {
    b.Add(RingPull(h - 0.0018f, 0.06f), Tinplate());
  }
  return b.Finish();
}

}  // namespace

Asset SampleCan(Rng& rng) {
  CanParams p{.style = DrawEnum<CanStyle>(rng, static_cast<int>(CanStyle::kCount))};
  switch (p.style) {
    case CanStyle::kDrink:
      p.height_m = Draw(rng, 0.098, 0.165);
      break;
    case CanStyle::kSlimDrink:
      p.radius_m = Draw(rng, 0.0265, 0.03);
      p.height_m = Draw(rng, 0.125, 0.158);
      break;
    case CanStyle::kTin:
      p.radius_m = Draw(rng, 0.034, 0.052);
      p.height_m = p.radius_m * Draw(rng, 1.7, 2.9);
      break;
    case CanStyle::kFlatTin:
      p.radius_m = Draw(rng, 0.037, 0.055);
      p.height_m = Draw(rng, 0.034, 0.056);
      break;
    case CanStyle::kFishTin:
      p.radius_m = Draw(rng, 0.05, 0.058);
      p.height_m = Draw(rng, 0.022, 0.032);
      break;
    default:
      p.radius_m = Draw(rng, 0.024, 0.034);
      p.height_m = Draw(rng, 0.15, 0.22);
  }
  p.opened = rng.Bernoulli(0.3);
  p.seed = rng.Seed();
  return MakeCan(p);
}

}  // namespace parallax
