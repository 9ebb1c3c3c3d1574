// Pillows and folded cloth: what lies on beds, sofas and shelves.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A stuffed pillow, lying flat.
struct PillowParams {
  float width_m = 0.6f, depth_m = 0.4f, height_m = 0.14f;
  float flange_m = 0.0f;  // A flat border; 0 = none.
  uint64_t seed = 0;
};

Asset MakePillow(const PillowParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  const PillowOptions o{.wrinkle_m = 0.006f, .pieces = 36};
  // The pillow lies on its belly, which flattens, and the corners sink.
  const auto settle = [&](const Vec3f& q) {
    const float u = 2 * q.x() / p.width_m, v = 2 * q.y() / p.depth_m;
    const float floor = -0.27f * p.height_m;
    const float z = q.z() - 0.24f * p.height_m * std::min(1.2f, u * u * u * u + v * v * v * v);
    return Vec3f(q.x(), q.y(), z < floor ? floor + 0.12f * (z - floor) : z);
  };
  b.Add(Pillow(p.width_m, p.depth_m, p.height_m, o, noise).Bent(settle), FabricSlot("pillow"));
  if (p.flange_m > 0) {
    // A flat border sewn round the seam, a little wavy.
    Path3 rim;
    const float hx = 0.5f * p.width_m, hy = 0.5f * p.depth_m;
    for (const Vec2f& q : RectSection(2 * hx, 2 * hy, 1.4f * p.flange_m, 4))
      rim.emplace_back(q.x(), q.y(), 0);
    rim.push_back(rim.front());
    rim = Resampled(rim, 0.03f);
    rim.pop_back();
    for (Vec3f& q : rim) {
      const float u = q.x() / hx, v = q.y() / hy;
      q.x() *= 1 - o.corner_pull * std::max(0.0f, 1 - v * v);
      q.y() *= 1 - o.corner_pull * std::max(0.0f, 1 - u * u);
      q.z() = 0.15f * p.height_m * noise.At({q.x() / 0.25f, q.y() / 0.25f, 11}) +
              0.003f * noise.At(q * 30);
      q = settle(q);
    }
    b.Add(Sweep(rim, RectSection(2 * p.flange_m, 0.004f, 0.0015f, 1),
                {.closed = true, .up = Vec3f::UnitZ(), .keep_up = true}),
          FabricSlot("pillow"));
  }
  return b.Finish();
}

// A cloth seen from the side: its middle line, thickened by `thick` to both sides, swept `width`
// along x. z = 0 is the middle line's lowest level.
Shape ClothStrip(const Path2& side, float thick, float width, int pieces) {
  std::vector<Vec2f> normal;
  for (size_t i = 0; i < side.size(); ++i) {
    const Vec2f before = side[i > 0 ? i - 1 : 0], after = side[std::min(i + 1, side.size() - 1)];
    const Vec2f along = (after - before).normalized();
    normal.emplace_back(-along.y(), along.x());
  }
  Path2 outline;
  const auto end_cap = [&](const Vec2f& at, const Vec2f& n) {
    const Vec2f out(n.y(), -n.x());
    for (int k = 1; k < 4; ++k) {
      const float a = 0.25f * kPi * static_cast<float>(k);
      outline.push_back(at + thick * (std::cos(a) * n + std::sin(a) * out));
    }
  };
  for (size_t i = 0; i < side.size(); ++i) outline.push_back(side[i] + thick * normal[i]);
  end_cap(side.back(), normal.back());
  for (size_t i = side.size(); i-- > 0;) outline.push_back(side[i] - thick * normal[i]);
  end_cap(side.front(), -normal.front());
  std::reverse(outline.begin(), outline.end());
  Shape strip = Extrude(outline, width, 0.25f * thick, pieces);
  for (size_t i = 0; i < strip.points.size(); ++i) {
    const Vec3f& q = strip.points[i];
    strip.texture[i] = {q.z(), q.x(), q.y()};
  }
  return strip.Bent([&](const Vec3f& q) { return Vec3f(q.z() - 0.5f * width, q.x(), q.y()); });
}

// How a cloth lies: folded to and fro in layers, rolled up, several folded ones stacked, or thrown
// down in a heap.
enum class FoldStyle { kFolded, kRolled, kStacked, kThrown, kCount };

// Folded, rolled or thrown cloths: blankets and towels.
struct BlanketParams {
  FoldStyle style = FoldStyle::kFolded;
  float width_m = 0.5f, depth_m = 0.4f;  // Folded size; length and width if rolled.
  int layers = 4;                        // Or turns of the roll.
  float layer_m = 0.022f;
  int stack = 1;       // Folded cloths on each other.
  float fringe_m = 0;  // Threads along the front edge of a folded one; 0 = hemmed.
  bool terry = false;  // A towel's cloth.
  uint64_t seed = 0;
};

// A serpentine with round turns, folded edge at the front.
Path2 Serpentine(const BlanketParams& p, Rng& rng) {
  const float half = 0.5f * p.depth_m, t = p.layer_m, r = 0.5f * t;
  std::vector<float> reach;
  for (int i = 0; i < p.layers; ++i) reach.push_back(half - Draw(rng, 0.0, 0.012));
  Path2 side{{half - 0.02f, r}};
  for (int i = 0; i < p.layers; ++i) {
    const float z = r + t * static_cast<float>(i);
    const float dir = i % 2 == 0 ? -1.0f : 1.0f;
    const float end = dir * (reach[static_cast<size_t>(i)] - r);
    const float from = i == 0 ? half - 0.02f : -end;
    for (int k = 1; k <= 10; ++k)
      side.emplace_back(Lerp(from, end, static_cast<float>(k) / 10.0f), z);
    if (i + 1 == p.layers) break;
    for (int k = 1; k < 6; ++k) {
      const float a = kPi * static_cast<float>(k) / 6.0f;
      side.emplace_back(end + dir * r * std::sin(a), z + r * (1 - std::cos(a)));
    }
  }
  return side;
}

Shape FoldedCloth(const BlanketParams& p, Rng& rng) {
  const Noise noise(rng);
  const float total = p.layer_m * static_cast<float>(p.layers);
  const Shape strip = ClothStrip(Serpentine(p, rng), 0.43f * p.layer_m, p.width_m, 22);
  return strip.Bent([&](const Vec3f& q) {
    const float level = std::clamp(q.z() / total, 0.0f, 1.0f);
    const float layer = 0.4f * q.z() / p.layer_m;  // Continuous: the turns must not tear.
    const float u = 2 * q.x() / p.width_m;
    const float sag =
        noise.At({q.x() * 5, q.y() * 5, 0.3f}) * 0.006f * level * level - 0.007f * level * u * u;
    const float edge = 0.01f * noise.At({q.y() * 7, 1.7f * layer, u > 0 ? 1.5f : 6.5f}) *
                       std::pow(std::abs(u), 3.0f);
    return Vec3f(q.x() + edge, q.y() + 0.007f * noise.At({q.x() * 7, 1.3f * layer, 2}),
                 q.z() + sag);
  });
}

// A spiral; it lies along x and is a little flattened by its own weight.
Shape RolledCloth(const BlanketParams& p, Rng& rng) {
  const Noise noise(rng);
  const float turns = static_cast<float>(p.layers) + Draw(rng, -0.25, 0.4);
  const float inner = 0.9f * p.layer_m;
  const int steps = static_cast<int>(turns * 26);
  Path2 side;
  for (int i = 0; i <= steps; ++i) {
    const float turn = turns * static_cast<float>(i) / static_cast<float>(steps);
    const float a = 2 * kPi * (turn - turns) + 0.2f, r = inner + p.layer_m * turn;
    side.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  const float radius = inner + p.layer_m * turns;
  return ClothStrip(side, 0.43f * p.layer_m, p.width_m, 26).Bent([&](const Vec3f& q) {
    const float u = 2 * q.x() / p.width_m, r = std::hypot(q.y(), q.z());
    // The inner turns stand out at one end as they do when a roll is made by hand.
    const float cone = 0.05f * p.width_m * (1 - r / radius) * u * u * (u > 0 ? 1.0f : -0.35f);
    const float dent = 1 + 0.035f * noise.At({q.x() * 9, 0.5f, 3}) + 0.02f * noise.At(q * 14);
    return Vec3f(q.x() + cone + 0.004f * noise.At({3 * q.y() / radius, 3 * q.z() / radius, u}),
                 1.05f * dent * q.y(), 0.93f * dent * q.z());
  });
}

// A sheet that has fallen down: broad folds, pushed together.
Shape ThrownCloth(const BlanketParams& p, Rng& rng) {
  const Noise noise(rng);
  const float w = p.width_m, d = p.depth_m, height = Draw(rng, 0.06, 0.1);
  const float thick = 0.35f * p.layer_m, turn = Draw(rng, 0.0, kPi);
  SheetOptions sheet;
  sheet.pieces_u = sheet.pieces_v = 56;
  sheet.size_m = {1.7f * w, 1.7f * d};
  sheet.thickness_m = thick;
  return Sheet(
      [&](float u, float v) {
        const float x = w * (u - 0.5f), y = d * (v - 0.5f);
        const Vec2f along(std::cos(turn) * x + std::sin(turn) * y,
                          -std::sin(turn) * x + std::cos(turn) * y);
        const float rim = Smooth01(7 * std::min({u, v, 1 - u, 1 - v}));
        const Vec3f fold(along.x() / 0.13f, along.y() / 0.3f, 0.4f);
        const float ridge = noise.Ridges(fold), broad = noise.At({x / 0.24f, y / 0.24f, 5});
        const float z = height * rim * (0.75f * ridge + 0.35f * std::max(0.0f, broad)) +
                        0.008f * (0.5f + 0.5f * noise.At({x / 0.05f, y / 0.05f, 8}));
        // Folds lean over.
        const Vec2f lean = 0.35f * z * Vec2f(std::cos(turn), std::sin(turn));
        const float ragged_x = 0.05f * noise.At({y / 0.1f, 2.5f, 1}),
                    ragged_y = 0.05f * noise.At({x / 0.1f, 6.5f, 1});
        return Vec3f(x + lean.x() + ragged_x * std::abs(2 * u - 1),
                     y + lean.y() + ragged_y * std::abs(2 * v - 1), z + thick);
      },
      sheet);
}

// Twisted threads that hang out of the lowest layer at the front.
Shape Fringe(const BlanketParams& p, Rng& rng) {
  Shape fringe;
  const int count = static_cast<int>(p.width_m / 0.014f);
  const float y = 0.5f * p.depth_m - 0.024f, z = 0.5f * p.layer_m;
  for (int i = 0; i < count; ++i) {
    const float x =
        0.97f * p.width_m * ((static_cast<float>(i) + 0.5f) / static_cast<float>(count) - 0.5f);
    const float sway = Draw(rng, -0.008, 0.008), length = p.fringe_m * Draw(rng, 0.85, 1.1);
    fringe.Add(Tube({{x, y, z},
                     {x + 0.4f * sway, y + 0.5f * length, 0.55f * z},
                     {x + sway, y + length, 0.003f}},
                    0.0021f, 0.001f, 6));
  }
  return fringe;
}

Asset MakeBlanket(const BlanketParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "layers");
  const auto cloth = [&](const std::string& name) {
    return p.terry ? Slot(name, {"TerryCloth", "BoucleFabric", "fabric"}) : FabricSlot(name);
  };
  switch (p.style) {
    case FoldStyle::kRolled:
      b.Add(RolledCloth(p, rng), cloth("cloth"));
      break;
    case FoldStyle::kThrown:
      b.Add(ThrownCloth(p, rng), cloth("cloth"));
      break;
    default: {
      float z = 0;
      for (int i = 0; i < std::max(1, p.stack); ++i) {
        BlanketParams each = p;
        if (p.stack > 1) {
          each.width_m *= Draw(rng, 0.92, 1.0);
          each.layers = std::max(2, p.layers - rng.UniformInt(0, 1));
        }
        const std::string slot = i == 0 ? "cloth" : fmt::format("cloth_{}", i + 1);
        const float turn = Draw(rng, -0.04, 0.04), shift = Draw(rng, -0.008, 0.008);
        b.Add(FoldedCloth(each, rng).TurnedZ(p.stack > 1 ? turn : 0).Moved(shift, 0, z),
              cloth(slot));
        z += each.layer_m * static_cast<float>(each.layers) + 0.003f;
      }
      if (p.fringe_m > 0) b.Add(Fringe(p, rng), Slot("fringe", {"fabric"}));
    }
  }
  return b.Finish();
}

}  // namespace

Asset SamplePillow(Rng& rng) {
  PillowParams p;
  if (rng.Bernoulli(0.5)) {
    p.width_m = p.depth_m = Draw(rng, 0.38, 0.52);
  } else {
    p.width_m = Draw(rng, 0.5, 0.75);
    p.depth_m = Draw(rng, 0.34, 0.48);
  }
  p.height_m = Draw(rng, 0.11, 0.18);
  p.flange_m = rng.Bernoulli(0.35) ? Draw(rng, 0.02, 0.035) : 0.0f;
  p.seed = rng.Seed();
  return MakePillow(p);
}

Asset SampleBlanket(Rng& rng) {
  BlanketParams p;
  p.style = DrawEnum<FoldStyle>(rng, static_cast<int>(FoldStyle::kCount));
  p.width_m = Draw(rng, 0.42, 0.65);
  p.depth_m = Draw(rng, 0.35, 0.5);
  p.layers = p.style == FoldStyle::kRolled ? rng.UniformInt(3, 5) : rng.UniformInt(3, 6);
  p.layer_m = p.style == FoldStyle::kRolled ? Draw(rng, 0.016, 0.022) : Draw(rng, 0.018, 0.03);
  if (p.style == FoldStyle::kStacked) {
    p.stack = 2;
    p.layers = 3;
  }
  if (p.style == FoldStyle::kFolded && rng.Bernoulli(0.5)) p.fringe_m = Draw(rng, 0.03, 0.06);
  p.seed = rng.Seed();
  return MakeBlanket(p);
}

Asset SampleTowel(Rng& rng) {
  BlanketParams p;
  p.terry = true;
  p.style = DrawEnum<FoldStyle>(rng, static_cast<int>(FoldStyle::kCount));
  p.width_m = Draw(rng, 0.26, 0.4);
  p.depth_m = Draw(rng, 0.2, 0.3);
  p.layers = rng.UniformInt(3, 7);
  p.layer_m = Draw(rng, 0.011, 0.016);
  if (p.style == FoldStyle::kRolled) p.layers = rng.UniformInt(3, 5);
  if (p.style == FoldStyle::kStacked) {
    p.stack = rng.UniformInt(2, 4);
    p.layers = 3;
  }
  p.seed = rng.Seed();
  return MakeBlanket(p);
}

}  // namespace parallax
