#include "worker/assets/building/appliance_parts.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot HousingSlot() { return Slot("body", {"ApplianceEnamel", "BrushedMetal", "paint"}); }
MaterialSlot TrimSlot() {
  return Slot("trim", {"BrushedMetal", "HousingPlastic", "PolishedMetal"});
}
MaterialSlot DarkSlot() { return Slot("inside", {"HousingPlastic"}); }
MaterialSlot WindowSlot() { return Slot("window", {"TintedGlass", "ClearGlass"}); }

void AddHoledPanel(AssetBuilder& b, const Vec2f& lo, const Vec2f& hi, const Vec2f& hole_lo,
                   const Vec2f& hole_hi, float back, float front, const MaterialSlot& slot) {
  const float bevel = 0.003f;
  b.Add(Board({lo.x(), back, lo.y()}, {hi.x(), front, hole_lo.y()}, bevel), slot);
  b.Add(Board({lo.x(), back, hole_hi.y()}, {hi.x(), front, hi.y()}, bevel), slot);
  b.Add(Board({lo.x(), back, hole_lo.y() - 0.004f},
              {hole_lo.x(), front - 0.0004f, hole_hi.y() + 0.004f}, bevel),
        slot);
  b.Add(Board({hole_hi.x(), back, hole_lo.y() - 0.004f},
              {hi.x(), front - 0.0004f, hole_hi.y() + 0.004f}, bevel),
        slot);
}

void AddCavity(AssetBuilder& b, const Vec3f& lo, const Vec3f& hi, float wall,
               const MaterialSlot& slot) {
  b.Add(Board({lo.x(), lo.y(), lo.z()}, {lo.x() + wall, hi.y(), hi.z()}, 0.002f), slot);
  b.Add(Board({hi.x() - wall, lo.y(), lo.z()}, {hi.x(), hi.y(), hi.z()}, 0.002f), slot);
  b.Add(Board({lo.x() + 0.5f * wall, lo.y(), lo.z()},
              {hi.x() - 0.5f * wall, hi.y() - 0.0005f, lo.z() + wall}, 0.002f),
        slot);
  b.Add(Board({lo.x() + 0.5f * wall, lo.y(), hi.z() - wall},
              {hi.x() - 0.5f * wall, hi.y() - 0.0005f, hi.z()}, 0.002f),
        slot);
  b.Add(Board({lo.x() + 0.5f * wall, lo.y(), lo.z() + 0.5f * wall},
              {hi.x() - 0.5f * wall, lo.y() + wall, hi.z() - 0.5f * wall}, 0.002f),
        slot);
}

void AddWireShelf(AssetBuilder& b, const Vec2f& lo, const Vec2f& hi, float z, int rods) {
  const MaterialSlot slot = TrimSlot();
  Shape wires;
  for (int i = 0; i < rods; ++i) {
    const float x = Lerp(lo.x(), hi.x(), (static_cast<float>(i) + 0.5f) / static_cast<float>(rods));
    wires.Add(
        Tube({Vec3f(x, lo.y(), z - 0.002f), Vec3f(x, hi.y(), z - 0.002f)}, 0.0018f, 0.001f, 6));
  }
  for (const float y : {lo.y() + 0.01f, hi.y() - 0.01f}) {
    wires.Add(
        Tube({Vec3f(lo.x(), y, z - 0.006f), Vec3f(hi.x(), y, z - 0.006f)}, 0.003f, 0.002f, 8));
  }
  b.Add(wires, slot);
}

Shape Knob(float radius) {
  Shape knob = Lathe(Path2{{1.15f * radius, 0},
                           {1.15f * radius, 0.003f},
                           {0.98f * radius, 0.005f},
                           {0.92f * radius, 0.02f},
                           {0.84f * radius, 0.024f},
                           {0.001f, 0.0245f}});
  knob.Add(Board({-0.14f * radius, -0.9f * radius, 0.022f}, {0.14f * radius, 0.9f * radius, 0.032f},
                 0.002f));
  return knob.TurnedX(-0.5f * kPi);
}

Shape BarHandle(float length, float stand_off, float radius) {
  Shape out = Tube({Vec3f(-0.5f * length, stand_off, 0), Vec3f(0.5f * length, stand_off, 0)},
                   radius, 0.4f * radius, 16);
  for (const float s : {-0.42f, 0.42f}) {
    out.Add(Tube({Vec3f(s * length, -0.002f, 0), Vec3f(s * length, stand_off, 0)}, 0.75f * radius,
                 0, 12));
  }
  return out;
}

void AddFeet(AssetBuilder& b, float half_w, float half_d, float z) {
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      b.Add(Cylinder(0.016f, z + 0.002f, 0.003f, 16)
                .Moved(sx * (half_w - 0.05f), sy * (half_d - 0.05f), 0),
            DarkSlot());
    }
  }
}

}  // namespace parallax
