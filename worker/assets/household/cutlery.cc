#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/kernel/subdivide.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A forged piece along +y: a slab of metal over stations s in [0, 1] of its length, thin at its
// edges.
struct Forged {
  float length;
  std::vector<float> stations;
  std::vector<float> across;  // Columns, in [-1, 1].
  std::function<float(float s)> half_width;
  std::function<float(float x, float s)> height;  // Height of the upper side.
  std::function<float(float s)> thickness;        // In the middle.
  std::function<bool(int column, int row)> keep;
  std::function<float(float x, float s)> shift;  // Sideways shift of a column; null: none.
};

Shape Forge(const Forged& f) {
  SlabOptions slab;
  slab.columns = static_cast<int>(f.across.size()) - 1;
  slab.rows = static_cast<int>(f.stations.size()) - 1;
  slab.keep = f.keep;
  slab.point = [&](int i, int j) {
    const float x = f.across[static_cast<size_t>(i)], s = f.stations[static_cast<size_t>(j)];
    const float at = (f.shift ? f.shift(x, s) : x) * f.half_width(s);
    return Vec3f(at, f.length * s, f.height(x, s));
  };
  slab.thickness = [&](int i, int j) {
    const float x = f.across[static_cast<size_t>(i)];
    return f.thickness(f.stations[static_cast<size_t>(j)]) * (1 - 0.3f * x * x);
  };
  Shape out = Subdivided(Slab(slab), 2);
  for (Vec3f& t : out.texture) t = Vec3f(t.y(), t.x(), t.z());
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

// A fork or spoon.
struct CutleryParams {
  float length_m = 0.18f;
  int handle = 0;  // 0 pointed spatula, 1 straight, 2 waisted.
  int tines = 4;   // Tines of a fork.
  uint64_t seed = 0;
};

Asset MakeSpoon(const CutleryParams& p) {
  const float length = p.length_m, start = 0.7f;  // Where the bowl begins.
  const auto handle = HandleWidth(p.handle, 0.058f * length);
  const auto round = SmoothThrough({{0, 0.02f * length},
                                    {0.2f, 0.075f * length},
                                    {0.5f, 0.12f * length},
                                    {0.78f, 0.108f * length},
                                    {0.93f, 0.078f * length},
                                    {1, 0.034f * length}});
  Forged f;
  f.length = length;
  f.stations = {0,     0.03f, 0.08f, 0.16f, 0.28f, 0.42f, 0.55f, 0.64f,
                0.70f, 0.75f, 0.81f, 0.87f, 0.93f, 0.98f, 1};
  f.across = {-1, -0.62f, 0, 0.62f, 1};
  f.half_width = [=](float s) {
    return s < start ? std::max(0.011f * length, handle(s / start)) : round((s - start) / 0.3f);
  };
  f.height = [=](float x, float s) {
    const float neck =
        0.055f * length * Smooth01((s - 0.45f) / 0.27f) * (1 - Smooth01((s - 0.68f) / 0.14f));
    float z = 0.02f * length + neck + 0.02f * length * (1 - Smooth01(s / 0.5f));
    if (s > start) {
      const float t = (s - start) / 0.3f;
      z += std::sin(kPi * std::pow(t, 0.8f)) * 0.062f * length * (x * x - 1) +
           0.012f * length * t * t;
    }
    return z;
  };
  f.thickness = [=](float s) {
    return 0.0022f + 0.0022f * std::exp(-std::pow((s - 0.62f) / 0.1f, 2.0f));
  };
  AssetBuilder b(p.seed);
  b.Add(Forge(f), MetalSlot("body"));
  return b.Finish();
}

Asset SampleSpoon(Rng& rng) {
  return MakeSpoon(
      {.length_m = Draw(rng, 0.13, 0.21), .handle = rng.UniformInt(0, 2), .seed = rng.Seed()});
}

Asset MakeFork(const CutleryParams& p) {
  const float length = p.length_m, root = 0.74f;  // Where the tines begin.
  const auto handle = HandleWidth(p.handle, 0.055f * length);
  const int cells = 2 * p.tines - 1;
  Forged f;
  f.length = length;
  f.stations = {0,    0.03f, 0.08f, 0.17f, 0.3f, 0.44f, 0.54f,
                0.6f, 0.66f, root,  0.82f, 0.9f, 0.97f, 1};
  // Tines are a little wider than what lies between them.
  const float tine = 1.7f,
              whole = 1.7f * static_cast<float>(p.tines) + static_cast<float>(p.tines - 1);
  float at = 0;
  for (int i = 0; i <= cells; ++i) {
    f.across.push_back(2 * at / whole - 1);
    at += i % 2 == 0 ? tine : 1.0f;
  }
  f.keep = [&](int column, int row) {
    return column % 2 == 0 || f.stations[static_cast<size_t>(row)] < root;
  };
  // Towards its point a tine draws in to its own middle.
  f.shift = [&](float x, float s) {
    const int i =
        static_cast<int>(std::find(f.across.begin(), f.across.end(), x) - f.across.begin());
    const size_t left = static_cast<size_t>(i / 2 * 2);
    const float middle = 0.5f * (f.across[left] + f.across[left + 1]);
    return Lerp(middle, x, 1 - 0.62f * Smooth01((s - root) / (1.06f - root)));
  };
  f.half_width = [=](float s) {
    if (s < 0.54f) return std::max(0.01f * length, handle(s / 0.54f));
    return Lerp(0.3f * 0.055f * length, 0.064f * length, Smooth01((s - 0.54f) / 0.14f));
  };
  f.height = [=](float x, float s) {
    const float neck =
        0.07f * length * Smooth01((s - 0.42f) / 0.25f) * (1 - Smooth01((s - 0.68f) / 0.2f));
    return 0.012f * length + neck + 0.014f * length * (1 - Smooth01(s / 0.5f)) +
           0.03f * length * Smooth01((s - 0.86f) / 0.14f) +
           0.006f * length * x * x * Smooth01((s - 0.55f) / 0.15f);
  };
  f.thickness = [=](float s) {
    return 0.0022f + 0.0022f * std::exp(-std::pow((s - 0.55f) / 0.09f, 2.0f)) -
           0.0006f * Smooth01((s - 0.85f) / 0.15f);
  };
  AssetBuilder b(p.seed);
  b.Add(Forge(f), MetalSlot("body"));
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

constexpr float kKnifeLift = 0.006f;

// A knife.
struct KnifeParams {
  float length_m = 0.24f, grip_m = 0.1f;
  float blade_m = 0.02f;  // Its width.
  float belly = 0.8f;     // How much the edge curves to the tip.
  bool kitchen = false;   // Riveted scales instead of a moulded handle.
  uint64_t seed = 0;
};

// An outline with a belly, lying flat, thin at the edge.
Shape KnifeBlade(const KnifeParams& p) {
  const float length = p.length_m, grip = p.grip_m, wide = p.blade_m;
  Path2 outline;
  const float y0 = grip - 0.01f;
  outline.emplace_back(-0.35f * wide, y0);
  outline.emplace_back(0.55f * wide, y0);
  outline.emplace_back(0.62f * wide, y0 + 0.02f * length);
  for (int k = 0; k <= 12; ++k) {
    const float t = static_cast<float>(k) / 12.0f;
    outline.emplace_back(0.62f * wide - (p.kitchen ? 0.85f : 0.7f) * p.belly * wide * t * t * t,
                         Lerp(grip + 0.03f * length, length, t));
  }
  for (int k = 11; k >= 0; --k) {
    const float t = static_cast<float>(k) / 12.0f;
    outline.emplace_back(-0.38f * wide + (p.kitchen ? 0.12f : 0.1f) * wide * t * t,
                         Lerp(grip + 0.03f * length, length - 0.004f, t));
  }
  return Extrude(outline, 0.0018f, 0.0005f);
}

// Riveted scales and a bolster.
void AddKitchenHandle(AssetBuilder& b, const KnifeParams& p, const MaterialSlot& steel) {
  const MaterialSlot scales = Slot("handle", {"wood", "plastic"});
  const float grip = p.grip_m, lift = kKnifeLift;
  const BoxOptions box{.bevel_m = 0.0045f, .bevel_steps = 2, .pieces = {1, 16, 1}};
  const Shape scale = RoundedBox({0.024f, grip, 0.0165f}, box).Bent([&](const Vec3f& q) {
    const float s = q.y() / grip + 0.5f;
    return Vec3f(q.x() * (1 + 0.16f * std::sin(2 * kPi * s + 2.6f)) - 0.004f * std::sin(kPi * s),
                 q.y() + 0.5f * grip, q.z());
  });
  b.Add(scale.Moved(0, 0, lift + 0.0009f), scales);
  for (const float s : {0.2f, 0.5f, 0.8f})
    b.Add(
        Cylinder(0.0032f, 0.0172f, 0.0004f, 16).Moved(-0.002f, s * grip, lift + 0.0009f - 0.0086f),
        steel);
  b.Add(Board({-0.011f, grip - 0.004f, lift - 0.006f}, {0.011f, grip + 0.008f, lift + 0.008f},
              0.003f),
        steel);
}

// One piece of metal, as cutlery for the table has.
void AddTableHandle(AssetBuilder& b, const KnifeParams& p) {
  const float length = p.length_m;
  const auto width = HandleWidth(1, 0.05f * length);
  Path3 path;
  for (int k = 0; k <= 24; ++k)
    path.emplace_back(0, p.grip_m * static_cast<float>(k) / 24.0f, kKnifeLift + 0.0009f);
  b.Add(
      Sweep(path, RectSection(0.09f * length, 0.007f, 0.003f, 3),
            {.scale =
                 [&](float t) { return Vec2f(width(t) / (0.05f * length), 0.7f + 0.5f * (1 - t)); },
             .end_round_m = 0.003f,
             .keep_up = true}),
      Slot("handle", {"metal", "plastic"}));
}

Asset MakeKnife(const KnifeParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot steel = Slot("blade", {"PolishedMetal", "BrushedMetal"});
  b.Add(KnifeBlade(p).Moved(0, 0, kKnifeLift), steel);
  p.kitchen ? AddKitchenHandle(b, p, steel) : AddTableHandle(b, p);
  return b.Finish();
}

Asset SampleKnife(Rng& rng) {
  KnifeParams p{.length_m = Draw(rng, 0.19, 0.3), .kitchen = rng.Bernoulli(0.5)};
  p.grip_m = Draw(rng, 0.36, 0.46) * p.length_m;
  p.blade_m = (p.kitchen ? Draw(rng, 0.06, 0.13) : Draw(rng, 0.036, 0.055)) * p.length_m;
  p.belly = Draw(rng, 0.5, 1.0);
  p.seed = rng.Seed();
  return MakeKnife(p);
}

// A pair of chopsticks.
struct ChopsticksParams {
  float length_m = 0.23f;
  uint64_t seed = 0;  // How the two lie.
};

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
  return MakeChopsticks({.length_m = Draw(rng, 0.2, 0.25), .seed = rng.Seed()});
}

}  // namespace

void RegisterTableware(std::vector<AssetClass>& classes) {
  const auto add = [&](const char* name, Asset (*sample)(Rng&), const SizeRange& size) {
    classes.push_back({name, "tableware", Placement::kOnTop, true, 0, sample, size});
  };
  add("Vase", SampleVase, SizeRange({0.06f, 0.06f, 0.14f}, {0.5f, 0.46f, 0.44f}));
  add("Bottle", SampleBottle, SizeRange({0.03f, 0.03f, 0.13f}, {0.12f, 0.13f, 0.39f}));
  add("Cup", SampleCup, SizeRange({0.06f, 0.06f, 0.045f}, {0.2f, 0.2f, 0.15f}));
  add("Bowl", SampleBowl, SizeRange({0.12f, 0.12f, 0.03f}, {0.36f, 0.36f, 0.16f}));
  add("Plate", SamplePlate, SizeRange({0.15f, 0.15f, 0.01f}, {0.36f, 0.36f, 0.05f}));
  add("Pot", SamplePot, SizeRange({0.2f, 0.16f, 0.06f}, {0.42f, 0.34f, 0.3f}));
  add("Pan", SamplePan, SizeRange({0.3f, 0.16f, 0.03f}, {0.6f, 0.34f, 0.13f}));
  add("Jar", SampleJar, SizeRange({0.06f, 0.06f, 0.07f}, {0.15f, 0.15f, 0.28f}));
  add("Wineglass", SampleWineglass, SizeRange({0.04f, 0.04f, 0.11f}, {0.16f, 0.16f, 0.25f}));
  add("Can", SampleCan, SizeRange({0.045f, 0.045f, 0.02f}, {0.13f, 0.13f, 0.24f}));
  add("Fork", SampleFork, SizeRange({0.012f, 0.15f, 0.005f}, {0.04f, 0.22f, 0.04f}));
  add("Knife", SampleKnife, SizeRange({0.008f, 0.18f, 0.004f}, {0.05f, 0.32f, 0.04f}));
  add("Spoon", SampleSpoon, SizeRange({0.02f, 0.12f, 0.005f}, {0.06f, 0.22f, 0.05f}));
  add("Chopsticks", SampleChopsticks, SizeRange({0.02f, 0.19f, 0.004f}, {0.09f, 0.27f, 0.02f}));
  add("Lid", SampleLid, SizeRange({0.15f, 0.15f, 0.03f}, {0.32f, 0.32f, 0.12f}));
  add("FoodBox", SampleFoodBox, SizeRange({0.055f, 0.025f, 0.025f}, {0.31f, 0.31f, 0.46f}));
  add("FoodBag", SampleFoodBag, SizeRange({0.08f, 0.03f, 0.12f}, {0.24f, 0.13f, 0.4f}));
}

}  // namespace parallax
