// Agaves and palms.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// One thick leaf of an agave: broad above its foot, hollow above, drawn out into a spine.
void AddAgaveLeaf(Mesh& mesh, float turn, float lift, float length, float width, Rng& rng) {
  const Vec3f out(std::cos(turn), std::sin(turn), 0);
  const float bend = Draw(rng, -0.25, 0.55);
  const int pieces = ByDetail<int>({12, 8, 5, 3});
  std::vector<LimbRing> rings;
  Vec3f at = 0.12f * width * out;
  for (int k = 0; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    const float angle = lift - bend * s;
    const float wide =
        (0.72f + 0.28f * Smooth01(s / 0.35f)) * std::pow(std::max(0.0f, 1 - s), 0.62f);
    rings.push_back({at, std::max(0.008f, 0.5f * width * wide)});
    at += length / static_cast<float>(pieces) *
          (std::cos(angle) * out + std::sin(angle) * Vec3f::UnitZ());
  }
  // The foot is rounded off.
  rings.insert(rings.begin(),
               {rings[0].at - 0.06f * rings[0].radius * (rings[1].at - rings[0].at).normalized(),
                0.9f * rings[0].radius});
  LimbOptions options{.sides = ByDetail<int>({16, 12, 8, 6})};
  // The frame's x lies across the leaf where the path runs outwards; flat side up.
  const Vec3f along = (rings[1].at - rings[0].at).normalized();
  Vec3f x = std::abs(along.x()) < 0.8f ? Vec3f::UnitX() : Vec3f::UnitY();
  x = (x - x.dot(along) * along).normalized();
  const Vec3f y = along.cross(x), across = out.cross(Vec3f::UnitZ());
  const float flat = std::atan2(across.dot(y), across.dot(x));
  options.modulate = [flat](float angle, float) {
    const float c = std::cos(angle - flat), s = std::sin(angle - flat);
    return 1 / std::sqrt(c * c + s * s / (0.34f * 0.34f));
  };
  options.texture_offset_m = {Draw(rng, -20, 20), 0, 0};
  const size_t first = mesh.positions.size();
  AddLimb(mesh, rings, options);
  const auto sides = static_cast<size_t>(options.sides);
  for (size_t i = 0; i < static_cast<size_t>(pieces + 1) * sides; ++i) {
    const float angle = 2 * kPi * static_cast<float>(i % sides) / static_cast<float>(sides);
    mesh.uv[first + i] = {std::abs(std::cos(angle - flat)), 0};
  }
}

// A flat cluster of upright capsules on short stalks, which spread from the end of a branch.
void AddSeedHead(Mesh& mesh, const Vec3f& end, float radius, Rng& rng) {
  const int capsules = ByDetail<int>({18, 14, 10, 6});
  const LimbOptions options{.sides = ByDetail<int>({7, 5, 4, 4})};
  for (int k = 0; k < capsules; ++k) {
    const float share = (static_cast<float>(k) + 0.5f) / static_cast<float>(capsules);
    const float turn = 2.39996f * static_cast<float>(k) + Draw(rng, -0.4, 0.4);
    const float away = radius * std::sqrt(share), rise = radius * Draw(rng, 0.25, 0.6);
    const Vec3f foot = end + Vec3f(away * std::cos(turn), away * std::sin(turn), rise);
    const Vec3f up = Vec3f(0.35f * std::cos(turn), 0.35f * std::sin(turn), 1).normalized();
    const float length = radius * Draw(rng, 0.45, 0.7), thick = 0.2f * length;
    AddLimb(mesh, {{end, 0.05f * radius}, {foot, 0.04f * radius}}, options);
    AddLimb(mesh,
            {{foot - 0.02f * length * up, 0.3f * thick},
             {foot + 0.3f * length * up, thick},
             {foot + 0.75f * length * up, 0.8f * thick},
             {foot + length * up, 0.15f * thick}},
            options);
  }
}

// A rosette of stiff, pointed leaves, some with a flower stalk.
struct AgaveParams {
  float size_m = 0.6f;  // Length of its leaves.
  float width = 0.2f;   // Width of a leaf, in lengths.
  int leaves = 34;
  float mast_m = 0;  // Height of the dry flower stalk; 0: none.
  uint64_t seed = 0;
};

Asset MakeAgave(const AgaveParams& p) {
  Rng rng(SceneSeed{p.seed}, "agave");
  Mesh leaves;
  leaves.slots.push_back(Slot("leaves", {"AgaveSkin"}));
  for (int k = 0; k < p.leaves; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(p.leaves);  // Outer ones first.
    const float length = p.size_m * Lerp(1.0f, 0.62f, t * t) * Draw(rng, 0.85, 1.1);
    const float lift = Lerp(0.12f, 1.45f, std::pow(t, 0.8f)) + Draw(rng, -0.1, 0.1);
    AddAgaveLeaf(leaves, 2.39996f * static_cast<float>(k) + Draw(rng, -0.12, 0.12), lift, length,
                 p.width * length, rng);
  }
  AssetBuilder b(p.seed);
  b.AddMesh(leaves, Eigen::Affine3f::Identity());
  if (p.mast_m > 0) {
    Mesh mast;
    mast.slots.push_back(Slot("mast", {"DeadWood"}));
    LimbOptions options{.sides = 8};
    const float thick = 0.02f + 0.012f * p.mast_m;
    const Vec3f top(0.05f * p.mast_m * Draw(rng, -1, 1), 0.05f * p.mast_m * Draw(rng, -1, 1),
                    p.mast_m);
    AddLimb(mast, {{{0, 0, 0.02f}, thick}, {0.5f * top, 0.8f * thick}, {top, 0.3f * thick}},
            options);
    options.sides = 5;
    for (int k = 0; k < 14; ++k) {
      const float s = Lerp(0.55f, 0.97f, static_cast<float>(k) / 13),
                  a = 2.39996f * static_cast<float>(k);
      const float reach = p.mast_m * 0.17f * (1.15f - s) / 0.5f;
      const Vec3f from = s * top, out(std::cos(a), std::sin(a), 0);
      AddLimb(mast,
              {{from, 0.25f * thick},
               {from + 0.6f * reach * out + Vec3f(0, 0, 0.1f * reach), 0.2f * thick},
               {from + reach * out + Vec3f(0, 0, 0.32f * reach), 0.1f * thick}},
              options);
      AddSeedHead(mast, from + reach * out + Vec3f(0, 0, 0.32f * reach),
                  0.06f * p.mast_m * Draw(rng, 0.7, 1.2), rng);
    }
    b.AddMesh(mast, Eigen::Affine3f::Identity());
  }
  return b.Finish(Anchor::kGround);
}

// Leaflets in two rows along a frond that arches over.
void AddPalmFrond(Mesh& stalks, SheetGrower& leaves, const SheetTemplate& leaflet,
                  const Vec3f& crown, float turn, float lift, float length, Rng& rng) {
  const Vec3f out(std::cos(turn), std::sin(turn), 0), across(-out.y(), out.x(), 0);
  const float bend = Draw(rng, 1.1, 1.7), sway = Draw(rng, -0.2, 0.2);
  constexpr int kPieces = 9;
  std::vector<LimbRing> rings{{crown + 0.05f * out, 0.011f * length}};
  for (int k = 1; k <= kPieces; ++k) {
    const float s = static_cast<float>(k) / kPieces, angle = lift - bend * s;
    const Vec3f way = std::cos(angle) * out + std::sin(angle) * Vec3f::UnitZ() + sway * s * across;
    rings.push_back(
        {rings.back().at + length / kPieces * way.normalized(), 0.011f * length * (1 - 0.9f * s)});
  }
  AddLimb(stalks, rings, {.sides = ByDetail<int>({6, 5, 4, 3})});
  const int pairs = ByDetail<int>({44, 22, 9, 3});
  const float wider = std::sqrt(44.0f / static_cast<float>(pairs));
  for (int k = 0; k < pairs; ++k) {
    const float s = Lerp(0.16f, 0.98f, (static_cast<float>(k) + 0.5f) / static_cast<float>(pairs));
    const float f = kPieces * s;
    const size_t i = std::min<size_t>(kPieces - 1, static_cast<size_t>(f));
    const Vec3f ahead = (rings[i + 1].at - rings[i].at).normalized();
    const Vec3f at = rings[i].at + (f - static_cast<float>(i)) * (rings[i + 1].at - rings[i].at);
    const float shape = std::pow(std::max(0.0f, std::sin(kPi * std::pow(s, 0.8f))), 0.5f);
    for (const float side : {-1.0f, 1.0f}) {
      const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
      leaves.Add(leaflet,
                 {.at = at,
                  .along = side * across + 0.75f * ahead - 0.35f * Vec3f::UnitZ() + 0.12f * shake,
                  .up = Vec3f::UnitZ() + 0.5f * side * across + 0.2f * shake,
                  .length_m = 0.27f * length * (0.25f + 0.75f * shape) * (0.7f + 0.3f * wider)});
    }
  }
}

// A palm tree.
struct PalmParams {
  float height_m = 6;
  float lean = 0.1f;
  float frond_m = 2.2f;
  int fronds = 26;
  int dead = 4;  // Dry fronds that hang below the crown.
  uint64_t seed = 0;
};

Asset MakePalm(const PalmParams& p) {
  Rng rng(SceneSeed{p.seed}, "palm");
  Mesh stalks, trunk;
  stalks.slots.push_back(Slot("stalks", {"SmoothBark"}));
  trunk.slots.push_back(Slot("bark", {"FurrowedBark"}));
  SheetGrower leaves(SheetSlot("leaves", {"SummerLeaf"}), rng.Child("leaves"));
  SheetGrower dead(SheetSlot("dead leaves", {"DryLeaf"}), rng.Child("dead"));
  const float h = p.height_m, r = 0.1f + 0.014f * h, lean = p.lean * h, to = Draw(rng, 0, 2 * kPi);
  std::vector<LimbRing> rings;
  const int pieces = std::max(6, static_cast<int>(h / ByDetail<float>({0.12f, 0.25f, 0.7f, 1.5f})));
  for (int k = 0; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    const float bow = lean * (1 - (1 - s) * (1 - s));
    // Stumps of old fronds stand out by turns.
    const float stub = CurrentDetail() == PlantDetail::kNear && k % 2 == 1 ? 1.07f : 1.0f;
    rings.push_back({Vec3f(bow * std::cos(to), bow * std::sin(to), s * h),
                     stub * r * (1 + 0.45f * std::exp(-s * h / 0.25f) - 0.3f * s)});
  }
  const Vec3f crown = rings.back().at;
  rings.push_back({crown + Vec3f(0, 0, 0.25f), 0.2f * r});
  AddLimb(trunk, rings, {.sides = ByDetail<int>({18, 12, 8, 5})});
  const LeafForm form{LeafShape::kLance,
                      ByDetail<float>({0.075f, 0.11f, 0.2f, 0.5f}),
                      0.5f,
                      0.12f,
                      ByDetail<int>({3, 2, 1, 1}),
                      0};
  const SheetTemplate leaflet = MakeLeafTemplate(form);
  for (int k = 0; k < p.fronds; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(p.fronds);
    AddPalmFrond(stalks, leaves, leaflet, crown + Vec3f(0, 0, 0.1f + 0.2f * t),
                 2.39996f * static_cast<float>(k) + Draw(rng, -0.2, 0.2), Lerp(0.05f, 1.35f, t),
                 p.frond_m * Draw(rng, 0.85, 1.1) * Lerp(1.0f, 0.8f, t), rng);
  }
  for (int k = 0; k < p.dead; ++k) {
    AddPalmFrond(stalks, dead, leaflet, crown - Vec3f(0, 0, 0.1f),
                 2.39996f * static_cast<float>(k) + Draw(rng, -0.5, 0.5), Draw(rng, -1.1, -0.6),
                 0.7f * p.frond_m * Draw(rng, 0.8, 1.1), rng);
  }
  AssetBuilder b(p.seed);
  for (const Mesh* part : {static_cast<const Mesh*>(&trunk), static_cast<const Mesh*>(&stalks),
                           &leaves.mesh(), &dead.mesh()}) {
    if (!part->triangles.empty()) b.AddMesh(*part, Eigen::Affine3f::Identity());
  }
  return b.Finish(Anchor::kGround);
}

}  // namespace

Asset SampleAgave(Rng& rng) {
  AgaveParams p;
  p.size_m = Draw(rng, 0.3, 0.95);
  p.width = Draw(rng, 0.15, 0.28);
  p.leaves = rng.UniformInt(22, 46);
  p.mast_m = rng.Bernoulli(0.15) ? p.size_m * Draw(rng, 2.4, 4.0) : 0;
  p.seed = rng.Seed();
  return MakeAgave(p);
}

Asset SamplePalm(Rng& rng) {
  return MakePalm({.height_m = Draw(rng, 2.5, 9),
                   .lean = Draw(rng, 0.02, 0.22),
                   .frond_m = Draw(rng, 1.6, 2.7),
                   .fronds = rng.UniformInt(20, 34),
                   .dead = rng.UniformInt(0, 8),
                   .seed = rng.Seed()});
}

}  // namespace parallax
