#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/appliance_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A cooker: an oven below a hob. With `backguard`, a panel rises behind the hob.
struct OvenParams {
  float width_m = 0.6f;
  float depth_m = 0.6f;
  float height_m = 0.88f;  // Height of the hob above the floor.
  bool gas = true;         // Grates and burners instead of a glass hob.
  bool backguard = true;   // A panel behind the hob.
  bool drawer = true;      // Under the oven door.
  int knobs = 5;
  uint64_t seed = 0;
};

// One grate for each pair of burners: a frame, bars across, short feet.
Shape Grate(const OvenParams& p, float d, float sx) {
  const float x0 = sx * 0.25f * p.width_m - 0.21f * p.width_m, x1 = x0 + 0.42f * p.width_m,
              y = 0.82f * d, h = p.height_m, z = h + 0.033f, t = 0.0055f;
  Shape grate;
  for (const float at : {-y, 0.0f, y})
    grate.Add(Bar({x0, at, z}, {x1, at, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f));
  for (const float at : {x0, x1})
    grate.Add(Bar({at, -y, z}, {at, y, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f));
  const auto finger = [&](const Vec3f& from, const Vec3f& to) {
    grate.Add(Bar(from, to, {2 * t, 2 * t}, {1.4f * t, 1.6f * t}, 0.002f));
  };
  for (const float at : {-0.5f * y, 0.5f * y}) {
    const float mid = 0.5f * (x0 + x1), reach = 0.5f * y - 0.03f;
    finger({x0, at, z}, {mid - 0.03f, at, z});
    finger({x1, at, z}, {mid + 0.03f, at, z});
    for (const float s : {-1.0f, 1.0f})
      finger({mid, at + s * 0.5f * y, z}, {mid, at + s * (0.5f * y - reach), z});
  }
  for (const float fx : {x0, x1}) {
    for (const float fy : {-y, y})
      grate.Add(Bar({fx, fy, h - 0.001f}, {fx, fy, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f,
                    Vec3f::UnitY()));
  }
  return grate;
}

void AddGasHob(AssetBuilder& b, const OvenParams& p, float d) {
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const float x = sx * 0.25f * p.width_m, y = sy * 0.42f * d;
      const float r = sx * sy > 0 ? 0.036f : 0.048f;
      b.Add(Lathe(Path2{{1.5f * r, 0},
                        {1.5f * r, 0.003f},
                        {r, 0.006f},
                        {r, 0.014f},
                        {0.9f * r, 0.017f},
                        {0.001f, 0.018f}})
                .Moved(x, y, p.height_m - 0.001f),
            TrimSlot());
    }
    b.Add(Grate(p, d, sx), Slot("grates", {"metal"}));
  }
}

void AddGlassHob(AssetBuilder& b, const OvenParams& p, float d) {
  const float h = p.height_m;
  b.Add(Board({-0.5f * p.width_m + 0.008f, -d + 0.01f, h - 0.001f},
              {0.5f * p.width_m - 0.008f, d - 0.01f, h + 0.005f}, 0.002f),
        DarkSlot());
  int k = 0;
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const float r = (k++ % 3 == 0) ? 0.105f : 0.08f;
      for (const float s : {1.0f, 0.62f}) {
        b.Add(LatheRing(Path2{{s * r - 0.0015f, 0.0f},
                              {s * r + 0.0015f, 0.0f},
                              {s * r + 0.0015f, 0.0006f},
                              {s * r - 0.0015f, 0.0006f}},
                        48)
                  .Moved(sx * 0.24f * p.width_m, sy * 0.44f * d, h + 0.0047f),
              TrimSlot());
      }
    }
  }
}

// Dimensions that the parts of an oven share: half width and depth, height; upper edge of the
// plinth; lower and upper edge of the door, its back.
struct Oven {
  explicit Oven(const OvenParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        h(params.height_m),
        door_low(plinth + (params.drawer ? 0.16f : 0.02f)),
        door_high(h - controls - 0.02f),
        front(d - 0.03f) {}
  const OvenParams& p;
  const float w, d, h, plinth = 0.05f, controls = 0.11f, door_low, door_high, front;
  const MaterialSlot body = HousingSlot();
};

// The housing, the floor and ceiling of the oven, two shelves.
void AddOvenBody(AssetBuilder& b, const Oven& o) {
  const float w = o.w, d = o.d, h = o.h, plinth = o.plinth, front = o.front;
  AddCavity(b, {-w, -d, plinth}, {w, front, h}, 0.035f, o.body);
  b.Add(Board({-w + 0.02f, -d + 0.02f, 0}, {w - 0.02f, front - 0.04f, plinth + 0.002f}, 0.002f),
        DarkSlot());
  b.Add(Board({-w + 0.03f, -d + 0.03f, o.door_low}, {w - 0.03f, front - 0.002f, o.door_low + 0.02f},
              0.002f),
        DarkSlot());
  b.Add(
      Board({-w + 0.03f, -d + 0.03f, o.door_high}, {w - 0.03f, front - 0.002f, h - 0.03f}, 0.002f),
      DarkSlot());
  for (const float t : {0.35f, 0.65f})
    AddWireShelf(b, {-w + 0.036f, -d + 0.05f}, {w - 0.036f, front - 0.02f},
                 Lerp(o.door_low, o.door_high, t), 18);
}

// A frame with a window and a handle.
void AddOvenDoor(AssetBuilder& b, const Oven& o) {
  const float w = o.w, door_low = o.door_low, door_high = o.door_high, inset = 0.075f;
  AddHoledPanel(b, {-w + 0.002f, door_low + 0.003f}, {w - 0.002f, door_high},
                {-w + inset, door_low + inset}, {w - inset, door_high - 1.35f * inset}, o.front,
                o.d, o.body);
  b.Add(Board({-w + inset - 0.006f, o.front + 0.006f, door_low + inset - 0.006f},
              {w - inset + 0.006f, o.front + 0.012f, door_high - 1.35f * inset + 0.006f}, 0.001f),
        WindowSlot());
  b.Add(BarHandle(1.6f * w, 0.045f, 0.01f).Moved(0, o.d - 0.001f, door_high - 0.05f), TrimSlot());
}

void AddOvenDrawer(AssetBuilder& b, const Oven& o) {
  const float w = o.w, d = o.d;
  b.Add(Board({-w + 0.002f, o.front, o.plinth + 0.004f}, {w - 0.002f, d, o.door_low - 0.002f},
              0.004f),
        o.body);
  b.Add(Board({-0.5f * w, d - 0.002f, o.door_low - 0.032f},
              {0.5f * w, d + 0.014f, o.door_low - 0.018f}, 0.004f),
        TrimSlot());
}

// A panel with knobs, and a clock in their middle where their number is odd.
void AddOvenControls(AssetBuilder& b, const Oven& o) {
  const float w = o.w, d = o.d, h = o.h;
  b.Add(Board({-w + 0.002f, o.front, o.door_high + 0.004f}, {w - 0.002f, d - 0.004f, h - 0.004f},
              0.004f),
        o.body);
  for (int i = 0; i < o.p.knobs; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(o.p.knobs);
    if (o.p.knobs % 2 == 1 && i == o.p.knobs / 2) continue;
    b.Add(Knob(0.019f).Moved(Lerp(-w + 0.04f, w - 0.04f, t), d - 0.0045f,
                             h - 0.5f * o.controls - 0.008f),
          TrimSlot());
  }
  if (o.p.knobs % 2 == 1)
    b.Add(Board({-0.05f, d - 0.006f, h - 0.085f}, {0.05f, d - 0.002f, h - 0.045f}, 0.001f),
          DarkSlot());
}

// The panel behind the hob; it has knobs where the hob is of glass.
void AddBackguard(AssetBuilder& b, const Oven& o) {
  const float w = o.w, d = o.d, h = o.h;
  b.Add(Board({-w, -d - 0.001f, h - 0.02f}, {w, -d + 0.035f, h + 0.16f}, 0.005f), o.body);
  if (o.p.gas) return;
  for (const float s : {-0.7f, -0.45f, 0.45f, 0.7f})
    b.Add(Knob(0.017f).Moved(s * w, -d + 0.0345f, h + 0.085f), TrimSlot());
  b.Add(Board({-0.2f * w, -d + 0.034f, h + 0.06f}, {0.2f * w, -d + 0.038f, h + 0.12f}, 0.001f),
        DarkSlot());
}

Asset MakeOven(const OvenParams& p) {
  AssetBuilder b(p.seed);
  const Oven oven(p);
  const float w = oven.w, d = oven.d, h = oven.h;
  AddOvenBody(b, oven);
  AddOvenDoor(b, oven);
  if (p.drawer) AddOvenDrawer(b, oven);
  AddOvenControls(b, oven);
  b.Add(Board({-w - 0.001f, -d, h - 0.012f}, {w + 0.001f, d - 0.001f, h}, 0.004f), TrimSlot());
  p.gas ? AddGasHob(b, p, d) : AddGlassHob(b, p, d);
  if (p.backguard) AddBackguard(b, oven);
  return b.Finish();
}

}  // namespace

Asset SampleOven(Rng& rng) {
  return MakeOven({.width_m = rng.Bernoulli(0.7) ? Draw(rng, 0.58, 0.62) : Draw(rng, 0.74, 0.9),
                   .depth_m = Draw(rng, 0.56, 0.66),
                   .height_m = Draw(rng, 0.85, 0.92),
                   .gas = rng.Bernoulli(0.55),
                   .backguard = rng.Bernoulli(0.5),
                   .drawer = rng.Bernoulli(0.7),
                   .knobs = rng.UniformInt(4, 7),
                   .seed = rng.Seed()});
}

}  // namespace parallax
