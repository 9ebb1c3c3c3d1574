#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/lamps/lamp_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// The end of a task lamp's arm, and the direction in which it shines.
struct LampHead {
  Vec3f at, aim;
};

// A coil along a part of the lower arm.
void AddBalanceSpring(AssetBuilder& b, const Vec3f& base, const Vec3f& elbow) {
  Path3 coil;
  const Vec3f from = base + 0.1f * (elbow - base), along = 0.42f * (elbow - base);
  const Vec3f side = Vec3f::UnitX(), other = along.normalized().cross(side);
  for (int k = 0; k <= 160; ++k) {
    const float s = static_cast<float>(k) / 160.0f, a = 2 * kPi * 20 * s;
    coil.push_back(from + s * along + 0.005f * (std::cos(a) * side + std::sin(a) * other));
  }
  b.Add(Tube(coil, 0.0009f, 0, 6), MetalSlot("spring"));
}

// Two arms of twin rods.
LampHead AddJointedArms(AssetBuilder& b, float h) {
  const MaterialSlot metal = MetalSlot("body");
  const Vec3f base(0, -0.02f, 0.045f), elbow(0, -0.12f, 0.62f * h), head(0, 0.13f, 0.97f * h);
  b.Add(Cylinder(0.012f, 0.035f, 0.002f).Moved(0, -0.02f, 0.02f), metal);
  for (const float s : {-0.011f, 0.011f}) {
    b.Add(Tube({base + Vec3f(s, 0, 0), elbow + Vec3f(s, 0, 0)}, 0.0042f, 0.002f, 10), metal);
    b.Add(Tube({elbow + Vec3f(s, 0, 0), head + Vec3f(s, 0, 0)}, 0.0042f, 0.002f, 10), metal);
  }
  for (const Vec3f& joint : {base, elbow, head})
    b.Add(
        Cylinder(0.013f, 0.036f, 0.003f, 18).TurnedY(0.5f * kPi).Moved(joint - Vec3f(0.018f, 0, 0)),
        metal);
  AddBalanceSpring(b, base, elbow);
  return {head, Vec3f(0, 0.45f, -1).normalized()};
}

LampHead AddGooseneck(AssetBuilder& b, float h) {
  const Vec3f head(0, 0.11f, 0.86f * h);
  const Path3 neck = Spline(Path3{{0, -0.03f, 0.02f},
                                  {0, -0.045f, 0.35f * h},
                                  {0, -0.03f, 0.75f * h},
                                  {0, 0.03f, 0.96f * h},
                                  {0, 0.09f, 0.95f * h},
                                  head},
                            8);
  b.Add(Tube(neck, 0.006f, 0, 14), MetalSlot("body"));
  return {head, Vec3f(0, 0.55f, -1).normalized()};
}

// A lined bell that opens along `aim`: built upright (opening up) and turned.
void AddBell(AssetBuilder& b, const LampHead& head) {
  const MaterialSlot metal = MetalSlot("body");
  const Path2 bell = Spline(
      Path2{{0.022f, 0}, {0.026f, 0.035f}, {0.04f, 0.06f}, {0.066f, 0.095f}, {0.074f, 0.135f}}, 5);
  Path2 section = bell;
  for (size_t i = bell.size(); i-- > 0;)
    section.emplace_back(bell[i].x() - 0.0025f, bell[i].y() + (i == 0 ? 0.004f : 0.0f));
  const Vec3f& aim = head.aim;
  const Vec3f start = head.at - 0.02f * aim;
  b.Add(AlongZ(LinedShade(section, bell.size(), 48), start, start + aim),
        {metal, EmissiveSlot("shade_inside")});
  b.Add(AlongZ(Cylinder(0.0225f, 0.03f, 0.004f), start - 0.006f * aim, start + aim), metal);
  b.Add(AlongZ(Lathe(BulbGlass(0.022f), {.segments = 18}), start + 0.02f * aim, start + aim),
        EmissiveSlot("bulb"));
  b.Add(AlongZ(Cylinder(0.012f, 0.025f, 0.001f, 16), start + 0.018f * aim, start + aim),
        MetalSlot("socket"));
}

// A table or desk lamp.
struct DeskLampParams {
  float height_m = 0.5f;
  // 0 jointed arms, 1 vase body with shade, 2 turned column with shade, 3 gooseneck.
  int style = 0;
  ShadeStyle shade = ShadeStyle::kEmpire;
  uint64_t seed = 0;
};

void AddTaskLamp(AssetBuilder& b, const DeskLampParams& p) {
  b.Add(Lathe(Filleted(Path2{{0, 0}, {0.085f, 0}, {0.085f, 0.014f}, {0.03f, 0.026f}, {0, 0.026f}},
                       0.005f, 4)),
        MetalSlot("body"));
  AddBell(b, p.style == 0 ? AddJointedArms(b, p.height_m) : AddGooseneck(b, p.height_m));
}

// Half of a vase from its foot to `top`; `w` is its usual radius.
Path2 VaseBodyProfile(int form, float w, float top) {
  if (form == 0) {
    return {{0.5f * w, 0},           {0.55f * w, 0.01f},
            {1.0f * w, 0.3f * top},  {0.95f * w, 0.55f * top},
            {0.3f * w, 0.88f * top}, {0.24f * w, top}};
  }
  if (form == 1) {
    return {{0.7f * w, 0},           {0.78f * w, 0.01f},      {0.6f * w, 0.12f * top},
            {1.05f * w, 0.6f * top}, {0.8f * w, 0.84f * top}, {0.26f * w, 0.93f * top},
            {0.24f * w, top}};
  }
  return {{0.9f * w, 0},          {1.0f * w, 0.012f},
          {1.0f * w, 0.4f * top}, {0.85f * w, 0.75f * top},
          {0.3f * w, 0.9f * top}, {0.24f * w, top}};
}

void AddVaseBody(AssetBuilder& b, const DeskLampParams& p, float top) {
  const Path2 profile =
      VaseBodyProfile(static_cast<int>(p.seed % 3), 0.14f * p.height_m + 0.025f, top);
  LatheOptions options;
  if (p.seed % 5 < 2)
    options.modulate = [&](float a, float z) {
      return 1 + 0.03f * std::sin(kPi * std::clamp(z / top, 0.0f, 1.0f)) * std::cos(14 * a);
    };
  options.segments = 56;
  b.Add(Lathe(Spline(profile, 7), options), Slot("body", {"ceramic", "glass", "metal"}));
}

void AddColumnBody(AssetBuilder& b, const DeskLampParams& p, float top) {
  const MaterialSlot body = Slot("body", {"wood", "metal"});
  b.Add(Lathe(Filleted(
            Path2{{0, 0}, {0.09f, 0}, {0.09f, 0.012f}, {0.05f, 0.022f}, {0.03f, 0.03f}, {0, 0.03f}},
            0.005f, 3)),
        body);
  b.Add(TurnedLeg(top - 0.024f, 0.032f, static_cast<int>(p.seed % 4)).Moved(0, 0, 0.024f), body);
}

// A body under a shade, which a harp over the bulb carries.
void AddTableLamp(AssetBuilder& b, const DeskLampParams& p) {
  const float h = p.height_m;
  const float sr = 0.3f * h, sh = 0.42f * h, shade_z = h - sh;
  const float body_top = shade_z - 0.005f;
  p.style == 1 ? AddVaseBody(b, p, body_top) : AddColumnBody(b, p, body_top);
  const float neck = shade_z + 0.12f * sh;
  b.Add(Cylinder(0.009f, neck - body_top + 0.02f, 0.001f).Moved(0, 0, body_top - 0.01f),
        MetalSlot("socket"));
  AddBulb(b, {0, 0, neck}, false, 0.026f);
  AddShade(b, p.shade, sr, sh, {0, 0, shade_z});
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Tube(Spline(Path3{{s * 0.012f, 0, neck + 0.006f},
                            {s * 0.042f, 0, neck + 0.05f},
                            {s * 0.03f, 0, h - 0.06f},
                            {0, 0, h - 0.012f}},
                      5),
               0.0018f, 0, 8),
          MetalSlot("socket"));
  }
}

Asset MakeDeskLamp(const DeskLampParams& p) {
  AssetBuilder b(p.seed);
  p.style == 0 || p.style == 3 ? AddTaskLamp(b, p) : AddTableLamp(b, p);
  return b.Finish();
}

}  // namespace

Asset SampleDeskLamp(Rng& rng) {
  DeskLampParams p;
  p.style = rng.UniformInt(0, 3);
  p.height_m = Draw(rng, 0.38, 0.6);
  const ShadeStyle shades[] = {ShadeStyle::kDrum, ShadeStyle::kEmpire, ShadeStyle::kPleated};
  p.shade = shades[rng.UniformInt(0, 2)];
  p.seed = rng.Seed();
  return MakeDeskLamp(p);
}

}  // namespace parallax
