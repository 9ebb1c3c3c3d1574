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
  w.Add({.name = "snags",
         .asset = "Snag",
         .shapes = 2,
         .each = true,
         .per_m2 = 0.0008,
         .spacing_m = 5,
         .reach_m = 160,
         .low = 0.7,
         .high = 1.2,
         .sink_m = 0.1,
         .claim_m = 0.4,
         .mask = {.slope = kWalkable, .height_m = limits.trees}});
}

// Single rocks as large as a person and larger, and slabs where the ground is steep.
void AddMountainBlocks(LayerWriter& w) {
  w.Add({.name = "blocks",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = 0.0012,
         .spacing_m = 3.2,
         .reach_m = 700,
         .low = 2.5,
         .high = 6.5,
         .broken = true,
         .upright = 0.3,
         .sink_m = 0.1,
         .claim_m = 0.8,
         .mask = {.patches_m = 60, .cover = 0.3, .soft = 0.1}});
  w.Add({.name = "slabs",
         .asset = "Slab",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 4,
         .each = true,
         .per_m2 = 0.01,
         .spacing_m = 1.2,
         .reach_m = 200,
         .low = 0.6,
         .high = 2.8,
         .broken = true,
         .upright = 0,
         .sink_m = 0.08,
         .claim_m = 0.6,
         .mask = {.slope = {0.1, 1.3, 0.1}, .patches_m = 24, .cover = 0.4, .soft = 0.1}});
}

// Broken rock from piles to stones.
void AddMountainScree(LayerWriter& w, Rng& rng) {
  w.Add({.name = "rock piles",
         .asset = "RockPile",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 3,
         .each = true,
         .per_m2 = 0.004,
         .spacing_m = 2,
         .reach_m = 160,
         .low = 0.6,
         .high = 1.6,
         .upright = 0.1,
         .sink_m = 0.1,
         .claim_m = 0.7,
         .mask = {.patches_m = 28, .cover = 0.3, .soft = 0.1}});
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
  w.Add({.name = "stones",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 22,
         .reach_m = 75,
         .low = 0.05,
         .high = 0.42,
         .broken = true,
         .upright = 0.2,
         .sink_m = 0.12,
         .mask = {.patches_m = 12, .cover = 0.75, .soft = 0.3}});
}

void AddMountainBushes(LayerWriter& w, Rng& rng, const GrowthLimits& limits) {
  w.Add({.name = "bushes",
         .asset = w.bare() || rng.Bernoulli(0.3) ? "DryBush" : "Shrub",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.03,
         .spacing_m = 1.2,
         .reach_m = 360,
         .low = 0.3,
         .high = 0.9,
         .sink_m = 0.03,
         .claim_m = 0.3,
         .crown_m = 0.5,
         .mask = {.slope = {0, 0.7, 0.15},
                  .height_m = limits.grass,
                  .patches_m = 25,
                  .cover = 0.3,
                  .soft = 0.08}});
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 4,
         .per_m2 = rng.Uniform(0.6, 1.6),
         .spacing_m = 0.4,
         .reach_m = 150,
         .low = 0.4,
         .high = 1.0,
         .upright = 0.5,
         .sink_m = 0.02,
         .mask = {.slope = {0, 0.75, 0.15},
                  .height_m = limits.grass,
                  .patches_m = 12,
                  .cover = 0.45,
                  .soft = 0.12}});
}

void AddMountainMeadow(LayerWriter& w, Rng& rng, const GrowthLimits& limits) {
  w.Add({.name = "meadow",
         .asset = "GrassClump",
         .shapes = 5,
         .per_m2 = 3,
         .reach_m = 110,
         .low = 0.5,
         .high = 1.0,
         .upright = 0.3,
         .sink_m = 0.015,
         .mask = {.slope = {0, 0.55, 0.15},
                  .height_m = limits.grass,
                  .patches_m = 9,
                  .cover = 0.6,
                  .soft = 0.15}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = 20,
         .reach_m = 34,
         .low = 0.4,
         .high = 0.9,
         .upright = 0.4,
         .sink_m = 0.006,
         .mask = {.slope = {0, 0.7, 0.15},
                  .height_m = limits.grass,
                  .patches_m = 3,
                  .cover = 0.6,
                  .soft = 0.2}});
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  w.Add({.name = "flowers",
         .asset = "FlowerPlant",
         .shapes = 5,
         .per_m2 = rng.Uniform(0.3, 1.2),
         .reach_m = 40,
         .low = 0.4,
         .high = 0.8,
         .sink_m = 0.004,
         .mask = {.slope = {0, 0.6, 0.15},
                  .height_m = limits.grass,
                  .patches_m = 7,
                  .cover = 0.3,
                  .soft = 0.1}});
}

void AddMountainLitter(LayerWriter& w) {
  w.Add({.name = "needles",
         .asset = "NeedlePatch",
         .shapes = 4,
         .per_m2 = 4,
         .reach_m = 30,
         .low = 0.8,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = -0.001,
         .near_parents_m = 4,
         .mask = {.slope = kWalkable}});
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 4,
         .per_m2 = 1.5,
         .reach_m = 28,
         .low = 0.7,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = 0,
         .near_parents_m = 5,
         .mask = {.slope = kWalkable}});
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
