#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/appliance_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A small fridge with a glass door.
struct BeverageFridgeParams {
  float width_m = 0.5f;
  float depth_m = 0.52f;
  float height_m = 0.82f;
  int shelves = 4;
  bool full = true;  // Bottles and cans on the shelves.
  uint64_t seed = 0;
};

// Dimensions that the parts of a fridge share: half width and depth, height; height of the feet and
// of the inside's floor and ceiling; the door's back.
struct Fridge {
  explicit Fridge(const BeverageFridgeParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        h(params.height_m),
        front(d - 0.04f),
        low(foot + 0.09f),
        high(h - wall) {}
  const BeverageFridgeParams& p;
  const float w, d, h, foot = 0.02f, wall = 0.035f, front, low, high;
};

// The housing, a light liner, so that one sees what is inside, and the vent below.
void AddFridgeBody(AssetBuilder& b, const Fridge& f) {
  const float w = f.w, d = f.d, foot = f.foot, wall = f.wall, front = f.front;
  AddFeet(b, w, d, foot);
  AddCavity(b, {-w, -d, foot}, {w, front, f.h}, wall, HousingSlot());
  AddCavity(b, {-w + wall - 0.001f, -d + wall - 0.001f, f.low - 0.002f},
            {w - wall + 0.001f, front - 0.004f, f.high + 0.001f}, 0.004f,
            Slot("liner", {"ApplianceEnamel"}));
  b.Add(Board({-w + 0.03f, -d + 0.03f, foot + 0.03f}, {w - 0.03f, front - 0.001f, f.low}, 0.002f),
        DarkSlot());
  Shape slots;
  for (int i = 0; i < 9; ++i)
    slots.Add(Board({-0.6f * w, front - 0.002f, foot + 0.034f + 0.005f * static_cast<float>(i)},
                    {0.6f * w, front + 0.002f, foot + 0.0365f + 0.005f * static_cast<float>(i)},
                    0.0004f));
  b.Add(slots, TrimSlot());
}

// A bottle or can with a printed label.
Shape Drink(bool bottle, float r, float tall) {
  const LatheOptions print{
      .segments = 24, .print_from_z = 0.02f, .print_to_z = 0.6f * tall, .print_repeats = 2};
  const Path2 profile = bottle ? Path2{{0.9f * r, 0},
                                       {r, 0.005f},
                                       {r, 0.02f},
                                       {r, 0.6f * tall},
                                       {0.85f * r, 0.7f * tall},
                                       {0.36f * r, 0.84f * tall},
                                       {0.33f * r, 0.97f * tall},
                                       {0.4f * r, 0.975f * tall},
                                       {0.4f * r, tall},
                                       {0.001f, tall}}
                               : Path2{{0.75f * r, 0},
                                       {r, 0.012f},
                                       {r, 0.02f},
                                       {r, 0.6f * tall},
                                       {r, 0.9f * tall},
                                       {0.82f * r, tall},
                                       {0.76f * r, tall - 0.003f},
                                       {0.001f, tall - 0.003f}};
  return Lathe(profile, print);
}

// Cans stand in rows; bottles too where there is the height, `step` between shelves.
void AddDrinks(AssetBuilder& b, const Fridge& f, float z, float step, Rng& rng) {
  const bool bottles = step > 0.24f && rng.Bernoulli(0.6);
  const float r = bottles ? 0.036f : 0.032f,
              tall = bottles ? std::min(0.23f, step - 0.02f) : std::min(0.12f, step - 0.02f);
  const int columns = static_cast<int>((2 * (f.w - f.wall) - 0.02f) / (2.15f * r)), rows = 2;
  for (int c = 0; c < columns; ++c) {
    for (int k = 0; k < rows; ++k) {
      if (rng.Bernoulli(0.2)) continue;
      const float x = (static_cast<float>(c) - 0.5f * static_cast<float>(columns - 1)) * 2.15f * r,
                  y = f.front - 0.045f - r - 2.2f * r * static_cast<float>(k);
      b.Add(Drink(bottles, r, tall).TurnedZ(Draw(rng, 0, 6.28)).Moved(x, y, z),
            {Slot("drinks", {"glass", "metal"}), Slot("labels", {"picture"})});
    }
  }
}

void AddFridgeShelves(AssetBuilder& b, const Fridge& f, Rng& rng) {
  const float w = f.w, d = f.d, wall = f.wall;
  const float step = (f.high - f.low) / static_cast<float>(f.p.shelves);
  for (int i = 0; i < f.p.shelves; ++i) {
    const float z = f.low + step * static_cast<float>(i) + 0.006f;
    if (i > 0)
      AddWireShelf(b, {-w + wall + 0.002f, -d + wall + 0.01f}, {w - wall - 0.002f, f.front - 0.03f},
                   z, 14);
    if (f.p.full) AddDrinks(b, f, z, step, rng);
  }
}

// A frame around glass, its handle on the right.
void AddFridgeDoor(AssetBuilder& b, const Fridge& f) {
  const float w = f.w, d = f.d, h = f.h, foot = f.foot, front = f.front, edge = 0.045f;
  AddHoledPanel(b, {-w, foot + 0.085f}, {w, h - 0.001f}, {-w + edge, foot + 0.085f + edge},
                {w - edge, h - edge}, front + 0.002f, d,
                Slot("door", {"BrushedMetal", "HousingPlastic"}));
  b.Add(Board({-w + edge - 0.006f, front + 0.014f, foot + 0.079f + edge},
              {w - edge + 0.006f, front + 0.02f, h - edge + 0.006f}, 0.001f),
        Slot("window", {"ClearGlass", "TintedGlass"}));
  b.Add(BarHandle(0.55f * h, 0.04f, 0.009f)
            .TurnedY(0.5f * kPi)
            .Moved(w - 0.5f * edge, d - 0.001f, 0.56f * h),
        TrimSlot());
}

Asset MakeBeverageFridge(const BeverageFridgeParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "contents");
  const Fridge fridge(p);
  AddFridgeBody(b, fridge);
  AddFridgeShelves(b, fridge, rng);
  AddFridgeDoor(b, fridge);
  b.Support({-fridge.w + 0.02f, -fridge.d + 0.02f}, {fridge.w - 0.02f, fridge.front - 0.01f},
            fridge.h);
  return b.Finish();
}

}  // namespace

Asset SampleBeverageFridge(Rng& rng) {
  BeverageFridgeParams p;
  p.width_m = Draw(rng, 0.42, 0.6);
  p.depth_m = Draw(rng, 0.44, 0.58);
  p.height_m = Draw(rng, 0.7, 1.2);
  p.shelves = std::max(2, static_cast<int>(p.height_m / Draw(rng, 0.17, 0.3)));
  p.full = rng.Bernoulli(0.75);
  p.seed = rng.Seed();
  return MakeBeverageFridge(p);
}

}  // namespace parallax
