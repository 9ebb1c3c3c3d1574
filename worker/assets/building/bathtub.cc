#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/basin.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

enum class BathtubStyle { kFreestanding, kClawFoot, kBuiltIn, kCount };

// A bathtub, with or without a tap.
struct BathtubParams {
  BathtubStyle style = BathtubStyle::kFreestanding;
  float length_m = 1.65f;
  float width_m = 0.75f;
  float height_m = 0.58f;
  float squareness = 2.8f;
  float slope = 0.25f;  // Slope of the end to lie against; the other walls are steeper.
  float slipper_m = 0;  // How far the head's end rises above the rim.
  bool tap = true;
  uint64_t seed = 0;
};

// Dimensions that the parts of a bathtub share: half length and width, height of the foot, of the
// body above it, and of the floor inside; width of the rim.
struct Tub {
  explicit Tub(const BathtubParams& params)
      : p(params),
        claw(params.style == BathtubStyle::kClawFoot),
        built(params.style == BathtubStyle::kBuiltIn),
        l(0.5f * params.length_m),
        w(0.5f * params.width_m),
        foot(claw    ? 0.12f
             : built ? 0.05f
                     : 0.0f),
        h(params.height_m - foot),
        rim(built ? 0.075f : 0.028f),
        floor(foot + 0.05f) {}

  // The wall at a share of the height: one end slopes to lie against, the other holds the drain.
  BasinLevel Wall(float share, float inset, float sharpness = 0) const {
    const float down = p.slope * (1 - share);
    const float x = l - inset, y = w - inset;
    return BasinLevel{{-x * (1 - down), -y * (1 - 0.5f * down)},
                      {x * (1 - 0.35f * down), y * (1 - 0.5f * down)},
                      foot + share * h,
                      p.squareness,
                      sharpness};
  }

  const BathtubParams& p;
  const bool claw, built;
  const float l, w, foot, h, rim, floor;
};

BasinLevel AtHeight(BasinLevel level, float z) {
  level.z = z;
  return level;
}

// An apron with a recess for the toes; its top is a deck as wide as a hand.
std::vector<BasinLevel> ApronLevels(const Tub& t) {
  const auto apron = [&](float inset, float z, float sharpness) {
    return BasinLevel{{-t.l + inset, -t.w + inset}, {t.l - inset, t.w - inset}, z, 0, sharpness, 3};
  };
  return {apron(0.02f, 0, 3), apron(0.02f, 0.06f, 3), apron(0, 0.065f, 3),
          apron(0, t.p.height_m, 2), AtHeight(t.Wall(1, 0.045f), t.p.height_m)};
}

// A free-standing body with a rolled rim.
std::vector<BasinLevel> RolledLevels(const Tub& t) {
  return {t.Wall(0, 0.12f),
          t.Wall(0, 0.03f, 1),
          t.Wall(0.45f, 0.025f),
          t.Wall(0.88f, 0.022f),
          AtHeight(t.Wall(1, 0.016f), t.foot + 0.94f * t.h),
          AtHeight(t.Wall(1, -0.002f), t.foot + 0.965f * t.h),
          t.Wall(1, 0.002f)};
}

// From the rim down to the drain.
std::vector<BasinLevel> InsideLevels(const Tub& t) {
  const float rim = t.rim, floor = t.floor;
  return {t.Wall(1, rim),
          AtHeight(t.Wall(1, rim + 0.014f), t.foot + 0.95f * t.h),
          t.Wall(0.5f, rim + 0.022f),
          AtHeight(t.Wall(0.1f, rim + 0.04f), floor + 0.05f),
          AtHeight(t.Wall(0, rim + 0.1f), floor),
          AtHeight(t.Wall(0, rim + 0.14f), floor),
          AtHeight(t.Wall(0, rim + 0.2f), floor)};
}

// The body, one end of which rises where it is a slipper, and its drain.
void AddTub(AssetBuilder& b, const Tub& t) {
  std::vector<BasinLevel> levels = t.built ? ApronLevels(t) : RolledLevels(t);
  const std::vector<BasinLevel> inside = InsideLevels(t);
  levels.insert(levels.end(), inside.begin(), inside.end());
  const auto raise = [&](const Vec3f& q) {
    const float up = std::clamp((q.z() - t.foot) / t.h, 0.0f, 1.0f);
    return Vec3f(q.x(), q.y(), q.z() + t.p.slipper_m * up * up * Smooth01(-0.15f - q.x() / t.l));
  };
  b.Add(Basin(levels).Bent(raise), Slot("tub", {"SanitaryCeramic", "Marble", "GlazedCeramic"}));
  AddDrain(b, {0.8f * levels.back().high.x(), 0, t.floor + 0.0005f}, 0.03f);
}

// Four claws that hold balls.
void AddClawFeet(AssetBuilder& b, const Tub& t) {
  const MaterialSlot metal = Slot("feet", {"metal"});
  const float low = 1.0f - t.p.slope;
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const Vec3f out(sx * 0.62f * t.l * low, sy * 0.62f * t.w * low, 0);
      b.Add(Ball(0.03f, 20).Moved(out + Vec3f(sx * 0.03f, sy * 0.03f, 0.03f)), metal);
      b.Add(
          Sweep(Spline(Path3{out + Vec3f(sx * 0.03f, sy * 0.03f, 0.035f),
                             out + Vec3f(sx * 0.055f, sy * 0.055f, 0.08f),
                             out + Vec3f(sx * 0.03f, sy * 0.03f, 0.13f), out + Vec3f(0, 0, 0.165f)},
                       5),
                EllipseSection(0.05f, 0.04f, 14), {}),
          metal);
    }
  }
}

// On the deck of a built-in tub, else on two risers behind it.
void AddTubTap(AssetBuilder& b, const Tub& t) {
  TapParams tap;
  tap.style = TapStyle::kBridge;
  tap.height_m = 0.16f;
  tap.reach_m = t.built ? 0.15f : 0.2f;
  tap.pipe_m = 0.012f;
  tap.two_handles = true;
  tap.cross_handles = true;
  if (t.built) return AddTap(b, tap, {0, -t.w + 0.045f, t.p.height_m - 0.003f});
  const float y = -t.w - 0.07f;
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Rod({s * 0.09f, y, 0}, {s * 0.09f, y, t.p.height_m + 0.05f}, 0.012f, 0.012f),
          ChromeSlot());
    b.Add(Cone(0.03f, 0.02f, 0.01f, 0.002f).Moved(s * 0.09f, y, 0), ChromeSlot());
  }
  AddTap(b, tap, {0, y, t.p.height_m + 0.045f});
}

Asset MakeBathtub(const BathtubParams& p) {
  AssetBuilder b(p.seed);
  const Tub tub(p);
  AddTub(b, tub);
  if (tub.claw) AddClawFeet(b, tub);
  if (p.tap) AddTubTap(b, tub);
  return b.Finish();
}

}  // namespace

Asset SampleBathtub(Rng& rng) {
  BathtubParams p;
  p.style = DrawEnum<BathtubStyle>(rng, static_cast<int>(BathtubStyle::kCount));
  p.length_m = Draw(rng, 1.45, 1.8);
  p.width_m = Draw(rng, 0.7, 0.85);
  p.height_m = Draw(rng, 0.52, 0.64);
  p.squareness = p.style == BathtubStyle::kBuiltIn ? Draw(rng, 3.0, 6.0) : Draw(rng, 2.2, 3.6);
  p.slope = Draw(rng, 0.16, 0.36);
  p.tap = rng.Bernoulli(0.7);
  if (p.style != BathtubStyle::kBuiltIn && rng.Bernoulli(0.4)) p.slipper_m = Draw(rng, 0.08, 0.16);
  p.seed = rng.Seed();
  return MakeBathtub(p);
}

}  // namespace parallax
