#include "worker/assets/lamps/lamp_parts.h"

#include <algorithm>
#include <cmath>

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

namespace {

constexpr float kShadeThickness = 0.003f;

MaterialSlot ShadeSlot() { return Slot("shade", {"fabric", "paper"}); }

// The outside of a shade from its lower to its upper edge, and the radius that a spider reaches.
struct ShadeProfile {
  Path2 outer;
  float top = 0;
};

ShadeProfile DrumProfile(float radius, float height) {
  const float top = 0.94f * radius;
  return {{{radius, 0}, {top, height}}, top};
}

ShadeProfile DomeProfile(float radius, float height) {
  Path2 outer;
  for (int k = 0; k <= 12; ++k) {
    const float a = 0.44f * kPi * static_cast<float>(k) / 12.0f;
    outer.emplace_back(radius * std::cos(a), height * std::sin(a));
  }
  return {outer, outer.back().x()};
}

ShadeProfile GlobeProfile(float radius, float height) {
  Path2 outer;
  for (int k = 0; k <= 14; ++k) {
    const float a = -0.3f * kPi + 0.65f * kPi * static_cast<float>(k) / 14.0f;
    outer.emplace_back(radius * std::cos(a), height * (0.45f + 0.5f * std::sin(a)));
  }
  return {outer, outer.back().x()};
}

// A cone, straight or hollow.
ShadeProfile ConeProfile(float radius, float height, bool hollow) {
  const float top = 0.62f * radius;
  Path2 outer;
  for (int k = 0; k <= 8; ++k) {
    const float s = static_cast<float>(k) / 8.0f;
    const float sag = hollow ? 0.04f * radius * std::sin(kPi * s) : 0.0f;
    outer.emplace_back(Lerp(radius, top, s) - sag, height * s);
  }
  return {outer, top};
}

ShadeProfile ProfileOf(ShadeStyle style, float radius, float height) {
  ShadeProfile profile = style == ShadeStyle::kDrum   ? DrumProfile(radius, height)
                         : style == ShadeStyle::kDome ? DomeProfile(radius, height)
                         : style == ShadeStyle::kGlobe
                             ? GlobeProfile(radius, height)
                             : ConeProfile(radius, height, style == ShadeStyle::kEmpire);
  const float low_z = profile.outer.front().y();
  for (Vec2f& p : profile.outer) p.y() -= low_z;
  return profile;
}

Shape PleatedOrPlain(const Path2& outer, bool pleated) {
  Path2 section = outer;
  for (size_t i = outer.size(); i-- > 0;)
    section.emplace_back(outer[i].x() - kShadeThickness, outer[i].y());
  Shape shade = LinedShade(section, outer.size(), pleated ? 144 : 56);
  if (!pleated) return shade;
  shade = shade.Bent([&](const Vec3f& q) {
    const float a = std::atan2(q.y(), q.x());
    const float k = 1 + 0.022f * std::cos(36 * a);
    return Vec3f(q.x() * k, q.y() * k, q.z());
  });
  shade.crease_rad = 1.2f;
  return shade;
}

// The bound edge of a shade that is open there.
void AddBinding(AssetBuilder& b, const Vec2f& edge, const Vec3f& at) {
  const float radius = edge.x() - 0.5f * kShadeThickness;
  b.Add(Ring(Circle(radius, edge.y(), 56), 0.0035f, 8).Moved(at), ShadeSlot());
}

void AddSpider(AssetBuilder& b, float radius, float z, const Vec3f& at) {
  for (int k = 0; k < 3; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 3.0f + 0.4f;
    b.Add(Tube({Vec3f(0, 0, z - 0.01f), Vec3f(radius * std::cos(a), radius * std::sin(a), z)},
               0.0018f, 0, 8)
              .Moved(at),
          MetalSlot("socket"));
  }
}

}  // namespace

MaterialSlot LampBodySlot() { return Slot("body", {"metal", "wood", "ceramic"}); }

Path2 BulbGlass(float size) {
  return Spline(Path2{{0.45f * size, 0.9f * size},
                      {0.55f * size, 1.2f * size},
                      {0.98f * size, 2.1f * size},
                      {0.85f * size, 2.85f * size},
                      {0.45f * size, 3.2f * size},
                      {0.02f * size, 3.3f * size}},
                4);
}

void AddBulb(AssetBuilder& b, const Vec3f& at, bool down, float size) {
  const auto place = [&](const Shape& s) { return (down ? s.TurnedX(kPi) : s).Moved(at); };
  b.Add(place(Lathe(BulbGlass(size), {.segments = 20})), EmissiveSlot("bulb"));
  b.Add(place(Cylinder(0.5f * size, size, 0.1f * size, 16)), MetalSlot("socket"));
}

Shape LinedShade(const Path2& section, size_t outer_points, int segments) {
  Shape shade = LatheRing(section, segments);
  const size_t per_ring = shade.faces.size() / section.size();
  for (size_t i = 0; i < shade.faces.size(); ++i) {
    const size_t ring = i / per_ring;
    if (ring >= outer_points && ring + 1 < section.size()) shade.faces[i].group = 1;
  }
  shade.crease_rad = 0.7f;
  return shade;
}

void AddShade(AssetBuilder& b, ShadeStyle style, float radius, float height, const Vec3f& at,
              bool spider) {
  const auto [outer, top] = ProfileOf(style, radius, height);
  b.Add(PleatedOrPlain(outer, style == ShadeStyle::kPleated).Moved(at),
        {ShadeSlot(), EmissiveSlot("shade_inside")});
  AddBinding(b, outer.front(), at);
  AddBinding(b, outer.back(), at);
  if (spider) AddSpider(b, top - kShadeThickness, outer.back().y() - 0.004f, at);
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
