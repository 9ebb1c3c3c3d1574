// Kitchen machines: ovens with hobs, microwaves, dishwashers, beverage fridges. Fronts face +y.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/appliance_parts.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A microwave oven with its controls beside the door.
struct MicrowaveParams {
  float width_m = 0.5f;
  float depth_m = 0.38f;
  float height_m = 0.29f;
  float panel_m = 0.11f;  // Width of the controls beside the door.
  bool keypad = true;     // Else two knobs.
  bool handle = true;
  uint64_t seed = 0;
};

// Dimensions that the parts of a microwave share: half width and depth, height, the feet's height;
// the door's back; where the controls begin.
struct Microwave {
  explicit Microwave(const MicrowaveParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        h(params.height_m),
        front(d - 0.028f),
        split(w - params.panel_m) {}
  const MicrowaveParams& p;
  const float w, d, h, foot = 0.012f, front, split;
};

void AddTurntable(AssetBuilder& b, const Microwave& m) {
  const float cx = 0.5f * (m.split - m.w),
              r = std::min(0.42f * (m.split + m.w), 0.42f * m.p.depth_m);
  b.Add(Lathe(Path2{{0.9f * r, 0}, {r, 0.006f}, {r, 0.009f}, {0.95f * r, 0.006f}, {0.001f, 0.005f}})
            .Moved(cx, -0.01f, m.foot + 0.028f),
        WindowSlot());
  b.Add(Cylinder(0.02f, 0.014f, 0.002f).Moved(cx, -0.01f, m.foot + 0.016f), DarkSlot());
}

void AddMicrowaveDoor(AssetBuilder& b, const Microwave& m) {
  const float w = m.w, d = m.d, h = m.h, foot = m.foot, front = m.front, split = m.split,
              edge = 0.035f;
  AddHoledPanel(b, {-w, foot + 0.002f}, {split - 0.0015f, h - 0.002f}, {-w + edge, foot + edge},
                {split - (m.p.handle ? 1.7f : 1.0f) * edge, h - edge}, front, d, DarkSlot());
  b.Add(Board({-w + edge - 0.005f, front + 0.008f, foot + edge - 0.005f},
              {split - edge + 0.005f, front + 0.014f, h - edge + 0.005f}, 0.001f),
        WindowSlot());
  if (m.p.handle)
    b.Add(BarHandle(0.7f * h, 0.035f, 0.008f)
              .TurnedY(0.5f * kPi)
              .Moved(split - 0.026f, d - 0.001f, 0.5f * (h + foot)),
          TrimSlot());
}

// Five rows of three keys about x = `mid`.
Shape Keypad(const Microwave& m, float mid) {
  const float panel_m = m.p.panel_m;
  Shape keys;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 3; ++i) {
      const float x = mid + (static_cast<float>(i) - 1.0f) * 0.27f * panel_m,
                  z = m.h - 0.085f - 0.03f * static_cast<float>(j) * (m.h / 0.29f);
      keys.Add(Board({x - 0.1f * panel_m, m.d - 0.001f, z - 0.009f},
                     {x + 0.1f * panel_m, m.d + 0.0025f, z + 0.009f}, 0.0012f));
    }
  }
  return keys;
}

// A panel with a screen, and keys or two knobs.
void AddMicrowaveControls(AssetBuilder& b, const Microwave& m) {
  const float d = m.d, h = m.h, foot = m.foot, panel_m = m.p.panel_m;
  b.Add(Board({m.split + 0.0005f, m.front, foot + 0.002f}, {m.w, d, h - 0.002f}, 0.003f),
        DarkSlot());
  const float mid = 0.5f * (m.split + m.w);
  Shape screen = Board({mid - 0.4f * panel_m, d - 0.001f, h - 0.06f},
                       {mid + 0.4f * panel_m, d + 0.0015f, h - 0.024f}, 0.001f);
  PrintFaces(screen, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  b.Add(screen, {DarkSlot(), PictureSlot("screen")});
  if (m.p.keypad) {
    b.Add(Keypad(m, mid), TrimSlot());
  } else {
    for (const float t : {0.3f, 0.6f})
      b.Add(Knob(0.24f * panel_m).Moved(mid, d - 0.0005f, foot + t * (h - foot)), TrimSlot());
  }
}

Asset MakeMicrowave(const MicrowaveParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = HousingSlot();
  const Microwave oven(p);
  const float w = oven.w, d = oven.d, h = oven.h, foot = oven.foot, front = oven.front;
  AddFeet(b, w, d, foot);
  AddCavity(b, {-w, -d, foot}, {oven.split + 0.01f, front, h}, 0.02f, body);
  b.Add(Board({oven.split, -d, foot}, {w, front, h}, 0.004f), body);
  AddTurntable(b, oven);
  AddMicrowaveDoor(b, oven);
  AddMicrowaveControls(b, oven);
  b.Support({-w + 0.03f, -d + 0.03f}, {w - 0.03f, front - 0.03f}, h);
  return b.Finish();
}

Asset SampleMicrowave(Rng& rng) {
  return MakeMicrowave({.width_m = Draw(rng, 0.44, 0.56),
                        .depth_m = Draw(rng, 0.32, 0.44),
                        .height_m = Draw(rng, 0.25, 0.32),
                        .panel_m = Draw(rng, 0.09, 0.13),
                        .keypad = rng.Bernoulli(0.65),
                        .handle = rng.Bernoulli(0.6),
                        .seed = rng.Seed()});
}

// A built-in dishwasher.
struct DishwasherParams {
  float width_m = 0.6f;
  float depth_m = 0.58f;
  float height_m = 0.84f;
  bool hidden_controls = false;  // On the door's upper edge.
  HandleStyle handle = HandleStyle::kBar;
  FrontStyle front = FrontStyle::kFlat;
  uint64_t seed = 0;
};

// A bar on the door, or a grip in its upper edge.
void AddDishwasherHandle(AssetBuilder& b, const DishwasherParams& p, float door_top) {
  const float d = 0.5f * p.depth_m;
  if (p.handle != HandleStyle::kNone) {
    b.Add(BarHandle(0.72f * p.width_m, 0.042f, 0.009f).Moved(0, d - 0.0015f, door_top - 0.045f),
          TrimSlot());
  } else {
    b.Add(Board({-0.3f * p.width_m, d - 0.006f, door_top - 0.03f},
                {0.3f * p.width_m, d + 0.004f, door_top - 0.012f}, 0.003f),
          TrimSlot());
  }
}

// A panel above the door with a display, buttons and a knob.
void AddControlStrip(AssetBuilder& b, const DishwasherParams& p, float door_top, float strip) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, front = d - 0.025f;
  b.Add(Board({-w + 0.002f, front, door_top + 0.003f},
              {w - 0.002f, d + 0.002f, p.height_m - 0.029f}, 0.004f),
        HousingSlot());
  const float z = door_top + 0.5f * strip;
  b.Add(Board({-0.04f, d + 0.001f, z - 0.014f}, {0.04f, d + 0.0035f, z + 0.014f}, 0.001f),
        DarkSlot());
  Shape buttons;
  for (int i = 0; i < 5; ++i)
    buttons.Add(Cylinder(0.007f, 0.006f, 0.0015f, 16)
                    .TurnedX(-0.5f * kPi)
                    .Moved(0.08f + 0.028f * static_cast<float>(i), d + 0.001f, z));
  b.Add(buttons, TrimSlot());
  b.Add(Knob(0.02f).Moved(-w + 0.07f, d + 0.0015f, z), TrimSlot());
}

// Keys on the upper edge of the door.
void AddHiddenKeys(AssetBuilder& b, float d, float door_top) {
  Shape keys;
  for (int i = 0; i < 6; ++i)
    keys.Add(Board({-0.09f + 0.032f * static_cast<float>(i), d - 0.019f, door_top - 0.002f},
                   {-0.07f + 0.032f * static_cast<float>(i), d - 0.009f, door_top + 0.0012f},
                   0.0005f));
  b.Add(keys, TrimSlot());
}

Asset MakeDishwasher(const DishwasherParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = HousingSlot(),
                     door = Slot("door", {"BrushedMetal", "ApplianceEnamel", "wood"});
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.height_m, plinth = 0.1f,
              front = d - 0.025f;
  const float strip = p.hidden_controls ? 0.0f : 0.11f;
  b.Add(Board({-w, -d, plinth - 0.01f}, {w, front, h - 0.025f}, 0.003f), body);
  b.Add(Board({-w + 0.01f, -d + 0.02f, 0}, {w - 0.01f, front - 0.05f, plinth}, 0.002f), DarkSlot());
  b.Add(Board({-w - 0.002f, -d, h - 0.026f}, {w + 0.002f, d - 0.004f, h}, 0.004f), body);
  b.Add(Front(p.front, p.width_m - 0.004f, h - 0.03f - strip - plinth - 0.003f, 0.024f, true)
            .Moved(0, front, plinth + 0.002f),
        door);
  const float door_top = h - 0.03f - strip;
  AddDishwasherHandle(b, p, door_top);
  strip > 0 ? AddControlStrip(b, p, door_top, strip) : AddHiddenKeys(b, d, door_top);
  b.Support({-w + 0.01f, -d + 0.01f}, {w - 0.01f, d - 0.02f}, h);
  return b.Finish();
}

Asset SampleDishwasher(Rng& rng) {
  return MakeDishwasher(
      {.width_m = rng.Bernoulli(0.75) ? Draw(rng, 0.585, 0.61) : Draw(rng, 0.44, 0.46),
       .depth_m = Draw(rng, 0.54, 0.62),
       .height_m = Draw(rng, 0.81, 0.88),
       .hidden_controls = rng.Bernoulli(0.4),
       .handle = rng.Bernoulli(0.75) ? HandleStyle::kBar : HandleStyle::kNone,
       .front = rng.Bernoulli(0.7) ? FrontStyle::kFlat : FrontStyle::kShaker,
       .seed = rng.Seed()});
}

}  // namespace

void RegisterAppliances(std::vector<AssetClass>& classes) {
  classes.push_back({"BeverageFridge", "appliances", Placement::kFloorAgainstWall, true, 0.6f,
                     SampleBeverageFridge, SizeRange({0.4f, 0.45f, 0.65f}, {0.65f, 0.7f, 1.25f})});
  classes.push_back({"Dishwasher", "appliances", Placement::kFloorAgainstWall, true, 0.6f,
                     SampleDishwasher, SizeRange({0.42f, 0.52f, 0.78f}, {0.64f, 0.72f, 0.9f})});
  classes.push_back({"Microwave", "appliances", Placement::kOnTop, true, 0, SampleMicrowave,
                     SizeRange({0.42f, 0.3f, 0.22f}, {0.6f, 0.52f, 0.35f})});
  classes.push_back({"Oven", "appliances", Placement::kFloorAgainstWall, true, 0.7f, SampleOven,
                     SizeRange({0.55f, 0.55f, 0.84f}, {0.95f, 0.78f, 1.12f})});
}

}  // namespace parallax
