#include <cmath>

#include "worker/assets/building/windows.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A handle, rail or row of hooks.
struct HardwareParams {
  float length_m = 0.2f;
  float rod_m = 0.007f;  // Radius.
  int form = 0;          // 0 bar handle, 1 bow handle, 2 towel rail, 3 row of hooks, 4 lever.
  uint64_t seed = 0;
};

// A square bar on two blocks.
void AddSquareBar(AssetBuilder& b, const HardwareParams& p, const MaterialSlot& metal) {
  const float size = p.length_m, r = p.rod_m;
  b.Add(Board({-0.5f * size, 0.03f, -r}, {0.5f * size, 0.03f + 2 * r, r}, 0.0015f), metal);
  for (const float s : {-0.42f, 0.42f})
    b.Add(Board({s * size - 1.4f * r, 0, -1.4f * r}, {s * size + 1.4f * r, 0.032f, 1.4f * r},
                0.0015f),
          metal);
}

// A bow with leaf-shaped ends.
void AddBow(AssetBuilder& b, const HardwareParams& p, const MaterialSlot& metal) {
  const float size = p.length_m, r = p.rod_m;
  b.Add(Sweep(Spline(Path3{{-0.5f * size, 0.004f, 0},
                           {-0.42f * size, 0.008f, 0},
                           {-0.3f * size, 0.03f, 0},
                           {0, 0.04f, 0},
                           {0.3f * size, 0.03f, 0},
                           {0.42f * size, 0.008f, 0},
                           {0.5f * size, 0.004f, 0}},
                     6),
              EllipseSection(2.4f * r, 1.6f * r, 16), {}),
        metal);
  for (const float s : {-1.0f, 1.0f})
    b.Add(Ellipsoid({0.1f * size, 0.005f, 2.2f * r}, 20).Moved(s * 0.45f * size, 0.004f, 0), metal);
}

// A round bar: towel rail.
void AddTowelRail(AssetBuilder& b, const HardwareParams& p, const MaterialSlot& metal) {
  const float size = p.length_m, r = p.rod_m;
  b.Add(Tube({Vec3f(-0.5f * size, 0.05f, 0), Vec3f(0.5f * size, 0.05f, 0)}, r, 0.3f * r, 18),
        metal);
  for (const float s : {-0.46f, 0.46f}) {
    b.Add(Tube({Vec3f(s * size, 0.001f, 0), Vec3f(s * size, 0.05f, 0)}, 0.9f * r, 0, 14), metal);
    b.Add(Cone(2.6f * r, 2.0f * r, 0.008f, 0.002f, 26).TurnedX(-0.5f * kPi).Moved(s * size, 0, 0),
          metal);
    b.Add(Ball(1.5f * r, 18).Moved(s * size, 0.05f, 0), metal);
  }
}

// A row of hooks on a strip.
void AddHooks(AssetBuilder& b, const HardwareParams& p, const MaterialSlot& metal) {
  const float size = p.length_m;
  Rng rng(SceneSeed{p.seed}, "form");
  b.Add(Board({-0.5f * size, 0, -0.018f}, {0.5f * size, 0.008f, 0.018f}, 0.002f), metal);
  const int hooks = rng.UniformInt(2, 5);
  for (int i = 0; i < hooks; ++i) {
    const float x = ((static_cast<float>(i) + 0.5f) / static_cast<float>(hooks) - 0.5f) * size;
    b.Add(Tube(Spline(Path3{{x, 0.005f, 0.006f},
                            {x, 0.018f, -0.012f},
                            {x, 0.03f, -0.03f},
                            {x, 0.046f, -0.024f},
                            {x, 0.05f, -0.004f}},
                      5),
               0.0042f, 0.004f, 12),
          metal);
    b.Add(Ball(0.0072f, 16).Moved(x, 0.05f, 0.0f), metal);
  }
}

// A lever on its plate.
void AddDoorLever(AssetBuilder& b, const HardwareParams& p, const MaterialSlot& metal) {
  const float size = p.length_m, r = p.rod_m;
  b.Add(Board({-0.022f, 0, -0.1f}, {0.022f, 0.005f, 0.1f}, 0.002f), metal);
  b.Add(Tube(Filleted(Path3{{0, 0.002f, 0.04f}, {0, 0.05f, 0.04f}, {0.6f * size, 0.052f, 0.036f}},
                      0.018f, 5),
             1.3f * r, r, 18),
        metal);
  b.Add(Cylinder(0.012f, 0.004f, 0.001f, 20).TurnedX(-0.5f * kPi).Moved(0, 0.0035f, -0.045f),
        metal);
}

// Handles, knobs, hooks and rails as they lie in a shop: on their mounting face.
Asset MakeHardware(const HardwareParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot metal = Slot("metal", {"metal", "plastic"});
  switch (p.form) {
    case 0:
      AddSquareBar(b, p, metal);
      break;
    case 1:
      AddBow(b, p, metal);
      break;
    case 2:
      AddTowelRail(b, p, metal);
      break;
    case 3:
      AddHooks(b, p, metal);
      break;
    default:
      AddDoorLever(b, p, metal);
  }
  return b.Finish();
}

}  // namespace

Asset SampleHardware(Rng& rng) {
  return MakeHardware({.length_m = Draw(rng, 0.1, 0.3),
                       .rod_m = Draw(rng, 0.005, 0.009),
                       .form = rng.UniformInt(0, 4),
                       .seed = rng.Seed()});
}

}  // namespace parallax
