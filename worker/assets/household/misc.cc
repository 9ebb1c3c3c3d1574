// Things of no family: pallets, racks, balloons, baskets.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A wooden pallet for goods.
struct PalletParams {
  float width_m = 1.2f, depth_m = 0.8f;
  int top_boards = 6;
  uint64_t seed = 0;
};

// Stretcher boards over nine blocks, nailed.
Asset MakePallet(const PalletParams& p) {
  const float w = p.width_m, d = p.depth_m;
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "boards");
  const MaterialSlot wood = Slot("boards", {"wood"});
  const Noise noise(rng);
  const float board = 0.022f, block = 0.078f;
  int serial = 0;
  // Rough-sawn: each board a little off and worn at its edges.
  const auto plank = [&](const Vec3f& lo, const Vec3f& hi) {
    BoxOptions box{.bevel_m = 0.004f};
    const Vec3f size = hi - lo;
    int longest = 0;
    size.maxCoeff(&longest);
    box.pieces[longest] = 10;
    const float shift = 3.7f * static_cast<float>(++serial);
    Shape s = RoundedBox(size, box).Bent([&](const Vec3f& q) {
      return Vec3f(q + 0.0022f * noise.Vector(q * 6 + Vec3f(shift, 0, 0)));
    });
    b.Add(s.Moved(0.5f * (lo + hi) + Vec3f{Draw(rng, -0.004, 0.004), Draw(rng, -0.004, 0.004), 0}),
          wood);
  };
  const float xs[3] = {-0.5f * w, -0.07f, 0.5f * w - 0.14f};
  const float ys[3] = {-0.5f * d, -0.05f, 0.5f * d - 0.1f};
  for (const float y : ys) plank({-0.5f * w, y, 0}, {0.5f * w, y + 0.1f, board});
  for (const float x : xs) {
    for (const float y : ys) plank({x, y, board - 0.001f}, {x + 0.14f, y + 0.1f, board + block});
    plank({x, -0.5f * d, board + block - 0.001f}, {x + 0.14f, 0.5f * d, 2 * board + block});
  }
  const int top = p.top_boards;
  const float pitch = (d - 0.1f) / static_cast<float>(top - 1);
  const float z = 2 * board + block;
  for (int i = 0; i < top; ++i) {
    const float y = -0.5f * d + pitch * static_cast<float>(i), wide = i % 2 == 0 ? 0.1f : 0.09f;
    plank({-0.5f * w, y, z - 0.001f}, {0.5f * w, y + wide, z + board});
    for (const float x : xs) {
      for (const float n : {0.03f, 0.07f})
        b.Add(Cylinder(0.0045f, 0.003f, 0.0008f, 10)
                  .Moved(x + 0.07f, y + n * wide / 0.1f, z + board - 0.0025f),
              MetalSlot("nails"));
    }
  }
  return b.Finish();
}

Asset SamplePallet(Rng& rng) {
  return MakePallet({.width_m = rng.Bernoulli(0.6) ? 1.2f : 1.0f,
                     .depth_m = rng.Bernoulli(0.6) ? 0.8f : 1.0f,
                     .top_boards = rng.UniformInt(5, 8),
                     .seed = rng.Seed()});
}

// A woven basket.
struct BasketParams {
  float radius_m = 0.16f, height_m = 0.18f;
  float flare = 0.1f;  // The rim's radius less the base's, in radii.
  int stakes = 23;     // Uprights; odd, so that each round goes the other way round.
  bool handles = true;
  uint64_t seed = 0;
};

// Radius of a basket, and the thickness of its rods: larger ones are of thicker rods.
struct Basket {
  explicit Basket(const BasketParams& params)
      : p(params), t(0.0042f * std::max(1.0f, params.height_m / 0.2f)) {}
  float Radius(float z) const {
    return p.radius_m * (1 + p.flare * (z / p.height_m - 0.5f)) *
           (0.93f + 0.07f * Smooth01(z / (0.25f * p.height_m)));
  }
  const BasketParams& p;
  const float t;
};

Shape BasketStakes(const Basket& basket) {
  Shape posts;
  for (int k = 0; k < basket.p.stakes; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(basket.p.stakes);
    Path3 path;
    for (int i = 0; i <= 10; ++i) {
      const float z = basket.p.height_m * static_cast<float>(i) / 10.0f;
      path.emplace_back(basket.Radius(z) * std::cos(a), basket.Radius(z) * std::sin(a), z);
    }
    posts.Add(Tube(path, 0.8f * basket.t, 0.001f, 7));
  }
  return posts;
}

// One rod that winds up and passes before and behind the stakes.
Shape BasketWeave(const Basket& basket) {
  const float h = basket.p.height_m, t = basket.t;
  const int rounds = static_cast<int>(h / (1.75f * t));
  const int per = basket.p.stakes * 3;
  Path3 spiral;
  for (int i = 0; i <= rounds * per; ++i) {
    const float turn = static_cast<float>(i) / static_cast<float>(per);
    const float a = 2 * kPi * turn, z = t + 1.75f * t * turn;
    if (z > h - t) break;
    const float rr =
        basket.Radius(z) + 1.15f * t * std::cos(0.5f * static_cast<float>(basket.p.stakes) * a);
    spiral.emplace_back(rr * std::cos(a), rr * std::sin(a), z);
  }
  return Sweep(spiral, EllipseSection(1.6f * t, 1.9f * t, 5), {.keep_up = true});
}

// One of the two twisted rods of the rim.
Shape BasketRim(const Basket& basket, float phase) {
  const float h = basket.p.height_m, t = basket.t;
  Path3 rim;
  for (int i = 0; i < 144; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 144.0f, q = 18 * a + phase;
    const float rr = basket.Radius(h) + 1.3f * t * std::cos(q);
    rim.emplace_back(rr * std::cos(a), rr * std::sin(a), h + 1.3f * t * std::sin(q));
  }
  return Ring(rim, 1.15f * t, 7);
}

// The handle on the side `s`, -1 or 1.
Shape BasketHandle(const Basket& basket, float s) {
  const float h = basket.p.height_m, x = basket.Radius(h);
  const Path3 grip = Spline(Path3{{s * x, -0.05f, h - 0.01f},
                                  {s * (x + 0.01f), -0.042f, h + 0.035f},
                                  {s * (x + 0.014f), 0, h + 0.055f},
                                  {s * (x + 0.01f), 0.042f, h + 0.035f},
                                  {s * x, 0.05f, h - 0.01f}},
                            6);
  return Tube(grip, 1.5f * basket.t, 0, 10);
}

// Woven: uprights, weavers that go in and out, a plaited rim.
Asset MakeBasketBase(const BasketParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot wicker = Slot("wicker", {"wood", "bark"});
  const Basket basket(p);
  b.Add(BasketStakes(basket), wicker);
  b.Add(BasketWeave(basket), wicker);
  for (const float phase : {0.0f, kPi}) b.Add(BasketRim(basket, phase), wicker);
  b.Add(Cylinder(basket.Radius(0) - 0.5f * basket.t, 0.006f, 0.001f, 48).Moved(0, 0, 0.002f),
        Slot("base", {"wood"}));
  if (p.handles) {
    for (const float s : {-1.0f, 1.0f}) b.Add(BasketHandle(basket, s), wicker);
  }
  return b.Finish();
}

Asset SampleBasketBase(Rng& rng) {
  BasketParams p{.radius_m = Draw(rng, 0.12, 0.2)};
  p.height_m = p.radius_m * Draw(rng, 0.8, 1.5);
  p.flare = Draw(rng, 0.0, 0.25);
  p.stakes = 2 * rng.UniformInt(9, 14) + 1;
  p.handles = rng.Bernoulli(0.6);
  p.seed = rng.Seed();
  return MakeBasketBase(p);
}

}  // namespace

void RegisterMisc(std::vector<AssetClass>& classes) {
  classes.push_back({"Pallet", "misc", Placement::kFloor, true, 0, SamplePallet,
                     SizeRange({0.95f, 0.75f, 0.1f}, {1.25f, 1.05f, 0.2f})});
  classes.push_back({"Rack", "misc", Placement::kFloorAgainstWall, false, 0.6f, SampleRack,
                     SizeRange({1.1f, 0.45f, 1.6f}, {2, 0.8f, 2.3f})});
  classes.push_back({"Balloon", "misc", Placement::kFloor, true, 0, SampleBalloon,
                     SizeRange({0.2f, 0.06f, 0.3f}, {2.2f, 0.7f, 1.2f})});
  classes.push_back({"BasketBase", "misc", Placement::kOnTop, true, 0, SampleBasketBase,
                     SizeRange({0.22f, 0.22f, 0.08f}, {0.55f, 0.5f, 0.42f})});
}

}  // namespace parallax
