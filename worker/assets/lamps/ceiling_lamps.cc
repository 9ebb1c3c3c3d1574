#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/lamps/lamp_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Half of a bowl that hangs below the ceiling.
Path2 CeilingBowlProfile(float r) {
  Path2 bowl;
  for (int k = 0; k <= 16; ++k) {
    const float a = 0.5f * kPi * static_cast<float>(k) / 16.0f;
    bowl.emplace_back(r * std::sin(a), -0.028f - 0.42f * r * std::cos(a));
  }
  bowl.front().x() = 0;
  return bowl;
}

// A lamp that hangs from the ceiling.
struct CeilingLampParams {
  float drop_m = 0.7f;  // Ceiling to the lamp's underside.
  float radius_m = 0.22f;
  // 0 dome pendant, 1 drum pendant, 2 globe, 3 chandelier, 4 bowl close to the ceiling.
  int style = 0;
  int arms = 5;  // Arms of a chandelier.
  uint64_t seed = 0;
};

// A glass bowl held by a plate at the ceiling, with a finial under its middle.
void AddCeilingBowl(AssetBuilder& b, const CeilingLampParams& p) {
  const MaterialSlot metal = MetalSlot("metal");
  const float r = p.radius_m;
  b.Add(Lathe(Filleted(
            Path2{{0, -0.035f}, {0.9f * r, -0.035f}, {r + 0.01f, -0.02f}, {r + 0.012f, 0}, {0, 0}},
            0.006f, 3)),
        metal);
  b.Add(Lathe(CeilingBowlProfile(r)), EmissiveSlot("bulb"));
  b.Add(Lathe(Spline(Path2{{0.001f, -0.026f},
                           {0.006f, -0.022f},
                           {0.009f, -0.012f},
                           {0.016f, -0.004f},
                           {0.014f, 0.004f}},
                     4))
            .Moved(0, 0, -0.028f - 0.42f * r),
        metal);
  for (int k = 0; k < 3; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 3.0f;
    b.Add(Ball(0.009f, 12).Moved((r + 0.006f) * std::cos(a), (r + 0.006f) * std::sin(a), -0.03f),
          metal);
  }
}

// The rose at the ceiling, and the cord or rod from it down to `to`.
void AddSuspension(AssetBuilder& b, const CeilingLampParams& p, float to) {
  const MaterialSlot metal = MetalSlot("metal");
  b.Add(
      Lathe(Spline(
          Path2{{0.008f, -0.05f}, {0.02f, -0.04f}, {0.045f, -0.03f}, {0.058f, -0.012f}, {0.06f, 0}},
          4)),
      metal);
  const bool rod = p.style == 3 || p.seed % 2 == 0;
  b.Add(Tube({{0, 0, -0.03f}, {0, 0, to}}, rod ? 0.006f : 0.0028f, 0, 10),
        rod ? metal : Slot("cord", {"HousingPlastic", "fabric"}));
}

// An arm along `out` from the hub at height `hub`, with a candle that glows.
void AddChandelierArm(AssetBuilder& b, const Vec3f& out, float reach, float hub) {
  const MaterialSlot metal = MetalSlot("metal");
  const auto at = [&](float x, float z) { return Vec3f(x * reach * out + Vec3f(0, 0, hub + z)); };
  const Path3 arm = Spline(Path3{at(0.08f, 0.04f), at(0.3f, -0.045f), at(0.62f, -0.07f),
                                 at(0.92f, -0.03f), at(1.0f, 0.05f)},
                           7);
  SweepOptions taper;
  taper.scale = [](float t) { return Vec2f::Constant(1.0f - 0.35f * t).eval(); };
  b.Add(Sweep(arm, EllipseSection(0.016f, 0.016f, 12), taper), metal);
  const Vec3f tip = at(1.0f, 0.045f);
  b.Add(Lathe(VesselProfile(
                  Spline(Path2{{0, 0}, {0.012f, 0.001f}, {0.034f, 0.01f}, {0.042f, 0.018f}}, 4),
                  0.0025f, 0.003f))
            .Moved(tip),
        metal);
  b.Add(Cylinder(0.0115f, 0.085f, 0.002f).Moved(tip + Vec3f(0, 0, 0.003f)),
        Slot("candle", {"ceramic", "plastic", "paper"}));
  const Path2 flame = Spline(
      Path2{{0.006f, 0}, {0.014f, 0.016f}, {0.016f, 0.03f}, {0.009f, 0.055f}, {0.001f, 0.075f}}, 5);
  b.Add(Lathe(flame, {.segments = 18}).Moved(tip + Vec3f(0, 0, 0.085f)), EmissiveSlot("bulb"));
}

// A turned baluster with arms around it.
void AddChandelier(AssetBuilder& b, const CeilingLampParams& p) {
  const MaterialSlot metal = MetalSlot("metal");
  const float hub = -p.drop_m + 0.16f;
  AddSuspension(b, p, hub + 0.2f);
  b.Add(Lathe(Spline(Path2{{0.002f, 0},
                           {0.016f, 0.012f},
                           {0.012f, 0.03f},
                           {0.042f, 0.07f},
                           {0.05f, 0.1f},
                           {0.03f, 0.14f},
                           {0.014f, 0.17f},
                           {0.024f, 0.2f},
                           {0.02f, 0.235f},
                           {0.006f, 0.26f}},
                     6))
            .Moved(0, 0, hub - 0.06f),
        metal);
  b.Add(Ball(0.02f, 18).Moved(0, 0, hub - 0.075f), metal);
  for (int k = 0; k < p.arms; ++k) {
    const float a = 2 * kPi * (static_cast<float>(k) + 0.5f) / static_cast<float>(p.arms);
    AddChandelierArm(b, Vec3f(std::cos(a), std::sin(a), 0), 1.35f * p.radius_m, hub);
  }
}

// A glowing ball.
void AddGlobePendant(AssetBuilder& b, const CeilingLampParams& p) {
  const float radius = 0.75f * p.radius_m, low = -p.drop_m;
  AddSuspension(b, p, low + 2 * radius + 0.03f);
  b.Add(Lathe(Filleted(Path2{{0, 0}, {0.05f, 0}, {0.045f, 0.03f}, {0.012f, 0.05f}, {0, 0.05f}},
                       0.006f, 3))
            .Moved(0, 0, low + 2 * radius - 0.018f),
        MetalSlot("metal"));
  b.Add(Ball(radius, 56).Moved(0, 0, low + radius), EmissiveSlot("bulb"));
}

// A drum with three bulbs on spokes.
void AddDrumPendant(AssetBuilder& b, const CeilingLampParams& p) {
  const MaterialSlot metal = MetalSlot("metal");
  const float r = p.radius_m, low = -p.drop_m, sh = 0.75f * r;
  AddSuspension(b, p, low + 0.75f * sh);
  AddShade(b, p.seed % 3 == 0 ? ShadeStyle::kPleated : ShadeStyle::kDrum, 1.15f * r, sh,
           {0, 0, low});
  b.Add(Tube({{0, 0, low + 0.6f * sh}, {0, 0, low + sh - 0.01f}}, 0.01f, 0.002f, 14), metal);
  for (int k = 0; k < 3; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 3.0f;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    b.Add(Tube({Vec3f(0, 0, low + 0.66f * sh),
                Vec3f(0.34f * r * out + Vec3f(0, 0, low + 0.66f * sh))},
               0.005f, 0.002f, 10),
          metal);
    AddBulb(b, 0.34f * r * out + Vec3f(0, 0, low + 0.68f * sh), true, 0.026f);
  }
}

// The section of an enamelled dome of that radius, up outside and down inside, and the number of
// its points outside.
std::pair<Path2, size_t> DomeSection(float r, float height) {
  const Path2 bell = Spline(Path2{{1.3f * r, 0},
                                  {1.27f * r, 0.02f * r},
                                  {1.1f * r, 0.2f * r},
                                  {0.75f * r, 0.45f * r},
                                  {0.35f * r, 0.58f * r},
                                  {0.17f * r, 0.64f * r},
                                  {0.15f * r, height}},
                            6);
  Path2 section = bell;
  for (size_t i = bell.size(); i-- > 0;)
    section.emplace_back(std::max(0.02f * r, bell[i].x() - 0.004f),
                         bell[i].y() - (i > 0 ? 0.003f : 0.0f));
  return {section, bell.size()};
}

// An enamelled dome with a neck.
void AddDomePendant(AssetBuilder& b, const CeilingLampParams& p) {
  const MaterialSlot metal = MetalSlot("metal"),
                     enamel = Slot("shade", {"metal", "paint", "ceramic"});
  const float r = p.radius_m, low = -p.drop_m, height = 0.72f * r;
  AddSuspension(b, p, low + height + 0.03f);
  const auto [section, outer_points] = DomeSection(r, height);
  b.Add(LinedShade(section, outer_points, 64).Moved(0, 0, low),
        {enamel, EmissiveSlot("shade_inside")});
  b.Add(Ring(Circle(1.3f * r - 0.002f, low, 64), 0.004f, 8), enamel);
  b.Add(Cone(0.16f * r, 0.012f, 0.045f, 0.004f).Moved(0, 0, low + height - 0.006f), metal);
  b.Add(Cylinder(0.022f, 0.1f, 0.003f).Moved(0, 0, low + 0.55f * height), metal);
  AddBulb(b, {0, 0, low + 0.57f * height}, true, 0.03f);
}

// The ceiling is z = 0; the lamp hangs below it.
Asset MakeCeilingLamp(const CeilingLampParams& p) {
  constexpr void (*kStyles[])(AssetBuilder&, const CeilingLampParams&) = {
      AddDomePendant, AddDrumPendant, AddGlobePendant, AddChandelier, AddCeilingBowl};
  AssetBuilder b(p.seed);
  kStyles[p.style](b, p);
  return b.Finish(Anchor::kCeiling);
}

Asset SampleCeilingClassicLamp(Rng& rng) {
  CeilingLampParams p;
  p.style = rng.UniformInt(0, 4);
  p.radius_m = Draw(rng, 0.16, 0.24);
  p.drop_m = Draw(rng, 0.5, 0.85);
  p.arms = rng.UniformInt(4, 7);
  p.seed = rng.Seed();
  return MakeCeilingLamp(p);
}

}  // namespace

void RegisterLamps(std::vector<AssetClass>& classes) {
  classes.push_back({"FloorLamp", "lamps", Placement::kFloor, true, 0, SampleFloorLamp,
                     SizeRange({0.28f, 0.28f, 1.3f}, {1.5f, 0.62f, 2.2f})});
  classes.push_back({"Lamp", "lamps", Placement::kFloor, true, 0, SampleFloorLamp,
                     SizeRange({0.28f, 0.28f, 1.3f}, {1.5f, 0.62f, 2.2f})});
  classes.push_back({"DeskLamp", "lamps", Placement::kOnTop, true, 0, SampleDeskLamp,
                     SizeRange({0.14f, 0.16f, 0.34f}, {0.46f, 0.46f, 0.66f})});
  classes.push_back({"CeilingClassicLamp", "lamps", Placement::kCeiling, true, 0,
                     SampleCeilingClassicLamp, SizeRange({0.2f, 0.2f, 0.08f}, {0.8f, 0.8f, 1})});
}

}  // namespace parallax
