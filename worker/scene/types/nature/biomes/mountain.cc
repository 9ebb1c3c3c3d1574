#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> MountainGround(const std::string&) {
  return {"Gravel", "ForestFloor", "Soil", "Gravel", "Rock"};
}

// Heights up to which trees and grass grow.
struct GrowthLimits {
  MaskSpec::Range trees, grass;
};

GrowthLimits DrawGrowthLimits(const SiteHeights& heights, Rng& rng) {
  const double span = static_cast<double>(heights.high_m - heights.low_m);
  const double tree_line =
      static_cast<double>(heights.At(static_cast<float>(rng.Uniform(0.3, 0.75))));
  return {{-9000, tree_line, 0.12 * span}, {-9000, tree_line + 0.3 * span, 0.2 * span}};
}

// In the order of MountainGround: gravel, grown over, bare soil, scree, rock.
void AddMountainGround(LayerWriter& w, const GrowthLimits& limits) {
  w.AddGround({});
  w.AddGround({.slope = {0, 0.5, 0.18},
               .height_m = limits.grass,
               .deposit_m = {-1, 0.5, 0.6},
               .patches_m = 13,
               .cover = 0.85,
               .soft = 0.25});
  w.AddGround({.slope = {0, 0.6, 0.2}, .patches_m = 6, .cover = 0.22, .soft = 0.12});
  w.AddGround({.slope = {0.2, 0.7, 0.15}, .deposit_m = {0.9, 1e4, 0.6}});
  w.AddGround({.slope = {0.62, 99, 0.16}});
}

// Stands of one kind of conifer.
void AddMountainTrees(LayerWriter& w, Rng& rng, const GrowthLimits& limits) {
  const std::array<TreeKind, 3> kinds = {{
      {"spruces", "Conifer/spruce", 2.0, 0.02, 2.4, 1500, 0.6, 1.35},
      {"larches", "Conifer/larch", 2.0, 0.016, 2.6, 1500, 0.6, 1.3},
      {"pines", "Conifer/pine", 2.1, 0.016, 2.6, 1500, 0.6, 1.3},
  }};
  const TreeKind kind = kinds[static_cast<size_t>(rng.UniformInt(0, 2))];
  const MaskSpec stands = {.slope = {0, 0.75, 0.15},
                           .height_m = limits.trees,
                           .patches_m = rng.Uniform(60, 140),
                           .cover = rng.Uniform(0.2, 0.6),
                           .soft = 0.08};
  AddTrees(w, kind, stands);
  AddSaplings(w, kind,
              {.slope = {0, 0.7, 0.15},
               .height_m = limits.trees,
               .patches_m = 35,
               .cover = 0.35,
               .soft = 0.1});
  AddPlant(w, {"snags", "Snag", 2, 0.0008, 5, 160, 0.7, 1.2, 0.1, 0.4},
           {.slope = kWalkable, .height_m = limits.trees});
}

// Single rocks as large as a person and larger, and slabs where the ground is steep.
void AddMountainBlocks(LayerWriter& w) {
  AddBlocks(w, {"blocks", "Boulder", 6, 0.0012, 3.2, 700, 2.5, 6.5, 0.3, 0.1, 0.8},
            {.patches_m = 60, .cover = 0.3, .soft = 0.1});
  AddBlocks(w, {"slabs", "Slab", 4, 0.01, 1.2, 200, 0.6, 2.8, 0, 0.08, 0.6},
            {.slope = {0.1, 1.3, 0.1}, .patches_m = 24, .cover = 0.4, .soft = 0.1});
}

// Broken rock from piles to stones.
void AddMountainScree(LayerWriter& w, Rng& rng) {
  AddBlocks(w, {"rock piles", "RockPile", 3, 0.004, 2, 160, 0.6, 1.6, 0.1, 0.1, 0.7, false},
            {.patches_m = 28, .cover = 0.3, .soft = 0.1});
  AddStones(w, rng.Uniform(0.02, 0.06), 5, {.patches_m = 22, .cover = 0.5, .soft = 0.15});
  w.Add({.name = "rubble",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 0.5,
         .spacing_m = 0.6,
         .reach_m = 360,
         .low = 0.22,
         .high = 1.1,
         .broken = true,
         .upright = 0.2,
         .sink_m = 0.1,
         .claim_m = 0.3,
         .mask = {.patches_m = 19, .cover = 0.45, .soft = 0.2}});
  AddCover(w, {"stones", "Boulder", 6, 22, 75, 0.05, 0.42, 0.2, 0.12},
           {.patches_m = 12, .cover = 0.75, .soft = 0.3}, Matter::kBrokenRock);
}

void AddMountainBushes(LayerWriter& w, Rng& rng, const GrowthLimits& limits) {
  AddPlant(w,
           {"bushes", w.bare() || rng.Bernoulli(0.3) ? "DryBush" : "Shrub", 4, 0.03, 1.2, 360, 0.3,
            0.9, 0.03, 0.3, 0.5},
           {.slope = {0, 0.7, 0.15},
            .height_m = limits.grass,
            .patches_m = 25,
            .cover = 0.3,
            .soft = 0.08});
  AddCover(w, {"tussocks", "Tussock", 4, rng.Uniform(0.6, 1.6), 150, 0.4, 1.0, 0.5, 0.02, 0.4},
           {.slope = {0, 0.75, 0.15},
            .height_m = limits.grass,
            .patches_m = 12,
            .cover = 0.45,
            .soft = 0.12});
}

void AddMountainMeadow(LayerWriter& w, Rng& rng, const GrowthLimits& limits) {
  AddCover(w, {"meadow", "GrassClump", 5, 3, 110, 0.5, 1.0, 0.3, 0.015},
           {.slope = {0, 0.55, 0.15},
            .height_m = limits.grass,
            .patches_m = 9,
            .cover = 0.6,
            .soft = 0.15});
  AddCover(w, {"grass", "GrassTuft", 6, 20, 34, 0.4, 0.9, 0.4, 0.006},
           {.slope = {0, 0.7, 0.15},
            .height_m = limits.grass,
            .patches_m = 3,
            .cover = 0.6,
            .soft = 0.2});
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  AddCover(w, {"flowers", "FlowerPlant", 5, rng.Uniform(0.3, 1.2), 40, 0.4, 0.8, 1, 0.004},
           {.slope = {0, 0.6, 0.15},
            .height_m = limits.grass,
            .patches_m = 7,
            .cover = 0.3,
            .soft = 0.1});
}

void AddMountainLitter(LayerWriter& w) {
  AddCover(w, {"needles", "NeedlePatch", 4, 4, 30, 0.8, 1.4, 0.05, -0.001, 0, 4},
           {.slope = kWalkable});
  AddCover(w, {"twigs", "Twigs", 4, 1.5, 28, 0.7, 1.4, 0.05, 0, 0, 5}, {.slope = kWalkable});
}

void WriteMountain(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("mountain");
  const GrowthLimits limits = DrawGrowthLimits(draft.heights, rng);
  AddMountainGround(w, limits);
  AddMountainTrees(w, rng, limits);
  AddMountainBlocks(w);
  AddMountainScree(w, rng);
  AddMountainBushes(w, rng, limits);
  AddMountainMeadow(w, rng, limits);
  AddMountainLitter(w);
}

}  // namespace

const Biome kMountain = {
    .name = "mountain",
    .landform = "mountains",
    .weight = [](const v1::BiomeWeights& weights) { return weights.mountain(); },
    .ground = &MountainGround,
    .write = &WriteMountain,
    .trace_times = 0.6,
};

}  // namespace parallax
