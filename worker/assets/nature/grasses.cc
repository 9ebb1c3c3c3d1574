// Grass in tufts, clumps and tussocks; reeds.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Fewer, wider blades further away.
float BladeStride() {
  constexpr float kStrides[] = {1, 2, 4, 8};
  return kStrides[static_cast<int>(CurrentDetail())];
}

std::vector<SheetTemplate> BladeTemplates(float width, float droop) {
  const bool near = CurrentDetail() == PlantDetail::kNear;
  std::vector<SheetTemplate> blades;
  for (const float more : {0.35f, 0.75f, 1.15f, 1.7f}) {
    LeafForm form{LeafShape::kBlade, width * BladeStride(), droop * more, 0, near ? 4 : 2, 0};
    form.twist = 0.5f * (more - 0.8f);
    blades.push_back(MakeLeafTemplate(form));
  }
  return blades;
}

// A tuft of grass.
struct GrassParams {
  int blades = 45;
  float height_m = 0.25f;
  float radius_m = 0.05f;  // Size of the patch that blades rise from.
  float width_m = 0.005f;
  float droop = 0.8f;  // Radians that blades bend by, on average.
  float lean = 0.15f;  // To one side, as wind combs.
  float dry = 0.2f;    // Share of dry blades.
  int seed_heads = 0;
  bool short_outside = false;  // A mound: blades at the rim are shorter.
  uint64_t seed = 0;
};

// An ear: spikelets about the end of a stalk.
void AddSeedHead(Mesh& stalks, SheetGrower& ears, const GrassParams& p, Rng& rng) {
  const float height = p.height_m * Draw(rng, 1.05, 1.5), a = Draw(rng, 0, 2 * kPi);
  const Vec3f out(std::cos(a), std::sin(a), 0);
  const float reach = height * (Draw(rng, 0.05, 0.3) + 0.5f * p.lean);
  std::vector<LimbRing> rings;
  for (int k = 0; k <= 5; ++k) {
    const float s = static_cast<float>(k) / 5;
    rings.push_back({0.5f * p.radius_m * out + reach * s * s * out + Vec3f(0, 0, height * s),
                     0.0011f * (1 - 0.5f * s)});
  }
  AddLimb(stalks, rings, {.sides = 3});
  const SheetTemplate grain = MakeLeafTemplate({LeafShape::kElliptic, 0.3f, 0.2f, 0, 1, 0});
  for (int k = 0; k < 16; ++k) {
    const float s = Lerp(0.74f, 1.0f, static_cast<float>(k) / 15);
    const float turn = 2.39996f * static_cast<float>(k);
    ears.Add(grain, {.at = rings[4].at + (s - 0.8f) / 0.2f * (rings[5].at - rings[4].at),
                     .along = Vec3f(0.5f * std::cos(turn), 0.5f * std::sin(turn), 1) +
                              reach / height * out,
                     .up = Vec3f(std::cos(turn), std::sin(turn), 0.2f),
                     .length_m = (0.012f + 0.02f * p.height_m) * Draw(rng, 0.7, 1.1)});
  }
}

// Reeds at the edge of water; with `cattail`, flower spikes.
struct ReedParams {
  int stems = 14;
  float height_m = 1.7f;
  bool cattail = false;
  uint64_t seed = 0;
};

struct ReedParts {
  SheetGrower leaves, plumes;
  Mesh stems;
  std::vector<SheetTemplate> blades = BladeTemplates(0.032f, 0.9f);
  SheetTemplate wisp = MakeLeafTemplate({LeafShape::kElliptic, 0.12f, 0.6f, 0, 1, 0});

  ReedParts(const ReedParams& p, const Rng& rng)
      : leaves(SheetSlot("blades", {"GrassBlade"}), rng.Child("leaves")),
        plumes(SheetSlot("plumes", {"DryGrass"}), rng.Child("plumes")) {
    stems.slots = {Slot("stems", {"GrassBlade"}), Slot("heads", {"DeadWood"})};
    if (!p.cattail) stems.slots.pop_back();
  }
};

// The brown head of a cattail from `low` to `top`.
void AddCattail(Mesh& stems, const Vec3f& low, const Vec3f& top) {
  const LimbOptions head{.sides = 10, .slot = 1};
  const Vec3f way = (top - low).normalized();
  AddLimb(stems,
          SmoothRings({{low, 0.004f},
                       {low + 0.02f * way, 0.013f},
                       {low + 0.13f * way, 0.0135f},
                       {low + 0.15f * way, 0.004f}},
                      3),
          head);
}

void AddReed(ReedParts& parts, const ReedParams& p, int k, Rng& rng) {
  const float a = 2.39996f * static_cast<float>(k), r = 0.16f * std::sqrt(Draw(rng, 0, 1));
  const Vec3f out(std::cos(a), std::sin(a), 0);
  const float height = p.height_m * Draw(rng, 0.65, 1.05), lean = Draw(rng, 0.0, 0.16);
  std::vector<LimbRing> rings;
  for (int i = 0; i <= 6; ++i) {
    const float s = static_cast<float>(i) / 6;
    rings.push_back(
        {r * out + height * (lean * s * s * out + Vec3f(0, 0, s)), 0.0045f * (1 - 0.6f * s)});
  }
  AddLimb(parts.stems, rings, {.sides = 5});
  const int count = rng.UniformInt(5, 8);
  for (int i = 0; i < count; ++i) {
    const float s = Draw(rng, 0.05, 0.8), turn = a + 2.4f * static_cast<float>(i);
    const Vec3f side(std::cos(turn), std::sin(turn), 0);
    SheetPlace place{rings[static_cast<size_t>(6 * s)].at};
    place.along = Vec3f::UnitZ() + Draw(rng, 0.2, 0.6) * side;
    place.up = -side;
    place.length_m = height * Draw(rng, 0.28, 0.5);
    parts.leaves.Add(parts.blades[static_cast<size_t>(rng.UniformInt(0, 3))], place);
  }
  const Vec3f top = rings.back().at;
  if (p.cattail) return AddCattail(parts.stems, rings[5].at, top);
  for (int i = 0; i < 26; ++i) {
    const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, 0, 1)};
    const Vec3f at = top - Vec3f(0, 0, 0.008f * static_cast<float>(i));
    const Vec3f along = 0.6f * shake + Vec3f(0, 0, 0.6f) + 0.5f * out;
    parts.plumes.Add(parts.wisp, {at, along, shake, Draw(rng, 0.05, 0.11)});
  }
}

Asset MakeGrass(const GrassParams& p) {
  Rng rng(SceneSeed{p.seed}, "grass");
  SheetGrower green(SheetSlot("blades", {"GrassBlade"}), rng.Child("green"));
  SheetGrower dry(SheetSlot("dry", {"DryGrass"}), rng.Child("dry"));
  Mesh stalks;
  stalks.slots.push_back(Slot("stalks", {"DryGrass"}));
  const std::vector<SheetTemplate> blades = BladeTemplates(p.width_m / p.height_m, p.droop);
  const float wind = Draw(rng, 0, 2 * kPi);
  const Vec3f lean(p.lean * std::cos(wind), p.lean * std::sin(wind), 0);
  for (int k = 0; k < p.blades; ++k) {
    const float r = std::sqrt(Draw(rng, 0, 1)), a = 2.39996f * static_cast<float>(k);
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float open = (0.12f + 0.55f * r) * Draw(rng, 0.5, 1.3);
    const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), 0};
    SheetPlace place;
    place.at = p.radius_m * r * out;
    place.along = Vec3f::UnitZ() + open * out + lean + 0.12f * shake;
    place.up = -out - 1.5f * lean + 0.5f * shake;
    place.length_m = p.height_m * Draw(rng, 0.5, 1.1) * (p.short_outside ? 1.15f - 0.5f * r : 1.0f);
    const bool is_dry = rng.Bernoulli(static_cast<double>(p.dry));
    const auto form = static_cast<size_t>(rng.UniformInt(0, 3));
    if (k % static_cast<int>(BladeStride()) == 0) (is_dry ? dry : green).Add(blades[form], place);
  }
  for (int k = 0; k < p.seed_heads; ++k) AddSeedHead(stalks, dry, p, rng);
  return FinishMeshes({&green.mesh(), &dry.mesh(), &stalks}, p.seed);
}

Asset MakeReed(const ReedParams& p) {
  Rng rng(SceneSeed{p.seed}, "reed");
  ReedParts parts(p, rng);
  for (int k = 0; k < p.stems; ++k) AddReed(parts, p, k, rng);
  return FinishMeshes({&parts.leaves.mesh(), &parts.plumes.mesh(), &parts.stems}, p.seed);
}

}  // namespace

Asset SampleGrassTuft(Rng& rng) {
  return MakeGrass({.blades = rng.UniformInt(60, 95),
                    .height_m = Draw(rng, 0.12, 0.4),
                    .radius_m = Draw(rng, 0.025, 0.06),
                    .width_m = Draw(rng, 0.0035, 0.006),
                    .droop = Draw(rng, 0.5, 1.4),
                    .lean = Draw(rng, 0.0, 0.35),
                    .dry = Draw(rng, 0.05, 0.5),
                    .seed_heads = rng.Bernoulli(0.5) ? rng.UniformInt(2, 7) : 0,
                    .seed = rng.Seed()});
}

// About a square metre of tufts, denser here than there.
Asset SampleGrassClump(Rng& rng) {
  return MakeGrass({.blades = rng.UniformInt(420, 620),
                    .height_m = Draw(rng, 0.14, 0.38),
                    .radius_m = Draw(rng, 0.35, 0.55),
                    .width_m = Draw(rng, 0.004, 0.006),
                    .droop = Draw(rng, 0.5, 1.3),
                    .lean = Draw(rng, 0.1, 0.35),
                    .dry = Draw(rng, 0.05, 0.45),
                    .seed_heads = rng.UniformInt(0, 14),
                    .short_outside = true,
                    .seed = rng.Seed()});
}

Asset SampleTussock(Rng& rng) {
  return MakeGrass({.blades = rng.UniformInt(340, 480),
                    .height_m = Draw(rng, 0.4, 0.75),
                    .radius_m = Draw(rng, 0.08, 0.15),
                    .width_m = Draw(rng, 0.004, 0.0065),
                    .droop = Draw(rng, 1.3, 2.1),
                    .lean = Draw(rng, 0.0, 0.2),
                    .dry = Draw(rng, 0.3, 0.75),
                    .seed_heads = rng.UniformInt(0, 6),
                    .seed = rng.Seed()});
}

Asset SampleReed(Rng& rng) {
  return MakeReed({.stems = rng.UniformInt(9, 20),
                   .height_m = Draw(rng, 1.1, 2.2),
                   .cattail = rng.Bernoulli(0.4),
                   .seed = rng.Seed()});
}

}  // namespace parallax
