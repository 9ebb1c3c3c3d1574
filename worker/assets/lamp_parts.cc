#include "worker/assets/lamp_parts.h"

#include <algorithm>
#include <cmath>

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot LampBodySlot() { return Slot("body", {"metal", "wood", "ceramic"}); }

namespace {

MaterialSlot ShadeSlot() { return Slot("shade", {"fabric", "paper"}); }

}  // namespace

void AddBulb(AssetBuilder& b, const Vec3f& at, bool down, float size) {
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

void AddShade(AssetBuilder& b, ShadeStyle style, float radius, float height, const Vec3f& at,
              bool spider) {
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

}  // namespace parallax
