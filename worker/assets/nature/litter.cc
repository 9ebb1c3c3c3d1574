// Litter on the ground under trees: leaves, twigs, cones, needles.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A place in the patch, thinner towards its rim.
Vec3f Strewn(const LitterParams& p, Rng& rng) {
  const float a = Draw(rng, 0, 2 * kPi), r = p.radius_m * std::pow(Draw(rng, 0, 1), 0.62f);
  return {r * std::cos(a), r * std::sin(a), 0};
}

LitterParams PatchOf(Rng& rng, double least_m, double most_m, int least, int most) {
  LitterParams p;
  p.radius_m = Draw(rng, least_m, most_m);
  p.count = rng.UniformInt(least, most);
  p.seed = rng.Seed();
  return p;
}

// A twig that lies: it wanders, forks, and rests on its ends.
void AddTwig(Mesh& wood, const Vec3f& from, float turn, float length, float radius, int forks,
             Rng& rng) {
  std::vector<LimbRing> rings;
  Vec3f at = from;
  float way = turn;
  constexpr int kPieces = 5;
  for (int k = 0; k <= kPieces; ++k) {
    const float s = static_cast<float>(k) / kPieces;
    rings.push_back({at, radius * (1 - 0.55f * s)});
    way += Draw(rng, -0.32, 0.32);
    at += length / kPieces * Vec3f(std::cos(way), std::sin(way), 0.25f * Draw(rng, -1, 1));
    at.z() = std::max(at.z(), 0.6f * radius);
  }
  AddLimb(wood, rings,
          {.sides = radius > 0.004f ? 7 : 5,
           .texture_offset_m = Vec3f{Draw(rng, -9, 9), Draw(rng, -9, 9), Draw(rng, -9, 9)}});
  for (int k = 0; k < forks; ++k) {
    const auto ring = static_cast<size_t>(rng.UniformInt(1, kPieces - 1));
    const float side = k % 2 == 0 ? 1.0f : -1.0f;
    AddTwig(wood, rings[ring].at, turn + side * Draw(rng, 0.45, 0.95),
            length * Draw(rng, 0.3, 0.55), 0.65f * rings[ring].radius, 0, rng);
  }
}

// A cone about +z from the origin, `open` radians between its scales and its axis.
void AddCone(Mesh& core, SheetGrower& scales, const Eigen::Affine3f& place, float length,
             float open, Rng& rng) {
  std::vector<LimbRing> rings;
  const auto width = SmoothThrough({{0, 0.6f}, {0.35f, 1.0f}, {0.75f, 0.62f}, {1, 0.12f}});
  for (int k = 0; k <= 6; ++k) {
    const float s = static_cast<float>(k) / 6;
    rings.push_back({place * Vec3f(0, 0, s * length), 0.15f * length * width(s)});
  }
  AddLimb(core, rings, {.sides = 8});
  const SheetTemplate scale = MakeLeafTemplate({LeafShape::kPetal, 0.72f, -0.5f, 0.25f, 2, 0});
  const int count = 64;
  for (int k = 0; k < count; ++k) {
    const float s = (static_cast<float>(k) + 0.5f) / count, a = 2.39996f * static_cast<float>(k);
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float own = open * (1.15f - 0.7f * s) + Draw(rng, -0.08, 0.08);
    const Vec3f along = std::cos(own) * Vec3f::UnitZ() + std::sin(own) * out;
    const Vec3f up = std::cos(own) * out - std::sin(own) * Vec3f::UnitZ();
    const Vec3f from = Vec3f(0, 0, length * 0.93f * s) + 0.1f * length * width(s) * out;
    scales.Add(scale, {place * from, place.linear() * along, place.linear() * Vec3f(-up),
                       length * (0.16f + 0.18f * width(s))});
  }
}

// Fallen leaves that lie over each other, some curled.
Asset MakeLeafLitter(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "litter");
  SheetGrower leaves(SheetSlot("leaves", {p.seed % 3 == 0 ? "AutumnLeaf" : "DryLeaf"}),
                     rng.Child("leaves"));
  const LeafShape shape = p.seed % 4 < 2    ? LeafShape::kLobed
                          : p.seed % 4 == 2 ? LeafShape::kPalmate
                                            : LeafShape::kOvate;
  const bool near = CurrentDetail() == PlantDetail::kNear;
  std::vector<SheetTemplate> forms;
  // The first five curl up when their upper side looks up, the others when it looks down.
  for (const float curl : {-0.1f, -0.25f, -0.45f, -0.7f, -1.3f, 0.1f, 0.25f, 0.45f, 0.7f, 1.3f}) {
    LeafForm form{shape, shape == LeafShape::kPalmate ? 1.0f : 0.6f, curl, 0.3f, near ? 5 : 2, 0};
    form.twist = 0.4f * curl;
    forms.push_back(MakeLeafTemplate(form));
  }
  for (int k = 0; k < p.count; ++k) {
    SheetPlace place;
    // Later ones lie on earlier ones, a few stand up.
    const float layer = 0.012f * static_cast<float>(k) / static_cast<float>(p.count);
    place.at = Strewn(p, rng) + Vec3f(0, 0, 0.004f + layer + Draw(rng, 0, 0.004));
    const float a = Draw(rng, 0, 2 * kPi), tilt = rng.Bernoulli(0.1) ? 0.5f : 0.1f;
    place.along = Vec3f{std::cos(a), std::sin(a), tilt * Draw(rng, -0.3, 1)};
    place.up = Vec3f{tilt * Draw(rng, -1.5, 1.5), tilt * Draw(rng, -1.5, 1.5), 1};
    const bool turned = rng.Bernoulli(0.4);
    if (turned) place.up = -place.up;
    place.length_m = Draw(rng, 0.05, 0.11);
    leaves.Add(forms[static_cast<size_t>(rng.UniformInt(0, 4) + (turned ? 5 : 0))], place);
  }
  return FinishMeshes({&leaves.mesh()}, p.seed);
}

// Broken twigs.
Asset MakeTwigs(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "twigs");
  Mesh wood;
  wood.slots.push_back(Slot("twigs", {p.seed % 2 == 0 ? "SmoothBark" : "DeadWood"}));
  for (int k = 0; k < p.count; ++k) {
    const float radius = Draw(rng, 0.0025, 0.008);
    const Vec3f from = Strewn(p, rng) + Vec3f(0, 0, radius + Draw(rng, 0, 0.012));
    const float turn = Draw(rng, 0, 2 * kPi), length = Draw(rng, 0.12, 0.5);
    AddTwig(wood, from, turn, length, radius, rng.UniformInt(0, 3), rng);
  }
  return FinishMeshes({&wood}, p.seed);
}

// Cones of pine or spruce.
Asset MakeCones(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "cones");
  SheetGrower scales(SheetSlot("scales", {"DryLeaf"}), rng.Child("scales"));
  Mesh core;
  core.slots.push_back(Slot("core", {"ConiferBark"}));
  const float slim = Draw(rng, 0.7, 1.2);
  for (int k = 0; k < p.count; ++k) {
    const float length = 0.06f * slim * Draw(rng, 0.7, 1.25), open = Draw(rng, 0.4, 1.05);
    const float turn = Draw(rng, 0, 2 * kPi), tilt = Draw(rng, 1.4, 1.65);
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    // SheetGrower lays the open scales that would reach below the ground onto it.
    place.translate(Strewn(p, rng) + Vec3f(0, 0, 0.2f * length));
    place.rotate(Eigen::AngleAxisf(turn, Vec3f::UnitZ()));
    place.rotate(Eigen::AngleAxisf(tilt, Vec3f::UnitX()));
    AddCone(core, scales, place, length, open, rng);
  }
  return FinishMeshes({&core, &scales.mesh()}, p.seed);
}

// Dry needles in pairs.
Asset MakeNeedlePatch(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "needles");
  SheetGrower needles(SheetSlot("needles", {"DryLeaf"}), rng.Child("needles"));
  const SheetTemplate straight = MakeLeafTemplate({LeafShape::kBlade, 0.022f, 0.2f, 0, 2, 0.5f}),
                      bent = MakeLeafTemplate({LeafShape::kBlade, 0.022f, -0.5f, 0, 2, -0.4f});
  for (int k = 0; k < p.count; ++k) {
    const Vec3f at = Strewn(p, rng) + Vec3f(0, 0, Draw(rng, 0.002, 0.012));
    const float a = Draw(rng, 0, 2 * kPi), apart = Draw(rng, 0.05, 0.3),
                length = Draw(rng, 0.05, 0.09), rise = Draw(rng, -0.1, 0.25);
    for (const float side : {-0.5f, 0.5f}) {
      const float own = a + side * apart;
      needles.Add(side > 0 ? straight : bent,
                  {at, {std::cos(own), std::sin(own), rise}, {0.3f * side, 0.1f, 1}, length});
    }
  }
  return FinishMeshes({&needles.mesh()}, p.seed);
}

}  // namespace

Asset SampleLeafLitter(Rng& rng) { return MakeLeafLitter(PatchOf(rng, 0.25, 0.55, 130, 260)); }

Asset SampleTwigs(Rng& rng) { return MakeTwigs(PatchOf(rng, 0.2, 0.45, 9, 20)); }

Asset SampleCones(Rng& rng) { return MakeCones(PatchOf(rng, 0.1, 0.3, 4, 11)); }

Asset SampleNeedlePatch(Rng& rng) { return MakeNeedlePatch(PatchOf(rng, 0.15, 0.35, 260, 520)); }

}  // namespace parallax
