#include "worker/assets/building/windows.h"

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

// Slats on cords below a head rail.
void AddBlind(AssetBuilder& b, const WindowParams& p, float depth) {
  const MaterialSlot slats = Slot("blind", {"plastic", "wood", "metal"});
  const float w = 0.5f * p.width_m, h = p.height_m;
  const float y = depth + 0.03f, low = Lerp(h - 0.06f, 0.08f, p.drawn), pitch = 0.024f;
  b.Add(Board({-w + 0.02f, y - 0.02f, h - 0.05f}, {w - 0.02f, y + 0.02f, h - 0.01f}, 0.004f),
        slats);
  const int count = std::max(2, static_cast<int>((h - 0.06f - low) / pitch));
  for (int i = 0; i < count; ++i) {
    b.Add(RoundedBox({2 * w - 0.05f, 0.026f, 0.0018f}, {.bevel_m = 0.0008f})
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
}

// Two cloths on a rod with knobs and brackets.
void AddCurtains(AssetBuilder& b, const WindowParams& p, float depth) {
  const float w = 0.5f * p.width_m, h = p.height_m;
  const Noise noise(p.seed);
  const float y = depth + 0.06f, reach = 0.12f, top = h + 0.09f, low = -0.16f;
  const float each = Lerp(0.22f, 0.95f, p.drawn) * (w + reach);
  b.Add(Curtain(-w - reach, -w - reach + each, low, top, y, noise), Slot("curtains", {"fabric"}));
  b.Add(Curtain(w + reach - each, w + reach, low, top, y, noise), Slot("curtains", {"fabric"}));
  b.Add(
      Tube({Vec3f(-w - reach - 0.05f, y, top + 0.012f), Vec3f(w + reach + 0.05f, y, top + 0.012f)},
           0.011f, 0.004f, 18),
      MetalSlot("rod"));
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Ball(0.024f, 20).Moved(s * (w + reach + 0.06f), y, top + 0.012f), MetalSlot("rod"));
    b.Add(
        Tube({Vec3f(s * (w + 0.03f), 0.0f, top + 0.012f), Vec3f(s * (w + 0.03f), y, top + 0.012f)},
             0.008f, 0, 12),
        MetalSlot("rod"));
  }
}

// A louvred leaf in the plane y = 0, hinged at x = 0.
Shape Shutter(float leaf, float h) {
  const float bar = 0.04f, thick = 0.026f;
  Shape shutter = Board({0, 0, 0}, {bar, thick, h}, 0.003f);
  shutter.Add(Board({leaf - bar, 0, 0}, {leaf, thick, h}, 0.003f));
  for (const float z : {0.0f, 0.5f * h - 0.5f * bar, h - bar})
    shutter.Add(Board({bar - 0.002f, 0.0005f, z + 0.0005f},
                      {leaf - bar + 0.002f, thick - 0.0005f, z + bar - 0.0005f}, 0.003f));
  const int slats = static_cast<int>(h / 0.045f);
  for (int i = 0; i < slats; ++i) {
    const float z = (static_cast<float>(i) + 0.5f) * h / static_cast<float>(slats);
    shutter.Add(RoundedBox({leaf - 2 * bar + 0.006f, 0.036f, 0.005f}, {.bevel_m = 0.0015f})
                    .TurnedX(0.7f)
                    .Moved(0.5f * leaf, 0.5f * thick, z));
  }
  return shutter;
}

// Folded back beside the window at an angle.
void AddShutters(AssetBuilder& b, const WindowParams& p, float depth) {
  const MaterialSlot slot = Slot("shutters", {"wood", "paint"});
  const float w = 0.5f * p.width_m, open = 0.35f + 0.9f * p.drawn;
  const Shape shutter = Shutter(w, p.height_m).TurnedZ(open).Moved(w + 0.003f, depth + 0.004f, 0);
  for (const float s : {-1.0f, 1.0f}) b.Add(s > 0 ? shutter : shutter.MirroredX(), slot);
}

void AddDressing(AssetBuilder& b, const WindowParams& p, float depth) {
  if (p.dressing == WindowDressing::kBlind) AddBlind(b, p, depth);
  if (p.dressing == WindowDressing::kCurtains) AddCurtains(b, p, depth);
  if (p.dressing == WindowDressing::kShutters) AddShutters(b, p, depth);
}

// The corners of a casement in the plane of the wall and its depth.
struct Casement {
  float x0, x1, z0, z1, y0, y1;
};
constexpr float kCasementBar = 0.045f;

// Glass, and the bars that divide it.
void AddLites(AssetBuilder& b, const WindowParams& p, const Casement& c) {
  const float bar = kCasementBar, x0 = c.x0, x1 = c.x1, z0 = c.z0, z1 = c.z1, y0 = c.y0;
  b.Add(Board({x0 + bar - 0.006f, y0 + 0.017f, z0 + bar - 0.006f},
              {x1 - bar + 0.006f, y0 + 0.022f, z1 - bar + 0.006f}, 0.0005f),
        Slot("glass", {"ClearGlass", "FrostedGlass"}));
  for (int k = 1; k < p.lites_x; ++k) {
    const float x = Lerp(x0 + bar, x1 - bar, static_cast<float>(k) / static_cast<float>(p.lites_x));
    b.Add(Board({x - 0.011f, y0 + 0.008f, z0 + bar - 0.003f},
                {x + 0.011f, y0 + 0.031f, z1 - bar + 0.003f}, 0.003f),
          SashSlot());
  }
  for (int k = 1; k < p.lites_y; ++k) {
    const float z = Lerp(z0 + bar, z1 - bar, static_cast<float>(k) / static_cast<float>(p.lites_y));
    b.Add(Board({x0 + bar - 0.003f, y0 + 0.009f, z - 0.011f},
                {x1 - bar + 0.003f, y0 + 0.03f, z + 0.011f}, 0.003f),
          SashSlot());
  }
}

// A catch at the middle of a post at `x`, inside of y = `y1`.
void AddCatch(AssetBuilder& b, float x, float y1, float h) {
  b.Add(Board({x - 0.01f, y1 - 0.001f, 0.47f * h}, {x + 0.01f, y1 + 0.006f, 0.53f * h}, 0.002f),
        MetalSlot("catch"));
  b.Add(Tube({Vec3f(x, y1 + 0.004f, 0.5f * h), Vec3f(x, y1 + 0.03f, 0.5f * h),
              Vec3f(x, y1 + 0.034f, 0.5f * h - 0.09f)},
             0.006f, 0.004f, 12),
        MetalSlot("catch"));
}

// Casements side by side in the frame, every second set back a little.
void AddCasements(AssetBuilder& b, const WindowParams& p) {
  const float w = 0.5f * p.width_m, h = p.height_m, f = p.frame_m, bar = kCasementBar;
  const float inner = 2 * (w - f), each = inner / static_cast<float>(p.sashes);
  for (int i = 0; i < p.sashes; ++i) {
    const float x0 = -w + f + each * static_cast<float>(i) - 0.004f, x1 = x0 + each + 0.008f;
    const float y0 = 0.025f + (i % 2 ? 0.006f : 0.0f), y1 = y0 + 0.04f;
    const Casement c{x0, x1, f - 0.004f, h - f + 0.004f, y0, y1};
    AddSash(b, x0, x1, c.z0, c.z1, y0, y1, bar);
    AddLites(b, p, c);
    AddCatch(b, i == 0 ? x1 - 0.5f * bar : x0 + 0.5f * bar, y1, h);
  }
}

// Boards round the opening on the inside.
void AddCasing(AssetBuilder& b, const WindowParams& p, float depth) {
  const float w = 0.5f * p.width_m, h = p.height_m, c = 0.08f;
  for (const float s : {-1.0f, 1.0f})
    b.Add(Board({s * (w - 0.01f), depth - 0.012f, -0.001f}, {s * (w + c), depth + 0.008f, h + c},
                0.004f),
          SashSlot());
  b.Add(Board({-w - c - 0.015f, depth - 0.011f, h - 0.01f},
              {w + c + 0.015f, depth + 0.012f, h + c + 0.01f}, 0.004f),
        SashSlot());
}

}  // namespace

Asset MakeWindow(const WindowParams& p) {
  AssetBuilder b(p.seed);
  const float w = 0.5f * p.width_m, depth = 0.09f;
  AddSash(b, -w, w, 0, p.height_m, 0.0f, depth, p.frame_m);
  AddCasements(b, p);
  if (p.casing) AddCasing(b, p, depth);
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

void RegisterWindows(std::vector<AssetClass>& classes) {
  classes.push_back({"Hardware", "hardware", Placement::kOnTop, true, 0, SampleHardware,
                     SizeRange({0.05f, 0.03f, 0.008f}, {0.36f, 0.08f, 0.21f})});
  classes.push_back({"Window", "windows", Placement::kOpening, true, 0, SampleWindow,
                     SizeRange({0.6f, 0.08f, 0.85f}, {3.6f, 1.0f, 1.95f})});
}

}  // namespace parallax
