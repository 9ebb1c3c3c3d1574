#include "worker/assets/windows.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot SashSlot() { return Slot("frame", {"paint", "wood", "plastic"}); }

// A flat frame between two corners: posts and rails, `bar` wide.
void AddSash(AssetBuilder& b, float x0, float x1, float z0, float z1, float y0, float y1,
             float bar) {
  const MaterialSlot slot = SashSlot();
  b.Add(Board({x0, y0, z0}, {x0 + bar, y1, z1}, 0.003f), slot);
  b.Add(Board({x1 - bar, y0, z0}, {x1, y1, z1}, 0.003f), slot);
  b.Add(Board({x0 + bar - 0.003f, y0 + 0.0005f, z0 + 0.0005f},
              {x1 - bar + 0.003f, y1 - 0.0005f, z0 + bar}, 0.003f),
        slot);
  b.Add(Board({x0 + bar - 0.003f, y0 + 0.0005f, z1 - bar},
              {x1 - bar + 0.003f, y1 - 0.0005f, z1 - 0.0005f}, 0.003f),
        slot);
}

// A cloth that hangs in folds between x0 and x1.
Shape Curtain(float x0, float x1, float z0, float z1, float y, const Noise& noise) {
  const float width = x1 - x0;
  const float folds = std::max(3.0f, std::round(width / 0.07f));
  SheetOptions options;
  options.pieces_u = static_cast<int>(folds) * 8;
  options.pieces_v = 14;
  options.thickness_m = 0.003f;
  options.size_m = {1.8f * width, z1 - z0};
  return Sheet(
      [=, &noise](float u, float v) {
        const float sway = 0.35f * noise.At({4 * u, 2 * v, 0.5f});
        const float wave = std::sin(2 * kPi * (folds * u + sway));
        const float deep = 0.028f * (0.75f + 0.35f * (1 - v));
        return Vec3f(Lerp(x0, x1, u) + 0.012f * noise.At({9 * u, 3 * v, 4.5f}), y + deep * wave,
                     Lerp(z0, z1, v));
      },
      options);
}

void AddDressing(AssetBuilder& b, const WindowParams& p, float depth) {
  const float w = 0.5f * p.width_m, h = p.height_m;
  if (p.dressing == WindowDressing::kBlind) {
    // Slats on cords below a head rail.
    const MaterialSlot slats = Slot("blind", {"plastic", "wood", "metal"});
    const float y = depth + 0.03f, low = Lerp(h - 0.06f, 0.08f, p.drawn), pitch = 0.024f;
    b.Add(Board({-w + 0.02f, y - 0.02f, h - 0.05f}, {w - 0.02f, y + 0.02f, h - 0.01f}, 0.004f),
          slats);
    const int count = std::max(2, static_cast<int>((h - 0.06f - low) / pitch));
    for (int i = 0; i < count; ++i) {
      BoxOptions options;
      options.bevel_m = 0.0008f;
      b.Add(RoundedBox({2 * w - 0.05f, 0.026f, 0.0018f}, options)
                .TurnedX(0.45f)
                .Moved(0, y, h - 0.065f - pitch * static_cast<float>(i)),
            slats);
    }
    const float end = h - 0.065f - pitch * static_cast<float>(count);
    b.Add(Board({-w + 0.022f, y - 0.013f, end - 0.008f}, {w - 0.022f, y + 0.013f, end + 0.004f},
                0.003f),
          slats);
    for (const float s : {-0.7f, 0.0f, 0.7f})
      b.Add(Tube({Vec3f(s * w, y, end), Vec3f(s * w, y, h - 0.03f)}, 0.0012f, 0, 6), slats);
  } else if (p.dressing == WindowDressing::kCurtains) {
    const Noise noise(p.seed);
    const float y = depth + 0.06f, reach = 0.12f, top = h + 0.09f, low = -0.16f;
    const float each = Lerp(0.22f, 0.95f, p.drawn) * (w + reach);
    b.Add(Curtain(-w - reach, -w - reach + each, low, top, y, noise), Slot("curtains", {"fabric"}));
    b.Add(Curtain(w + reach - each, w + reach, low, top, y, noise), Slot("curtains", {"fabric"}));
    b.Add(Tube({Vec3f(-w - reach - 0.05f, y, top + 0.012f),
                Vec3f(w + reach + 0.05f, y, top + 0.012f)},
               0.011f, 0.004f, 18),
          MetalSlot("rod"));
    for (const float s : {-1.0f, 1.0f}) {
      b.Add(Ball(0.024f, 20).Moved(s * (w + reach + 0.06f), y, top + 0.012f), MetalSlot("rod"));
      b.Add(Tube({Vec3f(s * (w + 0.03f), 0.0f, top + 0.012f),
                  Vec3f(s * (w + 0.03f), y, top + 0.012f)},
                 0.008f, 0, 12),
            MetalSlot("rod"));
    }
  } else if (p.dressing == WindowDressing::kShutters) {
    const MaterialSlot slot = Slot("shutters", {"wood", "paint"});
    const float leaf = w, bar = 0.04f, thick = 0.026f;
    for (const float s : {-1.0f, 1.0f}) {
      // Folded back beside the window at an angle.
      Shape shutter = Board({0, 0, 0}, {bar, thick, h}, 0.003f);
      shutter.Add(Board({leaf - bar, 0, 0}, {leaf, thick, h}, 0.003f));
      for (const float z : {0.0f, 0.5f * h - 0.5f * bar, h - bar})
        shutter.Add(Board({bar - 0.002f, 0.0005f, z + 0.0005f},
                          {leaf - bar + 0.002f, thick - 0.0005f, z + bar - 0.0005f}, 0.003f));
      const int slats = static_cast<int>(h / 0.045f);
      for (int i = 0; i < slats; ++i) {
        const float z = (static_cast<float>(i) + 0.5f) * h / static_cast<float>(slats);
        BoxOptions options;
        options.bevel_m = 0.0015f;
        shutter.Add(RoundedBox({leaf - 2 * bar + 0.006f, 0.036f, 0.005f}, options)
                        .TurnedX(0.7f)
                        .Moved(0.5f * leaf, 0.5f * thick, z));
      }
      const float open = 0.35f + 0.9f * p.drawn;
      shutter = shutter.TurnedZ(open).Moved(w + 0.003f, depth + 0.004f, 0);
      b.Add(s > 0 ? shutter : shutter.MirroredX(), slot);
    }
  }
}

}  // namespace

Asset MakeWindow(const WindowParams& p) {
  AssetBuilder b(p.seed);
  const float w = 0.5f * p.width_m, h = p.height_m, f = p.frame_m, depth = 0.09f;
  AddSash(b, -w, w, 0, h, 0.0f, depth, f);
  const float inner = 2 * (w - f), each = inner / static_cast<float>(p.sashes), bar = 0.045f;
  for (int i = 0; i < p.sashes; ++i) {
    const float x0 = -w + f + each * static_cast<float>(i) - 0.004f, x1 = x0 + each + 0.008f,
                z0 = f - 0.004f, z1 = h - f + 0.004f;
    const float y0 = 0.025f + (i % 2 ? 0.006f : 0.0f), y1 = y0 + 0.04f;
    AddSash(b, x0, x1, z0, z1, y0, y1, bar);
    b.Add(Board({x0 + bar - 0.006f, y0 + 0.017f, z0 + bar - 0.006f},
                {x1 - bar + 0.006f, y0 + 0.022f, z1 - bar + 0.006f}, 0.0005f),
          Slot("glass", {"ClearGlass", "FrostedGlass"}));
    for (int k = 1; k < p.lites_x; ++k) {
      const float x =
          Lerp(x0 + bar, x1 - bar, static_cast<float>(k) / static_cast<float>(p.lites_x));
      b.Add(Board({x - 0.011f, y0 + 0.008f, z0 + bar - 0.003f},
                  {x + 0.011f, y0 + 0.031f, z1 - bar + 0.003f}, 0.003f),
            SashSlot());
    }
    for (int k = 1; k < p.lites_y; ++k) {
      const float z =
          Lerp(z0 + bar, z1 - bar, static_cast<float>(k) / static_cast<float>(p.lites_y));
      b.Add(Board({x0 + bar - 0.003f, y0 + 0.009f, z - 0.011f},
                  {x1 - bar + 0.003f, y0 + 0.03f, z + 0.011f}, 0.003f),
            SashSlot());
    }
    // A catch in the middle of the inner post.
    const float x = i == 0 ? x1 - 0.5f * bar : x0 + 0.5f * bar;
    b.Add(Board({x - 0.01f, y1 - 0.001f, 0.47f * h}, {x + 0.01f, y1 + 0.006f, 0.53f * h}, 0.002f),
          MetalSlot("catch"));
    b.Add(Tube({Vec3f(x, y1 + 0.004f, 0.5f * h), Vec3f(x, y1 + 0.03f, 0.5f * h),
                Vec3f(x, y1 + 0.034f, 0.5f * h - 0.09f)},
               0.006f, 0.004f, 12),
          MetalSlot("catch"));
  }
  if (p.casing) {
    const float c = 0.08f;
    for (const float s : {-1.0f, 1.0f})
      b.Add(Board({s * (w - 0.01f), depth - 0.012f, -0.001f}, {s * (w + c), depth + 0.008f, h + c},
                  0.004f),
            SashSlot());
    b.Add(Board({-w - c - 0.015f, depth - 0.011f, h - 0.01f},
                {w + c + 0.015f, depth + 0.012f, h + c + 0.01f}, 0.004f),
          SashSlot());
  }
  if (p.sill) {
    b.Add(Board({-w - 0.06f, depth - 0.03f, -0.03f}, {w + 0.06f, depth + 0.1f, 0.004f}, 0.006f),
          Slot("sill", {"wood", "stone", "paint"}));
  }
  AddDressing(b, p, depth + (p.casing ? 0.012f : 0.0f));
  return b.Finish(Anchor::kWall);
}

Asset SampleWindow(Rng& rng) {
  WindowParams p;
  p.width_m = Draw(rng, 0.7, 1.7);
  p.height_m = Draw(rng, 0.9, 1.6);
  p.frame_m = Draw(rng, 0.045, 0.07);
  p.sashes = p.width_m < 0.9f ? 1 : p.width_m < 1.4f ? 2 : rng.UniformInt(2, 3);
  p.lites_x = rng.UniformInt(1, 2);
  p.lites_y = rng.UniformInt(1, 4);
  p.sill = rng.Bernoulli(0.75);
  p.casing = rng.Bernoulli(0.7);
  p.dressing = DrawEnum<WindowDressing>(rng, static_cast<int>(WindowDressing::kCount));
  p.drawn = Draw(rng, 0.1, 0.9);
  p.seed = rng.Seed();
  return MakeWindow(p);
}

// Handles, knobs, hooks and rails as they lie in a shop: on their mounting face.
Asset MakeHardware(const HardwareParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "form");
  const MaterialSlot metal = Slot("metal", {"metal", "plastic"});
  const float size = p.length_m, r = p.rod_m;
  switch (p.form) {
    case 0:  // A square bar on two blocks.
      b.Add(Board({-0.5f * size, 0.03f, -r}, {0.5f * size, 0.03f + 2 * r, r}, 0.0015f), metal);
      for (const float s : {-0.42f, 0.42f})
        b.Add(Board({s * size - 1.4f * r, 0, -1.4f * r}, {s * size + 1.4f * r, 0.032f, 1.4f * r},
                    0.0015f),
              metal);
      break;
    case 1:  // A bow with leaf-shaped ends.
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
        b.Add(Ellipsoid({0.1f * size, 0.005f, 2.2f * r}, 20).Moved(s * 0.45f * size, 0.004f, 0),
              metal);
      break;
    case 2:  // A round bar: towel rail.
      b.Add(Tube({Vec3f(-0.5f * size, 0.05f, 0), Vec3f(0.5f * size, 0.05f, 0)}, r, 0.3f * r, 18),
            metal);
      for (const float s : {-0.46f, 0.46f}) {
        b.Add(Tube({Vec3f(s * size, 0.001f, 0), Vec3f(s * size, 0.05f, 0)}, 0.9f * r, 0, 14),
              metal);
        b.Add(
            Cone(2.6f * r, 2.0f * r, 0.008f, 0.002f, 26).TurnedX(-0.5f * kPi).Moved(s * size, 0, 0),
            metal);
        b.Add(Ball(1.5f * r, 18).Moved(s * size, 0.05f, 0), metal);
      }
      break;
    case 3: {  // A row of hooks on a strip.
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
      break;
    }
    default:  // A lever on its plate.
      b.Add(Board({-0.022f, 0, -0.1f}, {0.022f, 0.005f, 0.1f}, 0.002f), metal);
      b.Add(
          Tube(Filleted(Path3{{0, 0.002f, 0.04f}, {0, 0.05f, 0.04f}, {0.6f * size, 0.052f, 0.036f}},
                        0.018f, 5),
               1.3f * r, r, 18),
          metal);
      b.Add(Cylinder(0.012f, 0.004f, 0.001f, 20).TurnedX(-0.5f * kPi).Moved(0, 0.0035f, -0.045f),
            metal);
      break;
  }
  return b.Finish();
}

Asset SampleHardware(Rng& rng) {
  HardwareParams p;
  p.length_m = Draw(rng, 0.1, 0.3);
  p.rod_m = Draw(rng, 0.005, 0.009);
  p.form = rng.UniformInt(0, 4);
  p.seed = rng.Seed();
  return MakeHardware(p);
}

void RegisterWindows(std::vector<AssetClass>& classes) {
  classes.push_back({"Hardware", "hardware", Placement::kOnTop, true, 0, SampleHardware});
  classes.push_back({"Window", "windows", Placement::kOpening, true, 0, SampleWindow});
}

}  // namespace parallax
