// Rack: a warehouse shelf of uprights, beams and wire decks, with cartons and bins on it.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A storage rack with its load.
struct RackParams {
  float width_m = 1.5f, depth_m = 0.6f, height_m = 2.0f;
  int levels = 3;
  uint64_t seed = 0;  // Which cartons and bins stand on it.
};

// Dimensions and slots that the parts of a rack share: half width and depth, the posts' side.
struct RackFrame {
  explicit RackFrame(const RackParams& params)
      : p(params), x(0.5f * params.width_m), y(0.5f * params.depth_m) {}
  const RackParams& p;
  const float x, y, t = 0.05f;
  const MaterialSlot upright = Slot("uprights", {"metal", "paint"}),
                     beam = Slot("beams", {"metal", "paint"}), deck = MetalSlot("deck");
};

// Four posts on foot plates.
void AddUprights(AssetBuilder& b, const RackFrame& f) {
  const float x = f.x, y = f.y, t = f.t;
  b.AddFourfold(Board({x - t, y - t, 0.004f}, {x, y, f.p.height_m}, 0.004f), f.upright);
  b.AddFourfold(Board({x - 0.09f, y - 0.09f, 0}, {x + 0.012f, y + 0.012f, 0.006f}, 0.001f),
                f.upright);
}

void AddSideLattices(AssetBuilder& b, const RackFrame& f) {
  const float x = f.x, y = f.y, t = f.t, h = f.p.height_m;
  const int bays = 5;
  for (int i = 0; i < bays; ++i) {
    const float z0 = Lerp(0.12f, h - 0.12f, static_cast<float>(i) / bays),
                z1 = Lerp(0.12f, h - 0.12f, static_cast<float>(i + 1) / bays);
    const float s = i % 2 ? 1.0f : -1.0f;
    b.AddMirroredX(Bar({x - 0.5f * t, s * (y - t), z0}, {x - 0.5f * t, -s * (y - t), z1},
                       {0.008f, 0.028f}, {0.008f, 0.028f}, 0.002f),
                   f.upright);
    b.AddMirroredX(Bar({x - 0.5f * t, -(y - t), z0}, {x - 0.5f * t, y - t, z0}, {0.008f, 0.028f},
                       {0.008f, 0.028f}, 0.002f),
                   f.upright);
  }
}

// Two beams with the plates that hook into the posts; `z` is a level's height.
void AddBeams(AssetBuilder& b, const RackFrame& f, float z) {
  const float x = f.x, y = f.y, t = f.t;
  for (const float s : {-1.0f, 1.0f})
    b.Add(Board({-x + t, s * (y - 0.025f) - 0.02f, z - 0.09f}, {x - t, s * (y - 0.025f) + 0.02f, z},
                0.004f),
          f.beam);
  for (const float s : {-1.0f, 1.0f}) {
    for (const float q : {-1.0f, 1.0f})
      b.Add(Board({s * (x - t) - 0.006f, q * y - 0.006f, z - 0.13f},
                  {s * (x - t) + 0.03f * -s, q * y + 0.006f, z + 0.03f}, 0.002f),
            f.beam);
  }
}

void AddWireDeck(AssetBuilder& b, const RackFrame& f, float z) {
  const float x = f.x, y = f.y, t = f.t;
  Shape wires;
  const int across = static_cast<int>((f.p.width_m - 2 * t) / 0.05f), along = 6;
  for (int i = 0; i <= across; ++i) {
    const float at =
        Lerp(-x + t + 0.01f, x - t - 0.01f, static_cast<float>(i) / static_cast<float>(across));
    wires.Add(Tube({{at, -y + 0.02f, z + 0.003f}, {at, y - 0.02f, z + 0.003f}}, 0.0028f, 0, 6));
  }
  for (int i = 0; i <= along; ++i) {
    const float at = Lerp(-y + 0.03f, y - 0.03f, static_cast<float>(i) / along);
    wires.Add(
        Tube({{-x + t + 0.005f, at, z - 0.001f}, {x - t - 0.005f, at, z - 0.001f}}, 0.0028f, 0, 6));
  }
  b.Add(wires, f.deck);
}

// The place and size of a thing on a deck.
struct RackItem {
  Vec3f mid;  // The middle of its underside.
  float turn = 0, width = 0, depth = 0, height = 0;
};

// A closed carton with a strip of tape.
void AddRackCarton(AssetBuilder& b, const RackItem& item) {
  const float bw = item.width, bd = item.depth, bh = item.height;
  b.Add(Board({-0.5f * bw, -0.5f * bd, 0}, {0.5f * bw, 0.5f * bd, bh}, 0.003f)
            .TurnedZ(item.turn)
            .Moved(item.mid),
        Slot("cartons", {"paper"}));
  b.Add(Board({-0.5f * bw - 0.0006f, -0.025f, bh - 0.05f},
              {0.5f * bw + 0.0006f, 0.025f, bh + 0.0006f}, 0.0005f)
            .TurnedZ(item.turn)
            .Moved(item.mid),
        Slot("tape", {"plastic", "paper"}));
}

// An open bin: walls, floor, rim.
void AddBin(AssetBuilder& b, const RackItem& item) {
  const float bw = item.width, bd = item.depth, bh = item.height, wall = 0.006f;
  const auto add = [&](const Shape& shape) {
    b.Add(shape.TurnedZ(item.turn).Moved(item.mid), PlasticSlot("bins"));
  };
  for (const float s : {-1.0f, 1.0f}) {
    add(Board({s * 0.45f * bw, -0.45f * bd, 0}, {s * (0.45f * bw - wall), 0.45f * bd, bh}, 0.002f));
    add(Board({-0.45f * bw, s * 0.45f * bd, 0}, {0.45f * bw, s * (0.45f * bd - wall), bh}, 0.002f));
  }
  add(Extrude(RectSection(0.9f * bw, 0.9f * bd, 0.02f, 4), wall, 0.001f));
  const SweepOptions closed{.closed = true, .up = Vec3f::UnitZ(), .keep_up = true};
  Path3 rim;
  for (const Vec2f& q : RectSection(0.9f * bw, 0.9f * bd, 0.012f, 3))
    rim.emplace_back(q.x(), q.y(), bh);
  add(Sweep(rim, RectSection(0.018f, 0.012f, 0.003f, 2), closed));
}

// Cartons and bins side by side, with gaps.
void AddLoad(AssetBuilder& b, const RackFrame& f, float z, Rng& rng) {
  const float x = f.x, t = f.t, d = f.p.depth_m;
  float at = -x + t + 0.06f;
  while (at < x - t - 0.3f) {
    RackItem item;
    item.width = Draw(rng, 0.24, 0.42);
    item.depth = Draw(rng, 0.3, d - 0.12);
    item.height = Draw(rng, 0.16, 0.3);
    if (at + item.width > x - t - 0.03f) break;
    if (rng.Bernoulli(0.75)) {
      item.mid = Vec3f(at + 0.5f * item.width, Draw(rng, -0.03, 0.03), z + 0.0058f);
      item.turn = Draw(rng, -0.06, 0.06);
      rng.Bernoulli(0.6) ? AddRackCarton(b, item) : AddBin(b, item);
    }
    at += item.width + Draw(rng, 0.03, 0.12);
  }
}

// Steel uprights, beams, wire decks, cartons and bins on them.
Asset MakeRack(const RackParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "load");
  const RackFrame frame(p);
  AddUprights(b, frame);
  AddSideLattices(b, frame);
  for (int level = 0; level < p.levels; ++level) {
    const float z = Lerp(0.18f, p.height_m - 0.5f,
                         static_cast<float>(level) / static_cast<float>(p.levels - 1));
    AddBeams(b, frame, z);
    AddWireDeck(b, frame, z);
    AddLoad(b, frame, z, rng);
  }
  return b.Finish();
}

}  // namespace

Asset SampleRack(Rng& rng) {
  return MakeRack({.width_m = Draw(rng, 1.2, 1.9),
                   .depth_m = Draw(rng, 0.5, 0.7),
                   .height_m = Draw(rng, 1.7, 2.2),
                   .levels = rng.UniformInt(3, 4),
                   .seed = rng.Seed()});
}

}  // namespace parallax
