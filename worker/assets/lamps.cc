#include "worker/assets/lamps.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot BodySlot() { return Slot("body", {"metal", "wood", "ceramic"}); }
MaterialSlot ShadeSlot() { return Slot("shade", {"fabric", "paper"}); }

// A bulb with its socket, cap down at z = 0, glass upwards.
void AddBulb(AssetBuilder& b, const Vec3f& at, bool down, float size = 0.03f) {
  const Path2 glass = Spline(Path2{{0.45f * size, 0.9f * size},
                                   {0.55f * size, 1.2f * size},
                                   {0.98f * size, 2.1f * size},
                                   {0.85f * size, 2.85f * size},
                                   {0.45f * size, 3.2f * size},
                                   {0.02f * size, 3.3f * size}},
                             4);
  const auto place = [&](const Shape& s) { return (down ? s.TurnedX(kPi) : s).Moved(at); };
  b.Add(place(Lathe(glass, {.segments = 20})), EmissiveSlot("bulb"));
  b.Add(place(Cylinder(0.5f * size, size, 0.1f * size, 16)), MetalSlot("socket"));
}

// A shade open above and below: outside `shade`, lining a glowing "shade_inside". Lower edge at z =
// 0.
void AddShade(AssetBuilder& b, ShadeStyle style, float radius, float height, const Vec3f& at,
              bool spider = true) {
  const float t = 0.003f;
  float top = radius;
  Path2 outer;
  switch (style) {
    case ShadeStyle::kDrum:
      top = 0.94f * radius;
      outer = {{radius, 0}, {top, height}};
      break;
    case ShadeStyle::kDome:
      top = 0.2f * radius;
      for (int k = 0; k <= 12; ++k) {
        const float a = 0.44f * kPi * static_cast<float>(k) / 12.0f;
        outer.emplace_back(radius * std::cos(a), height * std::sin(a));
      }
      top = outer.back().x();
      break;
    case ShadeStyle::kGlobe:
      for (int k = 0; k <= 14; ++k) {
        const float a = -0.3f * kPi + 0.65f * kPi * static_cast<float>(k) / 14.0f;
        outer.emplace_back(radius * std::cos(a), height * (0.45f + 0.5f * std::sin(a)));
      }
      top = outer.back().x();
      break;
    default:
      top = 0.62f * radius;
      for (int k = 0; k <= 8; ++k) {
        const float s = static_cast<float>(k) / 8.0f;
        const float sag = style == ShadeStyle::kEmpire ? 0.04f * radius * std::sin(kPi * s) : 0.0f;
        outer.emplace_back(Lerp(radius, top, s) - sag, height * s);
      }
  }
  const float low_z = outer.front().y();
  for (Vec2f& p : outer) p.y() -= low_z;
  // A closed ring section: up outside, down inside.
  Path2 section = outer;
  for (size_t i = outer.size(); i-- > 0;) section.emplace_back(outer[i].x() - t, outer[i].y());
  Shape shade = LatheRing(section, style == ShadeStyle::kPleated ? 144 : 56);
  if (style == ShadeStyle::kPleated) {
    shade = shade.Bent([&](const Vec3f& q) {
      const float a = std::atan2(q.y(), q.x());
      const float k = 1 + 0.022f * std::cos(36 * a);
      return Vec3f(q.x() * k, q.y() * k, q.z());
    });
  }
  // The lining's faces lie beyond the outer profile's.
  const size_t per_ring = shade.faces.size() / section.size();
  for (size_t i = 0; i < shade.faces.size(); ++i) {
    const size_t ring = i / per_ring;
    if (ring >= outer.size() && ring + 1 < section.size()) shade.faces[i].group = 1;
  }
  shade.crease_rad = style == ShadeStyle::kPleated ? 1.2f : 0.7f;
  b.Add(shade.Moved(at), {ShadeSlot(), EmissiveSlot("shade_inside")});
  // Bound edges.
  for (const Vec2f& e : {outer.front(), outer.back()}) {
    Path3 rim;
    for (int k = 0; k < 56; ++k) {
      const float a = 2 * kPi * static_cast<float>(k) / 56.0f;
      rim.emplace_back((e.x() - 0.5f * t) * std::cos(a), (e.x() - 0.5f * t) * std::sin(a), e.y());
    }
    b.Add(Ring(rim, 0.0035f, 8).Moved(at), ShadeSlot());
  }
  if (!spider) return;
  const float z = outer.back().y() - 0.004f;
  for (int k = 0; k < 3; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 3.0f + 0.4f;
    b.Add(Tube({Vec3f(0, 0, z - 0.01f), Vec3f((top - t) * std::cos(a), (top - t) * std::sin(a), z)},
               0.0018f, 0, 8)
              .Moved(at),
          MetalSlot("socket"));
  }
}

Path3 Circle(float radius, float z, int n) {
  Path3 out;
  for (int k = 0; k < n; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(n);
    out.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return out;
}

}  // namespace

Asset MakeFloorLamp(const FloorLampParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = BodySlot();
  const float r = p.shade_radius_m;
  const bool globe = p.shade == ShadeStyle::kGlobe;
  const float sh =
      p.shade == ShadeStyle::kDome
          ? 0.75f * r
          : (globe ? 1.6f * r : Lerp(1.1f, 1.5f, static_cast<float>(p.seed % 16) / 15.0f) * r);
  const float shade_z = p.height_m - sh;
  const float neck = shade_z + 0.4f * sh;
  if (p.stand == 3) {
    // A heavy foot, an arc, the shade hanging from its end.
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.17f, 0}, {0.17f, 0.045f}, {0.02f, 0.05f}, {0, 0.05f}},
                         0.006f, 4)),
          Slot("foot", {"stone", "metal"}));
    const float reach = 0.85f, top = p.height_m;
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
          PlasticSlot("cord"));
    const float hh = 0.7f * r;
    AddShade(b, ShadeStyle::kDome, r, hh, {reach, 0, 0.8f * top - hh}, false);
    b.Add(Cylinder(0.22f * r, 0.02f, 0.003f).Moved(reach, 0, 0.8f * top - 0.03f * r - 0.012f),
          MetalSlot("body"));
    AddBulb(b, {reach, 0, 0.8f * top - 0.02f}, true);
    return b.Finish();
  }
  if (p.stand == 2) {
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
  } else {
    b.Add(Lathe(Spline(Path2{{0.14f, 0},
                             {0.143f, 0.006f},
                             {0.135f, 0.014f},
                             {0.08f, 0.026f},
                             {0.03f, 0.04f},
                             {0.016f, 0.07f},
                             {0.012f, 0.12f}},
                       5)),
          body);
    if (p.stand == 1) {
      const float column = neck - 0.1f;
      b.Add(TurnedLeg(column, 0.03f, static_cast<int>(p.seed % 4)).Moved(0, 0, 0.05f),
            Slot("body", {"wood", "metal"}));
      b.Add(Cylinder(0.007f, 0.1f, 0.001f).Moved(0, 0, column), MetalSlot("socket"));
    } else {
      b.Add(Cylinder(0.011f, neck - 0.08f, 0.002f).Moved(0, 0, 0.08f), body);
      if (p.seed % 2 == 0) {
        // A small tray table half-way.
        b.Add(Lathe(VesselProfile(Filleted(Path2{{0, 0}, {0.16f, 0}, {0.165f, 0.018f}}, 0.008f, 3),
                                  0.003f, 0.004f))
                  .Moved(0, 0, 0.52f),
              body);
        b.Add(Cylinder(0.02f, 0.02f, 0.003f).Moved(0, 0, 0.505f), body);
      }
    }
  }
  AddBulb(b, {0, 0, neck}, false, 0.03f);
  AddShade(b, p.shade, r, sh, {0, 0, shade_z});
  // What carries the shade: a harp over the bulb.
  b.Add(Tube(Spline(Path3{{0.02f, 0, neck + 0.012f},
                          {0.05f, 0, neck + 0.06f},
                          {0.035f, 0, 0.5f * (neck + 0.06f + p.height_m)},
                          {0, 0, p.height_m - 0.012f}},
                    5),
             0.002f, 0, 8),
        MetalSlot("socket"));
  b.Add(Tube(Spline(Path3{{-0.02f, 0, neck + 0.012f},
                          {-0.05f, 0, neck + 0.06f},
                          {-0.035f, 0, 0.5f * (neck + 0.06f + p.height_m)},
                          {0, 0, p.height_m - 0.012f}},
                    5),
             0.002f, 0, 8),
        MetalSlot("socket"));
  // Pull chain.
  if (p.seed % 3 == 0)
    b.Add(Tube({{0.03f, 0.03f, neck}, {0.03f, 0.03f, shade_z - 0.08f}}, 0.0012f, 0, 6),
          MetalSlot("socket"));
  return b.Finish();
}

Asset SampleFloorLamp(Rng& rng) {
  FloorLampParams p;
  p.height_m = Draw(rng, 1.4, 1.8);
  p.shade_radius_m = Draw(rng, 0.16, 0.25);
  const ShadeStyle shades[] = {ShadeStyle::kDrum, ShadeStyle::kEmpire, ShadeStyle::kPleated};
  p.shade = shades[rng.UniformInt(0, 2)];
  p.stand = rng.UniformInt(0, 3);
  if (p.stand == 3) p.height_m = Draw(rng, 1.8, 2.1);
  p.seed = rng.Seed();
  return MakeFloorLamp(p);
}

Asset MakeDeskLamp(const DeskLampParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot metal = MetalSlot("body");
  const float h = p.height_m;
  if (p.style == 0 || p.style == 3) {
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.085f, 0}, {0.085f, 0.014f}, {0.03f, 0.026f}, {0, 0.026f}},
                         0.005f, 4)),
          metal);
    Vec3f head;
    Vec3f aim(0, 0.45f, -1);
    if (p.style == 0) {
      const Vec3f base(0, -0.02f, 0.045f), elbow(0, -0.12f, 0.62f * h);
      head = Vec3f(0, 0.13f, 0.97f * h);
      b.Add(Cylinder(0.012f, 0.035f, 0.002f).Moved(0, -0.02f, 0.02f), metal);
      for (const float s : {-0.011f, 0.011f}) {
        b.Add(Tube({base + Vec3f(s, 0, 0), elbow + Vec3f(s, 0, 0)}, 0.0042f, 0.002f, 10), metal);
        b.Add(Tube({elbow + Vec3f(s, 0, 0), head + Vec3f(s, 0, 0)}, 0.0042f, 0.002f, 10), metal);
      }
      for (const Vec3f& joint : {base, elbow, head})
        b.Add(Cylinder(0.013f, 0.036f, 0.003f, 18)
                  .TurnedY(0.5f * kPi)
                  .Moved(joint - Vec3f(0.018f, 0, 0)),
              metal);
      // The balancing spring.
      Path3 coil;
      const Vec3f from = base + 0.1f * (elbow - base), along = 0.42f * (elbow - base);
      const Vec3f side = Vec3f::UnitX(), other = along.normalized().cross(side);
      for (int k = 0; k <= 160; ++k) {
        const float s = static_cast<float>(k) / 160.0f, a = 2 * kPi * 20 * s;
        coil.push_back(from + s * along + 0.005f * (std::cos(a) * side + std::sin(a) * other));
      }
      b.Add(Tube(coil, 0.0009f, 0, 6), MetalSlot("spring"));
    } else {
      head = Vec3f(0, 0.11f, 0.86f * h);
      const Path3 neck = Spline(Path3{{0, -0.03f, 0.02f},
                                      {0, -0.045f, 0.35f * h},
                                      {0, -0.03f, 0.75f * h},
                                      {0, 0.03f, 0.96f * h},
                                      {0, 0.09f, 0.95f * h},
                                      head},
                                8);
      b.Add(Tube(neck, 0.006f, 0, 14), metal);
      aim = Vec3f(0, 0.55f, -1);
    }
    aim.normalize();
    // A bell that opens along `aim`: built upright (opening up) and turned.
    const Path2 bell = Spline(
        Path2{{0.022f, 0}, {0.026f, 0.035f}, {0.04f, 0.06f}, {0.066f, 0.095f}, {0.074f, 0.135f}},
        5);
    Path2 section = bell;
    for (size_t i = bell.size(); i-- > 0;)
      section.emplace_back(bell[i].x() - 0.0025f, bell[i].y() + (i == 0 ? 0.004f : 0.0f));
    Shape shade = LatheRing(section, 48);
    const size_t per_ring = shade.faces.size() / section.size();
    for (size_t i = 0; i < shade.faces.size(); ++i) {
      if (i / per_ring >= bell.size() && i / per_ring + 1 < section.size())
        shade.faces[i].group = 1;
    }
    shade.crease_rad = 0.7f;
    const Vec3f start = head - 0.02f * aim;
    b.Add(AlongZ(shade, start, start + aim), {metal, EmissiveSlot("shade_inside")});
    b.Add(AlongZ(Cylinder(0.0225f, 0.03f, 0.004f), start - 0.006f * aim, start + aim), metal);
    const float size = 0.022f;
    const Path2 glass = Spline(Path2{{0.45f * size, 0.9f * size},
                                     {0.55f * size, 1.2f * size},
                                     {0.98f * size, 2.1f * size},
                                     {0.85f * size, 2.85f * size},
                                     {0.45f * size, 3.2f * size},
                                     {0.02f * size, 3.3f * size}},
                               4);
    b.Add(AlongZ(Lathe(glass, {.segments = 18}), start + 0.02f * aim, start + aim),
          EmissiveSlot("bulb"));
    b.Add(AlongZ(Cylinder(0.012f, 0.025f, 0.001f, 16), start + 0.018f * aim, start + aim),
          MetalSlot("socket"));
    return b.Finish();
  }
  const float sr = 0.3f * h, sh = 0.42f * h, shade_z = h - sh;
  const float body_top = shade_z - 0.005f;
  if (p.style == 1) {
    const float w = 0.14f * h + 0.025f;
    const int form = static_cast<int>(p.seed % 3);
    Path2 profile;
    if (form == 0)
      profile = {{0.5f * w, 0},
                 {0.55f * w, 0.01f},
                 {1.0f * w, 0.3f * body_top},
                 {0.95f * w, 0.55f * body_top},
                 {0.3f * w, 0.88f * body_top},
                 {0.24f * w, body_top}};
    if (form == 1)
      profile = {{0.7f * w, 0},
                 {0.78f * w, 0.01f},
                 {0.6f * w, 0.12f * body_top},
                 {1.05f * w, 0.6f * body_top},
                 {0.8f * w, 0.84f * body_top},
                 {0.26f * w, 0.93f * body_top},
                 {0.24f * w, body_top}};
    if (form == 2)
      profile = {{0.9f * w, 0},
                 {1.0f * w, 0.012f},
                 {1.0f * w, 0.4f * body_top},
                 {0.85f * w, 0.75f * body_top},
                 {0.3f * w, 0.9f * body_top},
                 {0.24f * w, body_top}};
    LatheOptions options;
    if (p.seed % 5 < 2)
      options.modulate = [&](float a, float z) {
        return 1 + 0.03f * std::sin(kPi * std::clamp(z / body_top, 0.0f, 1.0f)) * std::cos(14 * a);
      };
    options.segments = 56;
    b.Add(Lathe(Spline(profile, 7), options), Slot("body", {"ceramic", "glass", "metal"}));
  } else {
    b.Add(
        Lathe(Filleted(
            Path2{{0, 0}, {0.09f, 0}, {0.09f, 0.012f}, {0.05f, 0.022f}, {0.03f, 0.03f}, {0, 0.03f}},
            0.005f, 3)),
        Slot("body", {"wood", "metal"}));
    b.Add(TurnedLeg(body_top - 0.024f, 0.032f, static_cast<int>(p.seed % 4)).Moved(0, 0, 0.024f),
          Slot("body", {"wood", "metal"}));
  }
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
  return b.Finish();
}

Asset SampleDeskLamp(Rng& rng) {
  DeskLampParams p;
  p.style = rng.UniformInt(0, 3);
  p.height_m = Draw(rng, 0.38, 0.6);
  const ShadeStyle shades[] = {ShadeStyle::kDrum, ShadeStyle::kEmpire, ShadeStyle::kPleated};
  p.shade = shades[rng.UniformInt(0, 2)];
  p.seed = rng.Seed();
  return MakeDeskLamp(p);
}

Asset MakeCeilingLamp(const CeilingLampParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot metal = MetalSlot("metal");
  const float r = p.radius_m, low = -p.drop_m;
  if (p.style == 4) {
    // A glass bowl held by a plate at the ceiling.
    b.Add(
        Lathe(Filleted(
            Path2{{0, -0.035f}, {0.9f * r, -0.035f}, {r + 0.01f, -0.02f}, {r + 0.012f, 0}, {0, 0}},
            0.006f, 3)),
        metal);
    Path2 bowl;
    for (int k = 0; k <= 16; ++k) {
      const float a = 0.5f * kPi * static_cast<float>(k) / 16.0f;
      bowl.emplace_back(r * std::sin(a), -0.028f - 0.42f * r * std::cos(a));
    }
    bowl.front().x() = 0;
    b.Add(Lathe(bowl), EmissiveSlot("bulb"));
    // A finial under its middle.
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
    return b.Finish(Anchor::kCeiling);
  }
  // The rose at the ceiling, the cord or rod.
  b.Add(
      Lathe(Spline(
          Path2{{0.008f, -0.05f}, {0.02f, -0.04f}, {0.045f, -0.03f}, {0.058f, -0.012f}, {0.06f, 0}},
          4)),
      metal);
  const bool rod = p.style == 3 || p.seed % 2 == 0;
  const auto hang = [&](float to) {
    b.Add(Tube({{0, 0, -0.03f}, {0, 0, to}}, rod ? 0.006f : 0.0028f, 0, 10),
          rod ? metal : PlasticSlot("cord"));
  };
  if (p.style == 3) {
    const float hub = low + 0.16f;
    hang(hub + 0.2f);
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
      const Vec3f out(std::cos(a), std::sin(a), 0);
      const float reach = 1.35f * r;
      const auto at = [&](float x, float z) {
        return Vec3f(x * reach * out + Vec3f(0, 0, hub + z));
      };
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
          Path2{{0.006f, 0}, {0.014f, 0.016f}, {0.016f, 0.03f}, {0.009f, 0.055f}, {0.001f, 0.075f}},
          5);
      b.Add(Lathe(flame, {.segments = 18}).Moved(tip + Vec3f(0, 0, 0.085f)), EmissiveSlot("bulb"));
    }
    return b.Finish(Anchor::kCeiling);
  }
  if (p.style == 2) {
    const float radius = 0.75f * r;
    hang(low + 2 * radius + 0.03f);
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.05f, 0}, {0.045f, 0.03f}, {0.012f, 0.05f}, {0, 0.05f}},
                         0.006f, 3))
              .Moved(0, 0, low + 2 * radius - 0.018f),
          metal);
    b.Add(Ball(radius, 56).Moved(0, 0, low + radius), EmissiveSlot("bulb"));
    return b.Finish(Anchor::kCeiling);
  }
  if (p.style == 1) {
    const float sh = 0.75f * r;
    hang(low + 0.75f * sh);
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
    return b.Finish(Anchor::kCeiling);
  }
  // An enamelled dome with a neck.
  const float height = 0.72f * r;
  hang(low + height + 0.03f);
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
  Shape shade = LatheRing(section, 64);
  const size_t per_ring = shade.faces.size() / section.size();
  for (size_t i = 0; i < shade.faces.size(); ++i) {
    if (i / per_ring >= bell.size() && i / per_ring + 1 < section.size()) shade.faces[i].group = 1;
  }
  shade.crease_rad = 0.7f;
  b.Add(shade.Moved(0, 0, low),
        {Slot("shade", {"metal", "paint", "ceramic"}), EmissiveSlot("shade_inside")});
  b.Add(Ring(Circle(1.3f * r - 0.002f, low, 64), 0.004f, 8),
        Slot("shade", {"metal", "paint", "ceramic"}));
  b.Add(Cone(0.16f * r, 0.012f, 0.045f, 0.004f).Moved(0, 0, low + height - 0.006f), metal);
  b.Add(Cylinder(0.022f, 0.1f, 0.003f).Moved(0, 0, low + 0.55f * height), metal);
  AddBulb(b, {0, 0, low + 0.57f * height}, true, 0.03f);
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

void RegisterLamps(std::vector<AssetClass>& classes) {
  classes.push_back({"FloorLamp", "lamps", Placement::kFloor, true, 0, SampleFloorLamp});
  classes.push_back({"Lamp", "lamps", Placement::kFloor, true, 0, SampleFloorLamp});
  classes.push_back({"DeskLamp", "lamps", Placement::kOnTop, true, 0, SampleDeskLamp});
  classes.push_back(
      {"CeilingClassicLamp", "lamps", Placement::kCeiling, true, 0, SampleCeilingClassicLamp});
}

}  // namespace parallax
