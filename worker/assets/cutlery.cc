#include <algorithm>
#include <cmath>

#include "worker/assets/packages.h"
#include "worker/assets/tableware.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A flat piece of cutlery: a sheet along +y whose half width and height are functions of s in [0,
// 1].
Shape Blade(float length, const std::function<float(float)>& half_width,
            const std::function<float(float, float)>& height, float thickness, int pieces = 60,
            int across = 10) {
  SheetOptions sheet;
  sheet.pieces_u = across;
  sheet.pieces_v = pieces;
  sheet.thickness_m = thickness;
  sheet.size_m = {0.02f, length};
  Shape out = Sheet(
      [&](float u, float v) {
        const float x = 2 * u - 1;
        return Vec3f(x * std::max(0.0015f, half_width(v)), length * v, height(x, v));
      },
      sheet);
  for (size_t i = 0; i < out.points.size(); ++i)
    out.texture[i] = {out.points[i].y(), out.points[i].x(), out.points[i].z()};
  return out;
}

// Half width of a handle from its butt (s = 0) to the neck (s = 1).
std::function<float(float)> HandleWidth(int style, float width) {
  switch (style) {
    case 0:
      return SmoothThrough({{0, 0.0f},
                            {0.04f, 0.75f * width},
                            {0.16f, width},
                            {0.6f, 0.52f * width},
                            {1, 0.3f * width}});
    case 1:
      return SmoothThrough({{0, 0.3f * width},
                            {0.03f, 0.8f * width},
                            {0.3f, 0.85f * width},
                            {0.7f, 0.6f * width},
                            {1, 0.32f * width}});
    default:
      return SmoothThrough({{0, 0.0f},
                            {0.05f, 0.6f * width},
                            {0.12f, 0.95f * width},
                            {0.22f, 0.6f * width},
                            {0.7f, 0.5f * width},
                            {1, 0.32f * width}});
  }
}

}  // namespace

Asset MakeSpoon(const CutleryParams& p) {
  const float length = p.length_m, bowl = 0.3f;
  const auto handle = HandleWidth(p.handle, 0.058f * length);
  const auto round = SmoothThrough({{0, 0.018f * length},
                                    {0.15f, 0.055f * length},
                                    {0.5f, 0.112f * length},
                                    {0.8f, 0.095f * length},
                                    {0.95f, 0.05f * length},
                                    {1, 0.008f * length}});
  const float start = 1 - bowl;
  AssetBuilder b(p.seed);
  b.Add(Blade(
            length,
            [&](float s) { return s < start ? handle(s / start) : round((s - start) / bowl); },
            [&](float x, float s) {
              const float neck = 0.055f * length * Smooth01((s - 0.45f) / 0.27f) *
                                 (1 - Smooth01((s - 0.68f) / 0.14f));
              const float lift = 0.02f * length * (1 - Smooth01(s / 0.5f));
              float z = 0.02f * length + neck + lift;
              if (s > start) {
                const float t = (s - start) / bowl;
                const float cup = std::sin(kPi * std::pow(t, 0.8f));
                z += cup * 0.055f * length * (x * x - 1) * 1.0f + 0.012f * length * t * t;
              }
              return z + 0.0006f * (1 - x * x);
            },
            0.0017f, 72, 14),
        MetalSlot("body"));
  return b.Finish();
}

Asset SampleSpoon(Rng& rng) {
  CutleryParams p;
  p.length_m = Draw(rng, 0.13, 0.21);
  p.handle = rng.UniformInt(0, 2);
  p.seed = rng.Seed();
  return MakeSpoon(p);
}

Asset MakeFork(const CutleryParams& p) {
  const float length = p.length_m;
  const int tines = p.tines;
  const auto handle = HandleWidth(p.handle, 0.055f * length);
  const float root = 0.76f;  // Where the tines begin.
  const auto width = [&](float s) {
    if (s < 0.58f) return handle(s / 0.58f);
    return Lerp(0.3f * 0.055f * length, 0.062f * length, Smooth01((s - 0.58f) / 0.15f));
  };
  const auto height = [&](float s) {
    const float neck =
        0.07f * length * Smooth01((s - 0.42f) / 0.25f) * (1 - Smooth01((s - 0.68f) / 0.2f));
    return 0.012f * length + neck + 0.014f * length * (1 - Smooth01(s / 0.5f)) +
           0.03f * length * Smooth01((s - 0.86f) / 0.14f);
  };
  AssetBuilder b(p.seed);
  const MaterialSlot metal = MetalSlot("body");
  b.Add(Blade(
            root * length, [&](float v) { return width(v * root); },
            [&](float x, float v) { return height(v * root) + 0.0006f * (1 - x * x); }, 0.0018f, 56,
            8),
        metal);
  const float full = 2 * 0.062f * length;
  const float pitch = full / static_cast<float>(tines), tine = 0.56f * pitch;
  for (int i = 0; i < tines; ++i) {
    const float x = -0.5f * full + pitch * (static_cast<float>(i) + 0.5f);
    Path3 path;
    for (int k = 0; k <= 14; ++k) {
      const float s = Lerp(root - 0.012f, 1.0f, static_cast<float>(k) / 14.0f);
      path.emplace_back(x * Lerp(1.08f, 1.0f, static_cast<float>(k) / 14.0f), s * length,
                        height(s) - 0.0009f);
    }
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.0006f;
    options.scale = [](float t) { return Vec2f(1.15f - 0.75f * t * t, 1.0f - 0.5f * t * t); };
    b.Add(Sweep(path, RectSection(tine, 0.0018f, 0.0006f, 2), options), metal);
  }
  return b.Finish();
}

Asset SampleFork(Rng& rng) {
  CutleryParams p;
  p.length_m = Draw(rng, 0.16, 0.21);
  p.tines = rng.UniformInt(3, 4);
  p.handle = rng.UniformInt(0, 2);
  p.seed = rng.Seed();
  return MakeFork(p);
}

Asset MakeKnife(const KnifeParams& p) {
  const float length = p.length_m, grip = p.grip_m, wide = p.blade_m, belly = p.belly;
  const bool kitchen = p.kitchen;
  AssetBuilder b(p.seed);
  const MaterialSlot steel = Slot("blade", {"PolishedMetal", "BrushedMetal"});
  // The blade: an outline with a belly, thin at the edge, lying flat.
  Path2 outline;
  const float y0 = grip - 0.01f;
  outline.emplace_back(-0.35f * wide, y0);
  outline.emplace_back(0.55f * wide, y0);
  outline.emplace_back(0.62f * wide, y0 + 0.02f * length);
  for (int k = 0; k <= 12; ++k) {
    const float t = static_cast<float>(k) / 12.0f;
    outline.emplace_back(0.62f * wide - (kitchen ? 0.85f : 0.7f) * belly * wide * t * t * t,
                         Lerp(grip + 0.03f * length, length, t));
  }
  for (int k = 11; k >= 0; --k) {
    const float t = static_cast<float>(k) / 12.0f;
    outline.emplace_back(-0.38f * wide + (kitchen ? 0.12f : 0.1f) * wide * t * t,
                         Lerp(grip + 0.03f * length, length - 0.004f, t));
  }
  Shape blade = Extrude(outline, 0.0018f, 0.0005f);
  const float lift = 0.006f;
  b.Add(blade.Moved(0, 0, lift), steel);
  if (kitchen) {
    // Riveted scales and a bolster.
    const MaterialSlot scales = Slot("handle", {"wood", "plastic"});
    BoxOptions box;
    box.bevel_m = 0.0045f;
    box.bevel_steps = 2;
    box.pieces = {1, 16, 1};
    const Shape scale = RoundedBox({0.024f, grip, 0.0165f}, box).Bent([&](const Vec3f& q) {
      const float s = q.y() / grip + 0.5f;
      return Vec3f(q.x() * (1 + 0.16f * std::sin(2 * kPi * s + 2.6f)) - 0.004f * std::sin(kPi * s),
                   q.y() + 0.5f * grip, q.z());
    });
    b.Add(scale.Moved(0, 0, lift + 0.0009f), scales);
    for (const float s : {0.2f, 0.5f, 0.8f})
      b.Add(Cylinder(0.0032f, 0.0172f, 0.0004f, 16)
                .Moved(-0.002f, s * grip, lift + 0.0009f - 0.0086f),
            steel);
    b.Add(Board({-0.011f, grip - 0.004f, lift - 0.006f}, {0.011f, grip + 0.008f, lift + 0.008f},
                0.003f),
          steel);
  } else {
    const auto width = HandleWidth(1, 0.05f * length);
    Path3 path;
    for (int k = 0; k <= 24; ++k)
      path.emplace_back(0, grip * static_cast<float>(k) / 24.0f, lift + 0.0009f);
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.003f;
    options.scale = [&](float t) {
      return Vec2f(width(t) / (0.05f * length), 0.7f + 0.5f * (1 - t));
    };
    b.Add(Sweep(path, RectSection(0.09f * length, 0.007f, 0.003f, 3), options),
          Slot("handle", {"metal", "plastic"}));
  }
  return b.Finish();
}

Asset SampleKnife(Rng& rng) {
  KnifeParams p;
  p.length_m = Draw(rng, 0.19, 0.3);
  p.kitchen = rng.Bernoulli(0.5);
  p.grip_m = Draw(rng, 0.36, 0.46) * p.length_m;
  p.blade_m = (p.kitchen ? Draw(rng, 0.06, 0.13) : Draw(rng, 0.036, 0.055)) * p.length_m;
  p.belly = Draw(rng, 0.5, 1.0);
  p.seed = rng.Seed();
  return MakeKnife(p);
}

Asset MakeChopsticks(const ChopsticksParams& p) {
  const float length = p.length_m;
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "lie");
  const MaterialSlot wood = Slot("body", {"wood", "plastic", "metal"});
  for (int i = 0; i < 2; ++i) {
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.001f;
    options.scale = [](float t) { return Vec2f::Constant(1.0f - 0.55f * t).eval(); };
    Path3 path;
    for (int k = 0; k <= 10; ++k) {
      const float t = static_cast<float>(k) / 10.0f;
      path.emplace_back(0, length * (t - 0.5f), 0.0038f - 0.0021f * t);
    }
    const Shape stick = Sweep(path, SuperellipseSection(0.0076f, 0.0076f, 3.2f, 16), options);
    const float turn = Draw(rng, -0.12, 0.12);
    b.Add(stick.TurnedZ(turn).Moved(i == 0 ? -0.013f : 0.013f, Draw(rng, -0.008, 0.008), 0), wood);
  }
  return b.Finish();
}

Asset SampleChopsticks(Rng& rng) {
  ChopsticksParams p;
  p.length_m = Draw(rng, 0.2, 0.25);
  p.seed = rng.Seed();
  return MakeChopsticks(p);
}

void RegisterTableware(std::vector<AssetClass>& classes) {
  const std::pair<const char*, Asset (*)(Rng&)> all[] = {{"Vase", SampleVase},
                                                         {"Bottle", SampleBottle},
                                                         {"Cup", SampleCup},
                                                         {"Bowl", SampleBowl},
                                                         {"Plate", SamplePlate},
                                                         {"Pot", SamplePot},
                                                         {"Pan", SamplePan},
                                                         {"Jar", SampleJar},
                                                         {"Wineglass", SampleWineglass},
                                                         {"Can", SampleCan},
                                                         {"Fork", SampleFork},
                                                         {"Knife", SampleKnife},
                                                         {"Spoon", SampleSpoon},
                                                         {"Chopsticks", SampleChopsticks},
                                                         {"Lid", SampleLid},
                                                         {"FoodBox", SampleFoodBox},
                                                         {"FoodBag", SampleFoodBag}};
  for (const auto& [name, sample] : all)
    classes.push_back({name, "tableware", Placement::kOnTop, true, 0, sample});
}

}  // namespace parallax
