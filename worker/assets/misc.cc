#include "worker/assets/misc.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Strokes of a glyph in a 4 x 6 grid: what a foil letter balloon is made of. Points "xy" pairs,
// strokes split by space; a stroke that ends where it starts is a ring.
struct Glyph {
  char letter;
  std::string_view strokes;
};
constexpr Glyph kGlyphs[] = {{'0', "03 05 26 45 43 41 20 01 03"},
                             {'1', "05 26 20"},
                             {'2', "05 26 45 44 00 40"},
                             {'3', "05 26 45 44 23|23 42 41 20 01"},
                             {'4', "30 36 02 42"},
                             {'5', "46 06 03 33 42 41 20 01"},
                             {'7', "06 46 10"},
                             {'8', "23 04 05 26 45 44 23|23 42 41 20 01 02 23"},
                             {'C', "45 26 05 01 20 41"},
                             {'E', "46 06 00 40|03 33"},
                             {'H', "06 00|46 40|03 43"},
                             {'L', "06 00 40"},
                             {'M', "00 06 23 46 40"},
                             {'O', "03 05 26 45 43 41 20 01 03"},
                             {'S', "45 26 05 04 42 41 20 01"},
                             {'U', "06 02 20 42 46"},
                             {'V', "06 20 46"},
                             {'X', "06 40|46 00"},
                             {'Z', "06 46 00 40"}};

// A ribbon that curls as it hangs.
Shape Ribbon(const Vec3f& from, float length, const Noise& noise) {
  Path3 path;
  for (int k = 0; k <= 40; ++k) {
    const float t = static_cast<float>(k) / 40.0f;
    const float sway = 0.12f * length * t;
    path.push_back(from + Vec3f(sway * noise.At({3 * t, 0.3f, 0}) + 0.012f * std::sin(19 * t) * t,
                                sway * noise.At({3 * t, 7.3f, 0}) + 0.012f * std::cos(19 * t) * t,
                                -length * t));
  }
  SweepOptions options;
  options.twist_rad = [](float t) { return 9 * t; };
  return Sweep(path, RectSection(0.006f, 0.0009f, 0.0003f, 1), options);
}

}  // namespace

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
    BoxOptions box;
    box.bevel_m = 0.004f;
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
  PalletParams p;
  p.width_m = rng.Bernoulli(0.6) ? 1.2f : 1.0f;
  p.depth_m = rng.Bernoulli(0.6) ? 0.8f : 1.0f;
  p.top_boards = rng.UniformInt(5, 8);
  p.seed = rng.Seed();
  return MakePallet(p);
}

Asset MakeRack(const RackParams& p) {
  const float w = p.width_m, d = p.depth_m, h = p.height_m;
  const int levels = p.levels;
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "load");
  const MaterialSlot upright = Slot("uprights", {"metal", "paint"}),
                     beam = Slot("beams", {"metal", "paint"}), deck = MetalSlot("deck");
  const float x = 0.5f * w, y = 0.5f * d, t = 0.05f;
  b.AddFourfold(Board({x - t, y - t, 0.004f}, {x, y, h}, 0.004f), upright);
  b.AddFourfold(Board({x - 0.09f, y - 0.09f, 0}, {x + 0.012f, y + 0.012f, 0.006f}, 0.001f),
                upright);
  // Side lattices.
  const int bays = 5;
  for (int i = 0; i < bays; ++i) {
    const float z0 = Lerp(0.12f, h - 0.12f, static_cast<float>(i) / bays),
                z1 = Lerp(0.12f, h - 0.12f, static_cast<float>(i + 1) / bays);
    const float s = i % 2 ? 1.0f : -1.0f;
    b.AddMirroredX(Bar({x - 0.5f * t, s * (y - t), z0}, {x - 0.5f * t, -s * (y - t), z1},
                       {0.008f, 0.028f}, {0.008f, 0.028f}, 0.002f),
                   upright);
    b.AddMirroredX(Bar({x - 0.5f * t, -(y - t), z0}, {x - 0.5f * t, y - t, z0}, {0.008f, 0.028f},
                       {0.008f, 0.028f}, 0.002f),
                   upright);
  }
  for (int l = 0; l < levels; ++l) {
    const float z = Lerp(0.18f, h - 0.5f, static_cast<float>(l) / static_cast<float>(levels - 1));
    for (const float s : {-1.0f, 1.0f})
      b.Add(Board({-x + t, s * (y - 0.025f) - 0.02f, z - 0.09f},
                  {x - t, s * (y - 0.025f) + 0.02f, z}, 0.004f),
            beam);
    for (const float s : {-1.0f, 1.0f}) {
      for (const float q : {-1.0f, 1.0f})
        b.Add(Board({s * (x - t) - 0.006f, q * y - 0.006f, z - 0.13f},
                    {s * (x - t) + 0.03f * -s, q * y + 0.006f, z + 0.03f}, 0.002f),
              beam);
    }
    Shape wires;
    const int across = static_cast<int>((w - 2 * t) / 0.05f), along = 6;
    for (int i = 0; i <= across; ++i) {
      const float at =
          Lerp(-x + t + 0.01f, x - t - 0.01f, static_cast<float>(i) / static_cast<float>(across));
      wires.Add(Tube({{at, -y + 0.02f, z + 0.003f}, {at, y - 0.02f, z + 0.003f}}, 0.0028f, 0, 6));
    }
    for (int i = 0; i <= along; ++i) {
      const float at = Lerp(-y + 0.03f, y - 0.03f, static_cast<float>(i) / along);
      wires.Add(Tube({{-x + t + 0.005f, at, z - 0.001f}, {x - t - 0.005f, at, z - 0.001f}}, 0.0028f,
                     0, 6));
    }
    b.Add(wires, deck);
    // Cartons and bins.
    float at = -x + t + 0.06f;
    while (at < x - t - 0.3f) {
      const float bw = Draw(rng, 0.24, 0.42), bd = Draw(rng, 0.3, d - 0.12),
                  bh = Draw(rng, 0.16, 0.3);
      if (at + bw > x - t - 0.03f) break;
      if (rng.Bernoulli(0.75)) {
        const Vec3f mid(at + 0.5f * bw, Draw(rng, -0.03, 0.03), z + 0.0058f);
        const float turn = Draw(rng, -0.06, 0.06);
        if (rng.Bernoulli(0.6)) {
          b.Add(Board({-0.5f * bw, -0.5f * bd, 0}, {0.5f * bw, 0.5f * bd, bh}, 0.003f)
                    .TurnedZ(turn)
                    .Moved(mid),
                Slot("cartons", {"paper"}));
          b.Add(Board({-0.5f * bw - 0.0006f, -0.025f, bh - 0.05f},
                      {0.5f * bw + 0.0006f, 0.025f, bh + 0.0006f}, 0.0005f)
                    .TurnedZ(turn)
                    .Moved(mid),
                Slot("tape", {"plastic", "paper"}));
        } else {
          const Path2 foot = RectSection(0.9f * bw, 0.9f * bd, 0.02f, 4);
          // An open bin: walls, floor, rim.
          const float wall = 0.006f;
          for (const float s : {-1.0f, 1.0f}) {
            b.Add(Board({s * 0.45f * bw, -0.45f * bd, 0}, {s * (0.45f * bw - wall), 0.45f * bd, bh},
                        0.002f)
                      .TurnedZ(turn)
                      .Moved(mid),
                  PlasticSlot("bins"));
            b.Add(Board({-0.45f * bw, s * 0.45f * bd, 0}, {0.45f * bw, s * (0.45f * bd - wall), bh},
                        0.002f)
                      .TurnedZ(turn)
                      .Moved(mid),
                  PlasticSlot("bins"));
          }
          b.Add(Extrude(foot, wall, 0.001f).TurnedZ(turn).Moved(mid), PlasticSlot("bins"));
          SweepOptions closed;
          closed.closed = true;
          closed.keep_up = true;
          closed.up = Vec3f::UnitZ();
          Path3 rim;
          for (const Vec2f& q : RectSection(0.9f * bw, 0.9f * bd, 0.012f, 3))
            rim.emplace_back(q.x(), q.y(), bh);
          b.Add(Sweep(rim, RectSection(0.018f, 0.012f, 0.003f, 2), closed).TurnedZ(turn).Moved(mid),
                PlasticSlot("bins"));
        }
      }
      at += bw + Draw(rng, 0.03, 0.12);
    }
  }
  return b.Finish();
}

Asset SampleRack(Rng& rng) {
  RackParams p;
  p.width_m = Draw(rng, 1.2, 1.9);
  p.depth_m = Draw(rng, 0.5, 0.7);
  p.height_m = Draw(rng, 1.7, 2.2);
  p.levels = rng.UniformInt(3, 4);
  p.seed = rng.Seed();
  return MakeRack(p);
}

Asset MakeBalloon(const BalloonParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "balloon");
  const Noise noise(rng);
  const int count = p.count;
  if (!p.letters) {
    for (int i = 0; i < count; ++i) {
      const float r = Draw(rng, 0.11, 0.15);
      const Path2 profile = Spline(Path2{{0.012f, -1.42f * r},
                                         {0.02f, -1.4f * r},
                                         {0.09f * r, -1.34f * r},
                                         {0.12f * r, -1.27f * r},
                                         {0.5f * r, -0.86f * r},
                                         {0.88f * r, -0.3f * r},
                                         {r, 0.2f * r},
                                         {0.84f * r, 0.72f * r},
                                         {0.45f * r, 1.02f * r},
                                         {0.01f * r, 1.1f * r}},
                                   5);
      const float a = 2.1f * static_cast<float>(i), lean = count > 1 ? 0.35f : 0.05f;
      const Vec3f knot(0.02f * std::cos(a), 0.02f * std::sin(a),
                       0.55f + 0.12f * static_cast<float>(i % 2));
      const Vec3f up = Vec3f(lean * std::cos(a), lean * std::sin(a), 1).normalized();
      b.Add(AlongZ(Lathe(profile, {.segments = 48}).Moved(0, 0, 1.42f * r), knot, knot + up),
            Slot(fmt::format("rubber_{}", i + 1), {"plastic"}));
      b.Add(Ball(0.007f, 12).Moved(knot), Slot(fmt::format("rubber_{}", i + 1), {"plastic"}));
      b.Add(Ribbon(knot, knot.z() - 0.004f, Noise(rng)), Slot("ribbon", {"fabric", "plastic"}));
    }
    b.Add(
        Lathe(Spline(
            Path2{{0.035f, 0}, {0.045f, 0.004f}, {0.04f, 0.02f}, {0.02f, 0.03f}, {0.001f, 0.032f}},
            4)),
        Slot("weight", {"metal", "plastic"}));
    return b.Finish();
  }
  const float h = p.height_m, unit = h / 6, r = Draw(rng, 0.085, 0.105) * h;
  float x = 0;
  for (int i = 0; i < count; ++i) {
    const Glyph& glyph = kGlyphs[rng.UniformInt(0, static_cast<int>(std::size(kGlyphs)) - 1)];
    Path3 stroke;
    const auto finish = [&] {
      if (stroke.size() < 2) return;
      const bool ring = (stroke.front() - stroke.back()).norm() < 1e-6f;
      if (ring) stroke.pop_back();
      Path3 path = ring ? Spline(stroke, 7, true) : Filleted(stroke, 0.9f * unit, 6);
      path = Resampled(path, 0.25f * unit);
      SweepOptions options;
      options.keep_up = true;
      options.up = Vec3f::UnitY();
      options.closed = ring;
      options.end_round_m = ring ? 0.0f : 0.95f * r;
      if (ring && (path.front() - path.back()).norm() < 1e-5f) path.pop_back();
      Shape tube = Sweep(path, EllipseSection(2 * r, 2 * r, 36), options);
      // The foil puckers towards its seam, the outline.
      tube = tube.Bent([&](const Vec3f& q) {
        const float side = std::exp(-std::pow(q.y() / (0.45f * r), 2.0f));
        const float pucker =
            0.05f * r * side * std::sin(95 * (q.x() + q.z()) / h * 2 + 4 * noise.At(q * 9));
        return Vec3f(q.x() + pucker, q.y() * (0.86f + 0.03f * noise.At(q * 14)), q.z() + pucker);
      });
      b.Add(tube, Slot("foil", {"metal", "plastic"}));
      stroke.clear();
    };
    for (size_t k = 0; k < glyph.strokes.size();) {
      const char c = glyph.strokes[k];
      if (c == '|') {
        finish();
        ++k;
      } else if (c == ' ') {
        ++k;
      } else {
        stroke.emplace_back(x + unit * static_cast<float>(c - '0') * 0.95f, 0.0f,
                            unit * static_cast<float>(glyph.strokes[k + 1] - '0'));
        k += 2;
      }
    }
    finish();
    x -= 4 * unit * 0.95f + 3.1f * r;
  }
  // Letters read from the front, which looks along -y: x runs to the reader's left.
  Asset asset = b.Finish();
  for (Vec3f& q : asset.mesh.positions) q.head<2>() = -q.head<2>();
  for (Vec3f& n : asset.mesh.normals) n.head<2>() = -n.head<2>();
  return asset;
}

Asset SampleBalloon(Rng& rng) {
  BalloonParams p;
  p.letters = rng.Bernoulli(0.5);
  p.count = rng.UniformInt(1, p.letters ? 3 : 4);
  p.height_m = Draw(rng, 0.35, 0.6);
  p.seed = rng.Seed();
  return MakeBalloon(p);
}

Asset MakeBasketBase(const BasketParams& p) {
  const float r = p.radius_m, h = p.height_m, flare = p.flare;
  const int stakes = p.stakes;
  const float t = 0.0042f * std::max(1.0f, h / 0.2f);  // Larger baskets are of thicker rods.
  AssetBuilder b(p.seed);
  const MaterialSlot wicker = Slot("wicker", {"wood", "bark"});
  const auto radius = [&](float z) {
    return r * (1 + flare * (z / h - 0.5f)) * (0.93f + 0.07f * Smooth01(z / (0.25f * h)));
  };
  Shape posts;
  for (int k = 0; k < stakes; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(stakes);
    Path3 path;
    for (int i = 0; i <= 10; ++i) {
      const float z = h * static_cast<float>(i) / 10.0f;
      path.emplace_back(radius(z) * std::cos(a), radius(z) * std::sin(a), z);
    }
    posts.Add(Tube(path, 0.8f * t, 0.001f, 7));
  }
  b.Add(posts, wicker);
  Shape weave;
  const int rounds = static_cast<int>(h / (1.75f * t));
  const int per = stakes * 3;
  Path3 spiral;
  for (int i = 0; i <= rounds * per; ++i) {
    const float turn = static_cast<float>(i) / static_cast<float>(per);
    const float a = 2 * kPi * turn, z = t + 1.75f * t * turn;
    if (z > h - t) break;
    const float rr = radius(z) + 1.15f * t * std::cos(0.5f * static_cast<float>(stakes) * a);
    spiral.emplace_back(rr * std::cos(a), rr * std::sin(a), z);
  }
  SweepOptions keep;
  keep.keep_up = true;
  weave.Add(Sweep(spiral, EllipseSection(1.6f * t, 1.9f * t, 5), keep));
  b.Add(weave, wicker);
  // Rim of two twisted rods, a base board.
  for (const float phase : {0.0f, kPi}) {
    Path3 rim;
    for (int i = 0; i < 144; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / 144.0f, q = 18 * a + phase;
      const float rr = radius(h) + 1.3f * t * std::cos(q);
      rim.emplace_back(rr * std::cos(a), rr * std::sin(a), h + 1.3f * t * std::sin(q));
    }
    b.Add(Ring(rim, 1.15f * t, 7), wicker);
  }
  b.Add(Cylinder(radius(0) - 0.5f * t, 0.006f, 0.001f, 48).Moved(0, 0, 0.002f),
        Slot("base", {"wood"}));
  if (p.handles) {
    for (const float s : {-1.0f, 1.0f}) {
      const float x = radius(h);
      const Path3 grip = Spline(Path3{{s * x, -0.05f, h - 0.01f},
                                      {s * (x + 0.01f), -0.042f, h + 0.035f},
                                      {s * (x + 0.014f), 0, h + 0.055f},
                                      {s * (x + 0.01f), 0.042f, h + 0.035f},
                                      {s * x, 0.05f, h - 0.01f}},
                                6);
      b.Add(Tube(grip, 1.5f * t, 0, 10), wicker);
    }
  }
  return b.Finish();
}

Asset SampleBasketBase(Rng& rng) {
  BasketParams p;
  p.radius_m = Draw(rng, 0.12, 0.2);
  p.height_m = p.radius_m * Draw(rng, 0.8, 1.5);
  p.flare = Draw(rng, 0.0, 0.25);
  p.stakes = 2 * rng.UniformInt(9, 14) + 1;
  p.handles = rng.Bernoulli(0.6);
  p.seed = rng.Seed();
  return MakeBasketBase(p);
}

void RegisterMisc(std::vector<AssetClass>& classes) {
  classes.push_back({"Pallet", "misc", Placement::kFloor, true, 0, SamplePallet});
  classes.push_back({"Rack", "misc", Placement::kFloorAgainstWall, false, 0.6f, SampleRack});
  classes.push_back({"Balloon", "misc", Placement::kFloor, true, 0, SampleBalloon});
  classes.push_back({"BasketBase", "misc", Placement::kOnTop, true, 0, SampleBasketBase});
}

}  // namespace parallax
