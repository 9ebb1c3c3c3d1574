#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Front and back of a bag on one grid of (u across, v up), joined at the sides; picture on both.
Shape BagShape(const std::function<Vec3f(float u, float v, bool back)>& at, int nu, int nv) {
  Shape bag;
  std::vector<uint32_t> front, back;
  for (int side = 0; side < 2; ++side) {
    for (int j = 0; j <= nv; ++j) {
      for (int i = 0; i <= nu; ++i) {
        const bool rim = i == 0 || i == nu;
        std::vector<uint32_t>& ids = side ? back : front;
        if (side && rim) {
          ids.push_back(front[static_cast<size_t>(j * (nu + 1) + i)]);
          continue;
        }
        const float u = 2 * static_cast<float>(i) / static_cast<float>(nu) - 1,
                    v = static_cast<float>(j) / static_cast<float>(nv);
        Vec3f p = at(u, v, side == 1);
        if (rim) p.y() = 0.5f * (p.y() + at(u, v, true).y());
        ids.push_back(bag.AddPoint(p, {p.x(), p.z(), p.y()}));
      }
    }
  }
  const auto id = [&](int i, int j) { return static_cast<size_t>(j * (nu + 1) + i); };
  const auto uv = [&](int a, int c) {
    return Vec2f(static_cast<float>(a) / static_cast<float>(nu),
                 static_cast<float>(c) / static_cast<float>(nv));
  };
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      bag.AddQuad(front[id(i, j)], front[id(i + 1, j)], front[id(i + 1, j + 1)],
                  front[id(i, j + 1)], 1);
      bag.faces.back().uv = {uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)};
      bag.AddQuad(back[id(i, j)], back[id(i, j + 1)], back[id(i + 1, j + 1)], back[id(i + 1, j)],
                  1);
      bag.faces.back().uv = {uv(nu - i, j), uv(nu - i, j + 1), uv(nu - i - 1, j + 1),
                             uv(nu - i - 1, j)};
    }
  }
  for (int i = 0; i < nu; ++i) {
    bag.AddQuad(front[id(i + 1, 0)], front[id(i, 0)], back[id(i, 0)], back[id(i + 1, 0)]);
    bag.AddQuad(front[id(i, nv)], front[id(i + 1, nv)], back[id(i + 1, nv)], back[id(i, nv)]);
  }
  bag.crease_rad = 1.0f;
  return bag;
}

enum class FoodBagStyle { kPillow, kPouch, kBlock, kRolled, kCount };

// A bag or pouch.
struct FoodBagParams {
  FoodBagStyle style = FoodBagStyle::kPillow;
  float width_m = 0.17f, height_m = 0.24f, belly_m = 0.06f;
  bool spout = false;  // Only pouches have one.
  uint64_t seed = 0;
};

Asset MakeFoodBag(const FoodBagParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "food bag");
  const Noise noise(rng);
  const float w = p.width_m, h = p.height_m, t = p.belly_m;
  const bool stands = p.style != FoodBagStyle::kPillow;
  const float top = p.style == FoodBagStyle::kRolled ? 0.82f : 1.0f;
  const Shape bag = BagShape(
      [&](float u, float v, bool back) {
        // How thick the bag is at this height: closed by seams at both ends, or standing on a flat
        // bottom.
        const float s = std::clamp((v - 0.045f) / 0.91f, 0.0f, 1.0f);
        float belly = std::pow(std::max(0.0f, std::sin(kPi * s)), 0.55f);
        float across = std::sqrt(std::max(0.0f, 1 - u * u));
        if (stands) belly = std::pow(std::max(0.0f, std::cos(0.5f * kPi * v)), 0.6f);
        if (p.style == FoodBagStyle::kBlock || p.style == FoodBagStyle::kRolled) {
          belly = std::max(0.02f, 1 - std::pow(v / top, 6.0f));
          across = std::pow(std::max(0.0f, 1 - std::pow(std::abs(u), 9.0f)), 0.5f);
        }
        const float narrow = stands ? 1 - 0.05f * belly : 1 - 0.16f * belly;
        const float crimp = v > 0.95f || (!stands && v < 0.05f) ? 0.0012f * std::sin(60 * u) : 0;
        const float puff = 0.5f * t * belly * across;
        const float crease =
            0.006f * belly * noise.Ridges({u * w * 9, v * 9, back ? 3.0f : 8.0f}) * across +
            0.004f * (1 - belly) * noise.At({u * w * 30, v * 5, 1});
        float y = (back ? -1.0f : 1.0f) * std::max(0.0006f, puff - crease) + crimp;
        float z = h * v;
        if (p.style == FoodBagStyle::kRolled && v > top) {
          // The empty end is rolled down to the front; front and back turn with it.
          const float a = 5.5f * (v - top) / (1 - top), r = 0.011f + 0.0022f * a, off = y;
          y = r * (1 - std::cos(a)) + off * std::cos(a);
          z = h * top + r * std::sin(a) - off * std::sin(a);
        }
        return Vec3f(-0.5f * w * u * narrow, y, z);
      },
      36, p.style == FoodBagStyle::kRolled ? 72 : 44);
  b.Add(bag, {Slot("foil", {"plastic", "metal", "paper"}), PictureSlot("front")});
  if (p.spout) {
    b.Add(Cylinder(0.008f, 0.02f, 0.001f).Moved(0, 0, h - 0.008f), PlasticSlot("spout"));
    b.Add(Cylinder(0.0125f, 0.016f, 0.002f).Moved(0, 0, h + 0.006f), PlasticSlot("cap"));
  }
  if (p.style == FoodBagStyle::kRolled) {
    // A clip over the roll.
    b.Add(Bar({-0.36f * w, 0.03f, h * top + 0.006f}, {0.36f * w, 0.03f, h * top + 0.006f},
              {0.008f, 0.012f}, {0.008f, 0.012f}, 0.003f),
          PlasticSlot("clip"));
  }
  return b.Finish();
}

}  // namespace

Asset SampleFoodBag(Rng& rng) {
  FoodBagParams p;
  p.style = DrawEnum<FoodBagStyle>(rng, static_cast<int>(FoodBagStyle::kCount));
  p.width_m = Draw(rng, 0.13, 0.22);
  p.height_m = p.width_m * Draw(rng, 1.2, 1.6);
  p.belly_m = p.width_m * Draw(rng, 0.3, 0.42);
  if (p.style == FoodBagStyle::kBlock || p.style == FoodBagStyle::kRolled) {
    p.width_m = Draw(rng, 0.09, 0.15);
    p.height_m = p.width_m * Draw(rng, 1.7, 2.3);
    p.belly_m = p.width_m * Draw(rng, 0.55, 0.75);
  }
  p.spout = p.style == FoodBagStyle::kPouch && rng.Bernoulli(0.5);
  p.seed = rng.Seed();
  return MakeFoodBag(p);
}

}  // namespace parallax
