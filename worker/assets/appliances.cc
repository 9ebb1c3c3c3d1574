#include "worker/assets/appliances.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot BodySlot() { return Slot("body", {"ApplianceEnamel", "BrushedMetal", "paint"}); }
MaterialSlot TrimSlot() {
  return Slot("trim", {"BrushedMetal", "HousingPlastic", "PolishedMetal"});
}
MaterialSlot DarkSlot() { return Slot("inside", {"HousingPlastic"}); }
MaterialSlot WindowSlot() { return Slot("window", {"TintedGlass", "ClearGlass"}); }

// A panel in the plane y = `back`, facing +y, with a hole: four rounded bars.
void AddFrame(AssetBuilder& b, const Vec2f& lo, const Vec2f& hi, const Vec2f& hole_lo,
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

// A hollow box open towards +y.
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

// Rods from front to back and one along the front: an oven's or fridge's shelf, top at z.
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

// A control knob on a front in the plane y = `front`.
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

// Round feet under the corners, tops at z.
void AddFeet(AssetBuilder& b, float half_w, float half_d, float z) {
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      b.Add(Cylinder(0.016f, z + 0.002f, 0.003f, 16)
                .Moved(sx * (half_w - 0.05f), sy * (half_d - 0.05f), 0),
            DarkSlot());
    }
  }
}

void AddGasHob(AssetBuilder& b, const OvenParams& p, float d) {
  const MaterialSlot iron = Slot("grates", {"metal"});
  const float h = p.height_m;
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
                .Moved(x, y, h - 0.001f),
            TrimSlot());
    }
    // One grate for each pair of burners: a frame, bars across, short feet.
    const float x0 = sx * 0.25f * p.width_m - 0.21f * p.width_m, x1 = x0 + 0.42f * p.width_m,
                y = 0.82f * d, z = h + 0.033f;
    Shape grate;
    const float t = 0.0055f;
    for (const float at : {-y, 0.0f, y})
      grate.Add(Bar({x0, at, z}, {x1, at, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f));
    for (const float at : {x0, x1})
      grate.Add(Bar({at, -y, z}, {at, y, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f));
    for (const float at : {-0.5f * y, 0.5f * y}) {
      const float mid = 0.5f * (x0 + x1);
      grate.Add(
          Bar({x0, at, z}, {mid - 0.03f, at, z}, {2 * t, 2 * t}, {1.4f * t, 1.6f * t}, 0.002f));
      grate.Add(
          Bar({x1, at, z}, {mid + 0.03f, at, z}, {2 * t, 2 * t}, {1.4f * t, 1.6f * t}, 0.002f));
      const float reach = 0.5f * y - 0.03f;
      for (const float s : {-1.0f, 1.0f}) {
        grate.Add(Bar({mid, at + s * 0.5f * y, z}, {mid, at + s * (0.5f * y - reach), z},
                      {2 * t, 2 * t}, {1.4f * t, 1.6f * t}, 0.002f));
      }
    }
    for (const float fx : {x0, x1}) {
      for (const float fy : {-y, y})
        grate.Add(Bar({fx, fy, h - 0.001f}, {fx, fy, z}, {2 * t, 2 * t}, {2 * t, 2 * t}, 0.002f,
                      Vec3f::UnitY()));
    }
    b.Add(grate, iron);
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

}  // namespace

Asset MakeOven(const OvenParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = BodySlot();
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.height_m;
  const float plinth = 0.05f, drawer = p.drawer ? 0.16f : 0.02f, controls = 0.11f;
  const float door_low = plinth + drawer, door_high = h - controls - 0.02f, front = d - 0.03f;
  AddCavity(b, {-w, -d, plinth}, {w, front, h}, 0.035f, body);
  b.Add(Board({-w + 0.02f, -d + 0.02f, 0}, {w - 0.02f, front - 0.04f, plinth + 0.002f}, 0.002f),
        DarkSlot());
  // Floor of the oven, shelves, the door with its window.
  b.Add(Board({-w + 0.03f, -d + 0.03f, door_low}, {w - 0.03f, front - 0.002f, door_low + 0.02f},
              0.002f),
        DarkSlot());
  b.Add(Board({-w + 0.03f, -d + 0.03f, door_high}, {w - 0.03f, front - 0.002f, h - 0.03f}, 0.002f),
        DarkSlot());
  for (const float t : {0.35f, 0.65f})
    AddWireShelf(b, {-w + 0.036f, -d + 0.05f}, {w - 0.036f, front - 0.02f},
                 Lerp(door_low, door_high, t), 18);
  const float inset = 0.075f;
  AddFrame(b, {-w + 0.002f, door_low + 0.003f}, {w - 0.002f, door_high},
           {-w + inset, door_low + inset}, {w - inset, door_high - 1.35f * inset}, front, d, body);
  b.Add(Board({-w + inset - 0.006f, front + 0.006f, door_low + inset - 0.006f},
              {w - inset + 0.006f, front + 0.012f, door_high - 1.35f * inset + 0.006f}, 0.001f),
        WindowSlot());
  b.Add(BarHandle(1.6f * w, 0.045f, 0.01f).Moved(0, d - 0.001f, door_high - 0.05f), TrimSlot());
  if (p.drawer) {
    b.Add(Board({-w + 0.002f, front, plinth + 0.004f}, {w - 0.002f, d, door_low - 0.002f}, 0.004f),
          body);
    b.Add(Board({-0.5f * w, d - 0.002f, door_low - 0.032f},
                {0.5f * w, d + 0.014f, door_low - 0.018f}, 0.004f),
          TrimSlot());
  }
  // Controls: a panel that leans back, knobs, a clock.
  b.Add(
      Board({-w + 0.002f, front, door_high + 0.004f}, {w - 0.002f, d - 0.004f, h - 0.004f}, 0.004f),
      body);
  for (int i = 0; i < p.knobs; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(p.knobs);
    if (p.knobs % 2 == 1 && i == p.knobs / 2) continue;  // The clock's place.
    b.Add(Knob(0.019f).Moved(Lerp(-w + 0.04f, w - 0.04f, t), d - 0.0045f,
                             h - 0.5f * controls - 0.008f),
          TrimSlot());
  }
  if (p.knobs % 2 == 1)
    b.Add(Board({-0.05f, d - 0.006f, h - 0.085f}, {0.05f, d - 0.002f, h - 0.045f}, 0.001f),
          DarkSlot());
  // Hob.
  b.Add(Board({-w - 0.001f, -d, h - 0.012f}, {w + 0.001f, d - 0.001f, h}, 0.004f), TrimSlot());
  if (p.gas) {
    AddGasHob(b, p, d);
  } else {
    AddGlassHob(b, p, d);
  }
  if (p.backguard) {
    b.Add(Board({-w, -d - 0.001f, h - 0.02f}, {w, -d + 0.035f, h + 0.16f}, 0.005f), body);
    if (!p.gas) {
      for (const float s : {-0.7f, -0.45f, 0.45f, 0.7f})
        b.Add(Knob(0.017f).Moved(s * w, -d + 0.0345f, h + 0.085f), TrimSlot());
      b.Add(Board({-0.2f * w, -d + 0.034f, h + 0.06f}, {0.2f * w, -d + 0.038f, h + 0.12f}, 0.001f),
            DarkSlot());
    }
  }
  return b.Finish();
}

Asset SampleOven(Rng& rng) {
  OvenParams p;
  p.width_m = rng.Bernoulli(0.7) ? Draw(rng, 0.58, 0.62) : Draw(rng, 0.74, 0.9);
  p.depth_m = Draw(rng, 0.56, 0.66);
  p.height_m = Draw(rng, 0.85, 0.92);
  p.gas = rng.Bernoulli(0.55);
  p.backguard = rng.Bernoulli(0.5);
  p.drawer = rng.Bernoulli(0.7);
  p.knobs = rng.UniformInt(4, 7);
  p.seed = rng.Seed();
  return MakeOven(p);
}

Asset MakeMicrowave(const MicrowaveParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = BodySlot();
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, foot = 0.012f, h = p.height_m,
              front = d - 0.028f;
  const float split = w - p.panel_m;
  AddFeet(b, w, d, foot);
  AddCavity(b, {-w, -d, foot}, {split + 0.01f, front, h}, 0.02f, body);
  b.Add(Board({split, -d, foot}, {w, front, h}, 0.004f), body);
  // Turntable and its ring.
  const float cx = 0.5f * (split - w), r = std::min(0.42f * (split + w), 0.42f * p.depth_m);
  b.Add(Lathe(Path2{{0.9f * r, 0}, {r, 0.006f}, {r, 0.009f}, {0.95f * r, 0.006f}, {0.001f, 0.005f}})
            .Moved(cx, -0.01f, foot + 0.028f),
        WindowSlot());
  b.Add(Cylinder(0.02f, 0.014f, 0.002f).Moved(cx, -0.01f, foot + 0.016f), DarkSlot());
  const float edge = 0.035f;
  AddFrame(b, {-w, foot + 0.002f}, {split - 0.0015f, h - 0.002f}, {-w + edge, foot + edge},
           {split - (p.handle ? 1.7f : 1.0f) * edge, h - edge}, front, d, DarkSlot());
  b.Add(Board({-w + edge - 0.005f, front + 0.008f, foot + edge - 0.005f},
              {split - edge + 0.005f, front + 0.014f, h - edge + 0.005f}, 0.001f),
        WindowSlot());
  if (p.handle)
    b.Add(BarHandle(0.7f * h, 0.035f, 0.008f)
              .TurnedY(0.5f * kPi)
              .Moved(split - 0.026f, d - 0.001f, 0.5f * (h + foot)),
          TrimSlot());
  b.Add(Board({split + 0.0005f, front, foot + 0.002f}, {w, d, h - 0.002f}, 0.003f), DarkSlot());
  const float mid = 0.5f * (split + w);
  Shape screen = Board({mid - 0.4f * p.panel_m, d - 0.001f, h - 0.06f},
                       {mid + 0.4f * p.panel_m, d + 0.0015f, h - 0.024f}, 0.001f);
  PrintFaces(screen, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  b.Add(screen, {DarkSlot(), PictureSlot("screen")});
  if (p.keypad) {
    Shape keys;
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 3; ++i) {
        const float x = mid + (static_cast<float>(i) - 1.0f) * 0.27f * p.panel_m,
                    z = h - 0.085f - 0.03f * static_cast<float>(j) * (h / 0.29f);
        keys.Add(Board({x - 0.1f * p.panel_m, d - 0.001f, z - 0.009f},
                       {x + 0.1f * p.panel_m, d + 0.0025f, z + 0.009f}, 0.0012f));
      }
    }
    b.Add(keys, TrimSlot());
  } else {
    for (const float t : {0.3f, 0.6f})
      b.Add(Knob(0.24f * p.panel_m).Moved(mid, d - 0.0005f, foot + t * (h - foot)), TrimSlot());
  }
  b.Support({-w + 0.03f, -d + 0.03f}, {w - 0.03f, front - 0.03f}, h);
  return b.Finish();
}

Asset SampleMicrowave(Rng& rng) {
  MicrowaveParams p;
  p.width_m = Draw(rng, 0.44, 0.56);
  p.depth_m = Draw(rng, 0.32, 0.44);
  p.height_m = Draw(rng, 0.25, 0.32);
  p.panel_m = Draw(rng, 0.09, 0.13);
  p.keypad = rng.Bernoulli(0.65);
  p.handle = rng.Bernoulli(0.6);
  p.seed = rng.Seed();
  return MakeMicrowave(p);
}

Asset MakeDishwasher(const DishwasherParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot body = BodySlot(),
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
  if (p.handle != HandleStyle::kNone) {
    b.Add(BarHandle(0.72f * p.width_m, 0.042f, 0.009f).Moved(0, d - 0.0015f, door_top - 0.045f),
          TrimSlot());
  } else {
    b.Add(Board({-0.3f * p.width_m, d - 0.006f, door_top - 0.03f},
                {0.3f * p.width_m, d + 0.004f, door_top - 0.012f}, 0.003f),
          TrimSlot());
  }
  if (strip > 0) {
    b.Add(Board({-w + 0.002f, front, door_top + 0.003f}, {w - 0.002f, d + 0.002f, h - 0.029f},
                0.004f),
          body);
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
  } else {
    Shape keys;
    for (int i = 0; i < 6; ++i)
      keys.Add(Board({-0.09f + 0.032f * static_cast<float>(i), d - 0.019f, door_top - 0.002f},
                     {-0.07f + 0.032f * static_cast<float>(i), d - 0.009f, door_top + 0.0012f},
                     0.0005f));
    b.Add(keys, TrimSlot());
  }
  b.Support({-w + 0.01f, -d + 0.01f}, {w - 0.01f, d - 0.02f}, h);
  return b.Finish();
}

Asset SampleDishwasher(Rng& rng) {
  DishwasherParams p;
  p.width_m = rng.Bernoulli(0.75) ? Draw(rng, 0.585, 0.61) : Draw(rng, 0.44, 0.46);
  p.depth_m = Draw(rng, 0.54, 0.62);
  p.height_m = Draw(rng, 0.81, 0.88);
  p.hidden_controls = rng.Bernoulli(0.4);
  p.handle = rng.Bernoulli(0.75) ? HandleStyle::kBar : HandleStyle::kNone;
  p.front = rng.Bernoulli(0.7) ? FrontStyle::kFlat : FrontStyle::kShaker;
  p.seed = rng.Seed();
  return MakeDishwasher(p);
}

Asset MakeBeverageFridge(const BeverageFridgeParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "contents");
  const MaterialSlot body = BodySlot();
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.height_m, foot = 0.02f,
              wall = 0.035f, front = d - 0.04f;
  AddFeet(b, w, d, foot);
  AddCavity(b, {-w, -d, foot}, {w, front, h}, wall, body);
  const float low = foot + 0.09f, high = h - wall;
  // A light liner, so that one sees what is inside.
  AddCavity(b, {-w + wall - 0.001f, -d + wall - 0.001f, low - 0.002f},
            {w - wall + 0.001f, front - 0.004f, high + 0.001f}, 0.004f,
            Slot("liner", {"ApplianceEnamel"}));
  b.Add(Board({-w + 0.03f, -d + 0.03f, foot + 0.03f}, {w - 0.03f, front - 0.001f, low}, 0.002f),
        DarkSlot());
  Shape slots;
  for (int i = 0; i < 9; ++i)
    slots.Add(Board({-0.6f * w, front - 0.002f, foot + 0.034f + 0.005f * static_cast<float>(i)},
                    {0.6f * w, front + 0.002f, foot + 0.0365f + 0.005f * static_cast<float>(i)},
                    0.0004f));
  b.Add(slots, TrimSlot());
  const float step = (high - low) / static_cast<float>(p.shelves);
  for (int i = 0; i < p.shelves; ++i) {
    const float z = low + step * static_cast<float>(i) + 0.006f;
    if (i > 0)
      AddWireShelf(b, {-w + wall + 0.002f, -d + wall + 0.01f}, {w - wall - 0.002f, front - 0.03f},
                   z, 14);
    if (!p.full) continue;
    // Cans stand in rows; bottles too where there is the height.
    const bool bottles = step > 0.24f && rng.Bernoulli(0.6);
    const float r = bottles ? 0.036f : 0.032f,
                tall = bottles ? std::min(0.23f, step - 0.02f) : std::min(0.12f, step - 0.02f);
    const int columns = static_cast<int>((2 * (w - wall) - 0.02f) / (2.15f * r)), rows = 2;
    for (int c = 0; c < columns; ++c) {
      for (int k = 0; k < rows; ++k) {
        if (rng.Bernoulli(0.2)) continue;
        const float x = (static_cast<float>(c) - 0.5f * static_cast<float>(columns - 1)) * 2.15f *
                        r,
                    y = front - 0.045f - r - 2.2f * r * static_cast<float>(k);
        LatheOptions print;
        print.segments = 24;
        print.print_repeats = 2;
        print.print_from_z = 0.02f;
        print.print_to_z = 0.6f * tall;
        const Path2 profile = bottles ? Path2{{0.9f * r, 0},
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
        b.Add(Lathe(profile, print).TurnedZ(Draw(rng, 0, 6.28)).Moved(x, y, z),
              {Slot("drinks", {"glass", "metal"}), Slot("labels", {"picture"})});
      }
    }
  }
  // The door: a frame around glass, its handle on the right.
  const float edge = 0.045f;
  AddFrame(b, {-w, foot + 0.085f}, {w, h - 0.001f}, {-w + edge, foot + 0.085f + edge},
           {w - edge, h - edge}, front + 0.002f, d,
           Slot("door", {"BrushedMetal", "HousingPlastic"}));
  b.Add(Board({-w + edge - 0.006f, front + 0.014f, foot + 0.079f + edge},
              {w - edge + 0.006f, front + 0.02f, h - edge + 0.006f}, 0.001f),
        Slot("window", {"ClearGlass", "TintedGlass"}));
  b.Add(BarHandle(0.55f * h, 0.04f, 0.009f)
            .TurnedY(0.5f * kPi)
            .Moved(w - 0.5f * edge, d - 0.001f, 0.56f * h),
        TrimSlot());
  b.Support({-w + 0.02f, -d + 0.02f}, {w - 0.02f, front - 0.01f}, h);
  return b.Finish();
}

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

void RegisterAppliances(std::vector<AssetClass>& classes) {
  classes.push_back({"BeverageFridge", "appliances", Placement::kFloorAgainstWall, true, 0.6f,
                     SampleBeverageFridge});
  classes.push_back(
      {"Dishwasher", "appliances", Placement::kFloorAgainstWall, true, 0.6f, SampleDishwasher});
  classes.push_back({"Microwave", "appliances", Placement::kOnTop, true, 0, SampleMicrowave});
  classes.push_back({"Oven", "appliances", Placement::kFloorAgainstWall, true, 0.7f, SampleOven});
}

}  // namespace parallax
