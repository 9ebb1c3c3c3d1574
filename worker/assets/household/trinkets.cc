#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/kernel/subdivide.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot ShellSlot() { return Slot("body", {"GlazedCeramic", "SpeckledCeramic", "Sandstone"}); }

// A tube that grows along a logarithmic spiral: snails and whelks.
Shape SpiralShell(float size, float turns, float growth, float rise, float ridges) {
  const int rings = static_cast<int>(turns * 26), around = 28;
  Shape shell;
  const float end = 2 * kPi * turns;
  // Out to the mouth and, thinner, back in again: the mouth is hollow.
  const int inner = 14, last = rings + inner;
  for (int i = 0; i <= last; ++i) {
    const int along = i <= rings ? i : 2 * rings + 1 - i;
    const float a = end * static_cast<float>(along) / static_cast<float>(rings);
    const float lumen = i <= rings ? 1.0f : Lerp(0.9f, 0.7f, static_cast<float>(i - rings) / inner);
    const float s = size * std::exp(growth * (a - end));
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const Vec3f center = s * out - Vec3f(0, 0, rise * s);
    const float ripple = 1 + ridges * std::sin(9 * a);
    for (int k = 0; k < around; ++k) {
      const float q = 2 * kPi * static_cast<float>(k) / around;
      const float r = 1.06f * lumen * s * ripple * (1 - std::exp(-growth * 2 * kPi));
      shell.AddPoint(center + r * (std::cos(q) * out + 1.15f * std::sin(q) * Vec3f::UnitZ()),
                     {0.02f * a, 0.1f * s * q, 0});
    }
  }
  for (int i = 0; i < last; ++i) {
    for (int k = 0; k < around; ++k) {
      const uint32_t a = static_cast<uint32_t>(i * around + k),
                     c = static_cast<uint32_t>(i * around + (k + 1) % around);
      shell.AddQuad(a, a + around, c + around, c);
    }
  }
  for (const int ring : {0, last}) {
    const uint32_t first = static_cast<uint32_t>(ring * around);
    Vec3f middle = Vec3f::Zero();
    for (int k = 0; k < around; ++k)
      middle += shell.points[first + static_cast<uint32_t>(k)] / around;
    const uint32_t center = shell.AddPoint(middle);
    for (int k = 0; k < around; ++k) {
      const uint32_t a = first + static_cast<uint32_t>(k),
                     c = first + static_cast<uint32_t>((k + 1) % around);
      if (ring == 0)
        shell.AddTriangle(center, a, c);
      else
        shell.AddTriangle(center, c, a);
    }
  }
  if (shell.Volume() < 0) {
    for (Face& f : shell.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
  }
  return shell;
}

// A scallop's half: a fan of ribs, domed.
Shape ScallopHalf(float size, int ribs, float dome) {
  SheetOptions sheet;
  sheet.pieces_u = ribs * 6;
  sheet.pieces_v = 22;
  sheet.thickness_m = 0.0022f;
  sheet.size_m = {size, size};
  return Sheet(
             [=](float u, float v) {
               const float a = Lerp(-1.05f, 1.05f, u);
               const float rib = std::cos(2 * kPi * static_cast<float>(ribs) * u);
               const float radius =
                   size * Lerp(0.03f, 1.0f, v) * (1 - 0.1f * a * a) * (1 + 0.012f * v * rib);
               const float z =
                   dome * size * std::sin(kPi * std::pow(v, 0.62f)) * std::cos(0.62f * a) +
                   0.014f * size * v * rib + 0.004f * size * std::sin(30 * v);
               return Vec3f(radius * std::sin(a), radius * std::cos(a), z);
             },
             sheet)
      .MirroredX()
      .MirroredX();
}

void PineCone(AssetBuilder& b, float size, Rng& rng) {
  const MaterialSlot wood = Slot("scales", {"bark", "wood"});
  b.Add(Ellipsoid({0.24f * size, 0.24f * size, 0.46f * size}, 20).Moved(0, 0, 0.5f * size), wood);
  const int count = 90;
  for (int i = 0; i < count; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / count, a = 2.39996f * static_cast<float>(i);
    const float r = size * 0.25f * std::sin(kPi * std::pow(t, 0.8f)),
                z = size * Lerp(0.06f, 0.96f, t);
    const float open = Lerp(-0.15f, 1.15f, t),
                length = size * Lerp(0.2f, 0.1f, t) * Draw(rng, 0.9, 1.1);
    const BoxOptions box{.bevel_m = 0.02f * size, .pieces = {4, 5, 1}};
    const Shape scale =
        RoundedBox({0.2f * size * (1.1f - 0.6f * t), length, 0.05f * size}, box)
            .Bent([&](const Vec3f& q) {
              const float s = q.y() / length + 0.5f;
              return Vec3f(
                  q.x() * (0.45f + 0.7f * std::sin(kPi * std::min(1.0f, 0.25f + 0.6f * s))),
                  q.y() + 0.5f * length,
                  q.z() * (0.5f + 0.7f * s) + 0.25f * length * s * s -
                      6.0f * q.x() * q.x() / size * 0.3f);
            });
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    place.translate(Vec3f(0, 0, z));
    place.rotate(Eigen::AngleAxisf(a, Vec3f::UnitZ()));
    place.translate(Vec3f(0, 0.75f * r, 0));
    place.rotate(Eigen::AngleAxisf(open, Vec3f::UnitX()));
    b.Add(scale.Placed(place), wood);
  }
}

Shape Pebble(float size, Rng& rng) {
  // A block broken at its corners, worn round.
  Cage block{
      RoundedBox({2 * size, 2 * size * Draw(rng, 0.7, 0.95), 2 * size * Draw(rng, 0.42, 0.6)},
                 {.bevel_m = 0}),
      {}};
  for (Vec3f& q : block.shape.points) {
    const Vec3f off{Draw(rng, -0.28, 0.28), Draw(rng, -0.28, 0.28), Draw(rng, -0.2, 0.2)};
    q = 1.25f * (q + q.cwiseAbs().cwiseProduct(off));
  }
  const Noise noise(rng);
  return Subdivided(block, 4).Bent(
      [&](const Vec3f& q) { return Vec3f(q * (1 + 0.03f * noise.At(2.5f * q / size))); });
}

// A carved beast on four legs: a trunk of three by four cells whose corners below grow into legs,
// whose ends grow into neck, head and tail. `length` is the trunk's.
Shape Animal(float length, Rng& rng) {
  const float leg = length * Draw(rng, 0.35, 0.75), wide = length * Draw(rng, 0.34, 0.48);
  const float belly = length * Draw(rng, 0.34, 0.5), sway = length * Draw(rng, -0.06, 0.06);
  const float neck = length * Draw(rng, 0.12, 0.55), rise = Draw(rng, 0.4, 1.25);
  const float head = length * Draw(rng, 0.2, 0.3), snout = length * Draw(rng, 0.1, 0.26);
  const float tail = length * Draw(rng, 0.1, 0.45), droop = Draw(rng, -1.2, 0.7);
  SlabOptions trunk;
  trunk.columns = 3;
  trunk.rows = 4;
  trunk.point = [&](int i, int j) {
    const float x = (static_cast<float>(i) - 1.5f) / 1.5f, y = static_cast<float>(j) / 4.0f - 0.5f;
    const float slim = 1 - 0.25f * std::cos(4 * kPi * y) * (std::abs(y) < 0.26f ? 1.0f : 0.0f);
    return Vec3f(0.5f * wide * x * slim, length * y,
                 leg + belly + sway * std::cos(2 * kPi * y) - 0.12f * belly * x * x);
  };
  trunk.thickness = [&](int, int j) { return j == 2 ? 0.85f * belly : belly; };
  trunk.rim_sharpness = 0;
  Cage cage = Slab(trunk);
  Shape& s = cage.shape;
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-0.38f, 0.38f}) {
      uint32_t foot = NearestFace(s, {x * 0.33f * wide, y * length, leg});
      const float bend = length * (y < 0 ? -0.05f : 0.02f);
      foot = ExtrudeFace(s, foot, {0, bend, -0.5f * leg}, 0.72f);
      foot = ExtrudeFace(s, foot, {0, -bend, -0.4f * leg}, 0.85f);
      ExtrudeFace(s, foot, {0, 0.03f * length, -0.14f * leg}, 1.3f);
    }
  }
  const float high = leg + 0.5f * belly;
  uint32_t front = NearestFace(s, {0, 0.5f * length, high});
  const Vec3f along(0, std::cos(rise), std::sin(rise));
  front =
      ExtrudeFace(s, front, 0.5f * neck * along + Vec3f(0, 0.04f * length, 0.1f * belly), 0.85f);
  front = ExtrudeFace(s, front, 0.6f * neck * along, 0.8f);
  const Vec3f nod(0, 0.9f, -0.25f);
  front = ExtrudeFace(s, front, 0.3f * head * Vec3f(0, 1, 0.4f), 1.45f);
  front = ExtrudeFace(s, front, 0.7f * head * nod, 0.9f);
  front = ExtrudeFace(s, front, snout * nod, 0.55f);
  uint32_t rear = NearestFace(s, {0, -0.5f * length, high});
  const Vec3f back(0, -std::cos(droop), std::sin(droop));
  rear = ExtrudeFace(s, rear, 0.25f * tail * back + Vec3f(0, 0, 0.2f * belly), 0.3f);
  rear = ExtrudeFace(s, rear, 0.5f * tail * back, 0.7f);
  ExtrudeFace(s, rear, 0.5f * tail * (back - Vec3f(0, 0, 0.4f)), 0.6f);
  const Vec3f poll = Vec3f(0, 0.54f * length, high + 0.1f * belly) + 1.1f * neck * along;
  Shape out = Subdivided(cage, 3);
  // Ears.
  const float ear = head * Draw(rng, 0.2, 0.6), apart = 0.18f * wide + 0.1f * head;
  for (const float x : {-1.0f, 1.0f}) {
    out.Add(Ellipsoid({0.35f * ear + 0.02f * length, 0.16f * ear + 0.015f * length, ear}, 16)
                .TurnedY(x * 0.5f)
                .Moved(poll + Vec3f(x * apart, 0.1f * head, 0.25f * head + 0.5f * ear)));
  }
  return out;
}

void Coral(AssetBuilder& b, const Vec3f& from, const Vec3f& heading, float length, float radius,
           int level, Rng& rng, Shape& out) {
  Path3 path{from};
  Vec3f at = from, dir = heading.normalized();
  for (int k = 0; k < 4; ++k) {
    dir =
        (dir + 0.22f * Vec3f{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -0.3, 1)}).normalized();
    at += dir * (0.25f * length);
    path.push_back(at);
  }
  out.Add(Sweep(Spline(path, 4), EllipseSection(2 * radius, 2 * radius, 12),
                {.scale = [](float t) { return Vec2f::Constant(1.0f - 0.25f * t).eval(); },
                 .end_round_m = 0.6f * radius}));
  if (level == 0) return;
  const int children = rng.UniformInt(2, 3);
  for (int c = 0; c < children; ++c) {
    const float a = Draw(rng, 0, 2 * kPi);
    Coral(b, path[static_cast<size_t>(4 - c)], dir + 0.9f * Vec3f(std::cos(a), std::sin(a), 0.3f),
          0.78f * length, 0.76f * radius, level - 1, rng, out);
  }
}

// An apple, pear, orange, lemon or banana resting on z = 0 before it is placed.
// Half of an apple, orange, pear or lemon.
Path2 FruitProfile(int kind, float r) {
  if (kind == 0)
    return Spline(Path2{{0.02f * r, -0.78f * r},
                        {0.25f * r, -0.86f * r},
                        {0.66f * r, -0.66f * r},
                        {0.98f * r, 0.05f * r},
                        {0.86f * r, 0.6f * r},
                        {0.42f * r, 0.82f * r},
                        {0.12f * r, 0.68f * r},
                        {0.01f * r, 0.58f * r}},
                  5);
  if (kind == 1) return Arc(Vec2f::Zero(), r, 0.95f * r, -0.5f * kPi, 0.5f * kPi, 28);
  if (kind == 2)
    return Spline(Path2{{0.02f * r, -0.86f * r},
                        {0.3f * r, -0.9f * r},
                        {0.8f * r, -0.6f * r},
                        {0.95f * r, -0.1f * r},
                        {0.62f * r, 0.55f * r},
                        {0.42f * r, 1.0f * r},
                        {0.22f * r, 1.25f * r},
                        {0.01f * r, 1.27f * r}},
                  5);
  return Spline(Path2{{0.01f * r, -1.1f * r},
                      {0.14f * r, -1.02f * r},
                      {0.6f * r, -0.7f * r},
                      {0.8f * r, 0},
                      {0.6f * r, 0.7f * r},
                      {0.16f * r, 1.0f * r},
                      {0.01f * r, 1.06f * r}},
                5);
}

void AddFruit(AssetBuilder& b, int kind, const Vec3f& at, Rng& rng) {
  const MaterialSlot skins[] = {Slot("apple", {"FruitSkin"}), Slot("orange", {"CitrusPeel"}),
                                Slot("pear", {"FruitSkin"}), Slot("lemon", {"CitrusPeel"})};
  const float r = Draw(rng, 0.032, 0.041);
  const float tilt = Draw(rng, -0.6, 0.6), turn = Draw(rng, 0, 6.2);
  const auto place = [&](const Shape& s) { return s.TurnedX(tilt).TurnedZ(turn).Moved(at); };
  const Noise noise(rng);
  b.Add(place(Lathe(FruitProfile(kind, r), {.segments = 40}).Bent([&](const Vec3f& q) {
          return Vec3f(q * (1 + 0.03f * noise.At(q / r * 1.3f)));
        })),
        skins[kind]);
  if (kind == 0 || kind == 2) {
    const float z = kind == 0 ? 0.55f * r : 1.22f * r;
    b.Add(place(Tube(
              Spline(Path3{{0, 0, z}, {0.02f * r, 0, z + 0.25f * r}, {0.12f * r, 0, z + 0.5f * r}},
                     4),
              0.0014f, 0.0008f, 8)),
          Slot("stalks", {"bark", "wood"}));
  }
}

// Kinds of small finds.
enum class Trinket { kSnailShell, kScallop, kPineCone, kPebbles, kCoral, kAnimal, kCount };

// One small find for a shelf.
struct TrinketParams {
  Trinket kind = Trinket::kScallop;
  float size_m = 0.07f;
  uint64_t seed = 0;
};

Asset MakeNatureShelfTrinkets(const TrinketParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "form");
  const float size = p.size_m;
  switch (p.kind) {
    case Trinket::kSnailShell: {
      const float turns = Draw(rng, 4.2, 5.4), growth = Draw(rng, 0.075, 0.11),
                  rise = Draw(rng, 0.35, 0.95);
      const Shape shell = SpiralShell(size * 0.62f, turns, growth, rise, 0.012f);
      b.Add(shell.TurnedX(Draw(rng, 1.0, 1.7)), ShellSlot());
      break;
    }
    case Trinket::kScallop: {
      const int ribs = rng.UniformInt(9, 15);
      Shape half = ScallopHalf(size, ribs, Draw(rng, 0.22, 0.32));
      b.Add(half, ShellSlot());
      // The other half, opened.
      const Shape under = half.Bent([](const Vec3f& q) { return Vec3f(q.x(), q.y(), -q.z()); });
      Shape flipped = under;
      for (Face& f : flipped.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
      b.Add(flipped.TurnedX(-Draw(rng, 0.25, 0.55)).Moved(0, 0, -0.004f), ShellSlot());
      break;
    }
    case Trinket::kPineCone:
      PineCone(b, 1.2f * size, rng);
      break;
    case Trinket::kPebbles: {
      // A small pile of pebbles.
      float z = 0;
      float s = 0.75f * size;
      for (int i = 0; i < 4; ++i) {
        const Shape stone = Pebble(s, rng);
        const Box3f box = stone.Bounds();
        b.Add(stone.TurnedZ(Draw(rng, 0, 6))
                  .Moved(
                      Vec3f{Draw(rng, -0.1, 0.1) * s, Draw(rng, -0.1, 0.1) * s, z - box.min().z()}),
              Slot(i % 2 ? "stone" : "stone_b", {"rock", "stone"}));
        z += 0.94f * box.sizes().z();
        s *= Draw(rng, 0.66, 0.84);
      }
      break;
    }
    case Trinket::kAnimal:
      b.Add(Animal(1.4f * size, rng), Slot("body", {"wood", "ceramic", "stone", "metal"}));
      break;
    default: {
      Shape coral;
      for (int i = 0; i < 4; ++i) {
        const float a = 1.6f * static_cast<float>(i);
        Coral(b, {0, 0, 0}, {0.6f * std::cos(a), 0.6f * std::sin(a), 1}, 0.55f * size,
              0.075f * size, 3, rng, coral);
      }
      coral.Add(Pebble(0.4f * size, rng));
      b.Add(coral, Slot("body", {"Sandstone", "GlazedCeramic", "rock"}));
    }
  }
  return b.Finish();
}

Asset SampleNatureShelfTrinkets(Rng& rng) {
  TrinketParams p;
  p.seed = rng.Seed();
  p.kind = DrawEnum<Trinket>(rng, static_cast<int>(Trinket::kCount));
  p.size_m = Draw(rng, 0.05, 0.09);
  return MakeNatureShelfTrinkets(p);
}

// A bowl with fruit.
struct FruitContainerParams {
  float radius_m = 0.125f;
  int fruit = 0;  // The most: 0 apples, 1 oranges, 2 pears, 3 lemons.
  uint64_t seed = 0;
};

// A bowl of fruit.
Asset MakeFruitContainer(const FruitContainerParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "fruit");
  const float r = p.radius_m, h = 0.62f * r;
  const Path2 wall{{0, 0}, {0.45f * r, 0}};
  Path2 curve = Spline(Path2{{0.46f * r, 0.0f},
                             {0.47f * r, 0.06f * h},
                             {0.56f * r, 0.12f * h},
                             {0.86f * r, 0.5f * h},
                             {r, h}},
                       7);
  Path2 outline = wall;
  outline.insert(outline.end(), curve.begin(), curve.end());
  b.Add(Lathe(VesselProfile(outline, 0.004f, 0.008f), {.segments = 72}),
        Slot("body", {"ceramic", "wood", "glass", "metal"}));
  const float floor = 0.02f;
  const int lower = 5;
  const auto kind = [&] { return rng.Bernoulli(0.6) ? p.fruit : rng.UniformInt(0, 3); };
  for (int i = 0; i < lower; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / lower + 0.3f;
    AddFruit(b, kind(), {0.5f * r * std::cos(a), 0.5f * r * std::sin(a), floor + 0.055f}, rng);
  }
  AddFruit(b, kind(), {0, 0, floor + 0.034f}, rng);
  for (int i = 0; i < 3; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 3 + 0.8f;
    AddFruit(b, kind(), {0.28f * r * std::cos(a), 0.28f * r * std::sin(a), floor + 0.102f}, rng);
  }
  return b.Finish();
}

Asset SampleFruitContainer(Rng& rng) {
  return MakeFruitContainer(
      {.radius_m = Draw(rng, 0.11, 0.14), .fruit = rng.UniformInt(0, 3), .seed = rng.Seed()});
}

}  // namespace

void RegisterPlants(std::vector<AssetClass>& classes) {
  classes.push_back({"PlantContainer", "plants", Placement::kOnTop, true, 0, SamplePlantContainer,
                     SizeRange({0.09f, 0.09f, 0.12f}, {0.75f, 0.75f, 0.65f})});
  classes.push_back({"LargePlantContainer", "plants", Placement::kFloor, true, 0,
                     SampleLargePlantContainer,
                     SizeRange({0.25f, 0.25f, 0.4f}, {1.7f, 1.7f, 2.1f})});
  classes.push_back({"Bush", "plants", Placement::kFloor, true, 0, SampleBush,
                     SizeRange({0.4f, 0.4f, 0.3f}, {1.7f, 1.7f, 1.3f})});
  classes.push_back({"Cactus", "plants", Placement::kFloor, false, 0, SampleCactus,
                     SizeRange({0.1f, 0.1f, 0.45f}, {1.1f, 1.1f, 1.6f})});
  classes.push_back({"Urchin", "plants", Placement::kOnTop, false, 0, SampleUrchin,
                     SizeRange({0.06f, 0.06f, 0.04f}, {0.24f, 0.24f, 0.2f})});
  classes.push_back({"NatureShelfTrinkets", "plants", Placement::kOnTop, true, 0,
                     SampleNatureShelfTrinkets,
                     SizeRange({0.03f, 0.03f, 0.02f}, {0.25f, 0.25f, 0.25f})});
  classes.push_back({"FruitContainer", "plants", Placement::kOnTop, true, 0, SampleFruitContainer,
                     SizeRange({0.2f, 0.2f, 0.1f}, {0.32f, 0.32f, 0.26f})});
}

}  // namespace parallax
