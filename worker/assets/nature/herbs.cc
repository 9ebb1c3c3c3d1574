// Ferns, flowers, mushrooms, succulents.
#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"
#include "worker/assets/plants/plant_growth.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A stalk that bends over by `bend` radians towards `out`.
std::vector<LimbRing> StalkRings(const Vec3f& from, const Vec3f& out, float lift, float bend,
                                 float length, float radius, int pieces) {
  std::vector<LimbRing> rings{{from, radius}};
  for (int k = 1; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    const float angle = lift - bend * (s - 0.5f / static_cast<float>(pieces));
    const Vec3f way = std::cos(angle) * out + std::sin(angle) * Vec3f::UnitZ();
    rings.push_back(
        {rings.back().at + length / static_cast<float>(pieces) * way, radius * (1 - 0.75f * s)});
  }
  return rings;
}

void AddStalk(Mesh& stalks, const std::vector<LimbRing>& rings, int sides) {
  AddLimb(stalks, rings, {.sides = sides});
}

// A fern: fronds that arch out of one root.
struct FernParams {
  int fronds = 10;
  float length_m = 0.6f;
  uint64_t seed = 0;
};

// Pinnae on both sides of a frond, each a comb of leaflets.
void AddFrond(Mesh& stalks, SheetGrower& leaves, const std::vector<SheetTemplate>& pinnae,
              const FernParams& p, float turn, Rng& rng) {
  const Vec3f out(std::cos(turn), std::sin(turn), 0), across(-out.y(), out.x(), 0);
  const float length = p.length_m * Draw(rng, 0.65, 1.1), lift = Draw(rng, 1.05, 1.45);
  const float bend = Draw(rng, 0.75, 1.45), sway = Draw(rng, -0.25, 0.25);
  std::vector<LimbRing> rings =
      StalkRings(0.015f * out, out, lift, bend, length, 0.004f * p.length_m / 0.6f, 12);
  for (size_t i = 0; i < rings.size(); ++i) {
    const float s = static_cast<float>(i) / 12;
    rings[i].at += sway * length * s * s * across;
  }
  AddStalk(stalks, rings, 4);
  const int pairs = 19;
  for (int k = 0; k < pairs; ++k) {
    const float s = Lerp(0.2f, 0.99f, (static_cast<float>(k) + 0.5f) / pairs);
    const float f = 12 * s;
    const size_t i = std::min<size_t>(11, static_cast<size_t>(f));
    const Vec3f ahead = (rings[i + 1].at - rings[i].at).normalized();
    const Vec3f at = rings[i].at + (f - static_cast<float>(i)) * (rings[i + 1].at - rings[i].at);
    // Longest a third out; the tip runs to nothing.
    const float shape = std::pow(1 - s, 0.75f) * (0.55f + 0.45f * Smooth01((s - 0.15f) / 0.22f));
    for (const float side : {-1.0f, 1.0f}) {
      const Vec3f up = ahead.cross(side * across).z() > 0 ? ahead.cross(side * across)
                                                          : Vec3f(-ahead.cross(side * across));
      const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
      leaves.Add(pinnae[static_cast<size_t>(k) % pinnae.size()],
                 {.at = at,
                  .along = side * across + 0.42f * ahead - 0.12f * Vec3f::UnitZ() + 0.08f * shake,
                  .up = up + 0.15f * shake,
                  .length_m = length * 0.36f * (shape + 0.05f)});
    }
  }
}

// One flower's petals about its middle: `axis` is where it looks.
struct Blossom {
  int petals, rings;
  float petal_m, width, open;  // `open`: radians from the axis.
};

void AddBlossom(SheetGrower& petals, const Blossom& b, const Vec3f& at, const Vec3f& axis,
                Rng& rng) {
  const Vec3f x =
      axis.cross(std::abs(axis.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX()).normalized();
  const Vec3f y = axis.cross(x);
  const SheetTemplate petal = MakeLeafTemplate({LeafShape::kPetal, b.width, 0.35f, 0.1f, 2, 0});
  for (int ring = 0; ring < b.rings; ++ring) {
    const float open = b.open * (1 - 0.3f * static_cast<float>(ring));
    for (int k = 0; k < b.petals; ++k) {
      const float a = 2 * kPi * (static_cast<float>(k) + 0.5f * static_cast<float>(ring)) /
                          static_cast<float>(b.petals) +
                      Draw(rng, -0.08, 0.08);
      const Vec3f out = std::cos(a) * x + std::sin(a) * y;
      const float own = open + Draw(rng, -0.12, 0.12);
      const Vec3f along = std::cos(own) * axis + std::sin(own) * out;
      petals.Add(petal,
                 {at + 0.12f * b.petal_m * out, along, std::sin(own) * axis - std::cos(own) * out,
                  b.petal_m * Draw(rng, 0.85, 1.1)});
    }
  }
}

// The domed disc in a flower's middle.
void AddDisc(Mesh& discs, const Vec3f& at, const Vec3f& axis, float radius) {
  AddLimb(discs,
          {{at - 0.5f * radius * axis, 0.5f * radius},
           {at, radius},
           {at + 0.35f * radius * axis, 0.8f * radius},
           {at + 0.5f * radius * axis, 0.1f * radius}},
          {.sides = 10});
}

// Forms of flower heads.
enum class FlowerKind { kDaisy, kPoppy, kBell, kDandelion, kCount };

const char* PetalOf(FlowerKind kind) { return kind == FlowerKind::kDaisy ? "WhitePetal" : "Petal"; }

Blossom BlossomOf(FlowerKind kind) {
  switch (kind) {
    case FlowerKind::kDaisy:
      return {18, 1, 0.026f, 0.28f, 1.42f};
    case FlowerKind::kPoppy:
      return {4, 1, 0.048f, 1.15f, 1.05f};
    case FlowerKind::kBell:
      return {5, 1, 0.022f, 0.6f, 0.45f};
    default:
      return {20, 3, 0.022f, 0.2f, 1.35f};
  }
}

void AddLeafRosette(SheetGrower& leaves, float size, int count, Rng& rng) {
  const SheetTemplate leaf = MakeLeafTemplate({LeafShape::kPetal, 0.3f, 0.7f, 0.15f, 3, 0.3f});
  for (int k = 0; k < count; ++k) {
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.3, 0.3);
    const Vec3f out(std::cos(a), std::sin(a), 0);
    leaves.Add(leaf,
               {0.006f * out + Vec3f(0, 0, 0.004f), out + Draw(rng, 0.2, 0.9) * Vec3f::UnitZ(),
                Vec3f::UnitZ() - 0.3f * out, size * Draw(rng, 0.6, 1.1)});
  }
}

struct FlowerParams {
  FlowerKind kind = FlowerKind::kDaisy;
  int stems = 6;
  float height_m = 0.3f;
  uint64_t seed = 0;
};

struct FlowerParts {
  SheetGrower leaves, petals;
  Mesh stalks, discs;
  Blossom blossom;
  SheetTemplate stem_leaf = MakeLeafTemplate({LeafShape::kLance, 0.24f, 0.6f, 0.15f, 2, 0});

  FlowerParts(const FlowerParams& p, const Rng& rng)
      : leaves(SheetSlot("leaves", {"SummerLeaf"}), rng.Child("leaves")),
        petals(SheetSlot("petals", {PetalOf(p.kind)}), rng.Child("petals")),
        blossom(BlossomOf(p.kind)) {
    stalks.slots.push_back(Slot("stalks", {"GrassBlade"}));
    discs.slots.push_back(Slot("discs", {"Petal"}));
  }
};

// One stalk with its leaves and what blooms on it.
void AddFlower(FlowerParts& parts, const FlowerParams& p, int k, Rng& rng) {
  const bool bells = p.kind == FlowerKind::kBell;
  const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.4, 0.4);
  const Vec3f out(std::cos(a), std::sin(a), 0);
  const float length = p.height_m * Draw(rng, 0.65, 1.1), lift = Draw(rng, 1.15, 1.5);
  const float bend = bells ? 0.9f : Draw(rng, 0.0, 0.4);
  const std::vector<LimbRing> rings =
      StalkRings(0.01f * out, out, lift, bend, length, 0.0018f + 0.003f * p.height_m, 7);
  AddStalk(parts.stalks, rings, 5);
  for (int i = 1; i < 6; ++i) {
    const float turn = a + 2.4f * static_cast<float>(i);
    SheetPlace place{rings[static_cast<size_t>(i)].at};
    place.along = Vec3f(std::cos(turn), std::sin(turn), 0.6f);
    place.length_m = 0.26f * length * Draw(rng, 0.6, 1.1) / std::sqrt(static_cast<float>(i));
    parts.leaves.Add(parts.stem_leaf, place);
  }
  const Vec3f top = rings.back().at;
  if (bells) {
    for (int i = 0; i < 7; ++i) {
      const float s = static_cast<float>(i) / 6, turn = a + 1.9f * static_cast<float>(i);
      const Vec3f axis = Vec3f(std::cos(turn), std::sin(turn), -0.7f).normalized();
      AddBlossom(parts.petals, parts.blossom, rings[4].at + s * (top - rings[4].at), axis, rng);
    }
    return;
  }
  const Vec3f shake{Draw(rng, -0.35, 0.35), Draw(rng, -0.35, 0.35), Draw(rng, 0, 0.5)};
  const Vec3f axis = ((top - rings[5].at).normalized() + shake).normalized();
  AddBlossom(parts.petals, parts.blossom, top, axis, rng);
  const float disc = p.kind == FlowerKind::kDaisy ? 0.36f : 0.22f;
  AddDisc(parts.discs, top + 0.001f * axis, axis, disc * parts.blossom.petal_m);
}

Asset MakeFern(const FernParams& p) {
  Rng rng(SceneSeed{p.seed}, "fern");
  SheetGrower leaves(SheetSlot("leaves", {"FernLeaf"}), rng.Child("leaves"));
  Mesh stalks;
  stalks.slots.push_back(Slot("stalks", {"SmoothBark"}));
  constexpr int kTeeth[] = {9, 5, 3, 3};
  std::vector<SheetTemplate> pinnae;
  for (const float fold : {0.05f, 0.12f, 0.2f}) {
    pinnae.push_back(MakeSprayTemplate(kTeeth[static_cast<int>(CurrentDetail())], 0.17f, fold));
  }
  for (int k = 0; k < p.fronds; ++k) {
    AddFrond(stalks, leaves, pinnae, p, 2.39996f * static_cast<float>(k) + Draw(rng, -0.3, 0.3),
             rng);
  }
  AssetBuilder b(p.seed);
  b.AddMesh(stalks, Eigen::Affine3f::Identity());
  b.AddMesh(leaves.mesh(), Eigen::Affine3f::Identity());
  return b.Finish(Anchor::kGround);
}

Asset MakeFlowerPlant(const FlowerParams& p) {
  Rng rng(SceneSeed{p.seed}, "flower");
  FlowerParts parts(p, rng);
  AddLeafRosette(parts.leaves, 0.32f * p.height_m, rng.UniformInt(9, 16), rng);
  for (int k = 0; k < p.stems; ++k) AddFlower(parts, p, k, rng);
  return FinishMeshes({&parts.stalks, &parts.leaves.mesh(), &parts.petals.mesh(), &parts.discs},
                      p.seed);
}

// A group of mushrooms.
struct MushroomParams {
  int count = 5;
  float height_m = 0.07f;
  float cap_width = 1.1f;  // In heights.
  float cap_dome = 0.5f;   // 0 flat, 1 a ball.
  uint64_t seed = 0;
};

Asset MakeMushrooms(const MushroomParams& p) {
  Rng rng(SceneSeed{p.seed}, "mushrooms");
  AssetBuilder b(p.seed);
  for (int k = 0; k < p.count; ++k) {
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.5, 0.5);
    const float h = p.height_m * (k == 0 ? 1.0f : Draw(rng, 0.35, 0.9));
    const float away = k == 0 ? 0.0f : p.height_m * Draw(rng, 0.45, 1.3);
    const float r = 0.5f * p.cap_width * h, stem = h * Draw(rng, 0.075, 0.12),
                dome = r * p.cap_dome;
    const float lean = Draw(rng, -0.22, 0.22), to = Draw(rng, 0, 6.2);
    const Noise noise(rng);
    const auto wobble = [&](const Vec3f& q) {
      const float s = q.z() / h;
      const Vec3f side(std::cos(to), std::sin(to), 0);
      return Vec3f(q + lean * h * s * s * side + 0.05f * r * noise.Vector(2.5f * q / r));
    };
    const Path2 stalk = Spline(Path2{{0, -0.1f * h},
                                     {1.25f * stem, -0.08f * h},
                                     {1.1f * stem, 0.15f * h},
                                     {0.9f * stem, 0.6f * h},
                                     {0.85f * stem, 0.93f * h},
                                     {0.0f, 0.95f * h}},
                               4);
    // Over the rim and back in below, where the gills are.
    const Path2 cap = Spline(Path2{{0, h - 0.62f * dome},
                                   {0.5f * r, h - 0.72f * dome},
                                   {0.93f * r, h - 0.98f * dome},
                                   {r, h - 0.9f * dome},
                                   {0.82f * r, h - 0.42f * dome},
                                   {0.42f * r, h - 0.07f * dome},
                                   {0, h}},
                             5);
    const Eigen::Affine3f place(Eigen::Translation3f(away * std::cos(a), away * std::sin(a), 0));
    b.Add(Lathe(stalk, {.segments = 16}).Bent(wobble).Placed(place),
          Slot("stems", {"MushroomSkin"}));
    b.Add(Lathe(cap, {.segments = 32}).Bent(wobble).Placed(place), Slot("caps", {"MushroomSkin"}));
  }
  return b.Finish(Anchor::kGround);
}

// Rosettes of fleshy leaves.
struct SucculentParams {
  int rosettes = 3;
  float size_m = 0.25f;
  uint64_t seed = 0;
};

Asset MakeSucculent(const SucculentParams& p) {
  Rng rng(SceneSeed{p.seed}, "succulent");
  AssetBuilder b(p.seed);
  for (int k = 0; k < p.rosettes; ++k) {
    const float size = p.size_m * (k == 0 ? 1.0f : Draw(rng, 0.35, 0.65));
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.4, 0.4),
                away = k == 0 ? 0.0f : 0.95f * p.size_m * Draw(rng, 0.8, 1.15);
    // Side rosettes are smaller: coarser faces are as small.
    const DetailScope scope(k == 0 ? 0.0f : std::max(TargetEdge(), 0.22f * size));
    AssetBuilder one(p.seed + static_cast<uint64_t>(k));
    GrowRosette(one, 0, size, rng);
    b.AddMesh(one.mesh(), Eigen::Affine3f(Eigen::Translation3f(away * std::cos(a),
                                                               away * std::sin(a), 0.02f * size)));
  }
  return b.Finish(Anchor::kGround);
}

}  // namespace

Asset SampleFern(Rng& rng) {
  return MakeFern(
      {.fronds = rng.UniformInt(7, 14), .length_m = Draw(rng, 0.4, 0.95), .seed = rng.Seed()});
}

Asset SampleFlowerPlant(Rng& rng) {
  return MakeFlowerPlant({.kind = DrawEnum<FlowerKind>(rng, static_cast<int>(FlowerKind::kCount)),
                          .stems = rng.UniformInt(4, 10),
                          .height_m = Draw(rng, 0.16, 0.45),
                          .seed = rng.Seed()});
}

Asset SampleMushrooms(Rng& rng) {
  return MakeMushrooms({.count = rng.UniformInt(1, 7),
                        .height_m = Draw(rng, 0.05, 0.14),
                        .cap_width = Draw(rng, 0.7, 1.35),
                        .cap_dome = Draw(rng, 0.4, 0.95),
                        .seed = rng.Seed()});
}

Asset SampleSucculent(Rng& rng) {
  return MakeSucculent(
      {.rosettes = rng.UniformInt(1, 3), .size_m = Draw(rng, 0.12, 0.45), .seed = rng.Seed()});
}

}  // namespace parallax
