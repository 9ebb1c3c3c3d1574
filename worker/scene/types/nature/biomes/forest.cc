#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> ForestGround(const std::string&) {
  return {"ForestFloor", "Moss", "Grass", "Soil", "Rock"};
}

struct ForestKind {
  TreeKind first, second;
  bool needles;
};

// No spruces: their sprays are flat pieces, which show where a walk leads below them.
ForestKind DrawForest(Rng& rng) {
  const TreeKind oak{"oaks", "BroadleafTree/oak", 3.4, 0.022, 3.0, 420, 0.9, 1.7};
  const TreeKind maple{"maples", "BroadleafTree/maple", 3.0, 0.03, 2.6, 420, 0.9, 1.7};
  const TreeKind birch{"birches", "BroadleafTree/birch", 2.1, 0.05, 1.9, 420, 0.9, 1.6};
  const TreeKind pine{"pines", "Conifer/pine", 2.3, 0.035, 2.4, 420, 0.9, 1.7};
  const TreeKind larch{"larches", "Conifer/larch", 2.2, 0.04, 2.2, 420, 0.8, 1.6};
  switch (rng.UniformInt(0, 5)) {
    case 0:
      return {oak, birch, false};
    case 1:
      return {maple, oak, false};
    case 2:
      return {birch, pine, false};
    case 3:
      return {pine, larch, true};
    case 4:
      return {pine, birch, true};
    default:
      return {larch, birch, true};
  }
}

// In the order of ForestGround: litter, moss, grass, soil, rock.
void AddForestGround(LayerWriter& w, Rng& rng) {
  w.AddGround({});
  w.AddGround({.patches_m = 4.5, .cover = rng.Uniform(0.15, 0.45), .soft = 0.1});
  w.AddGround({.patches_m = 19, .cover = w.bare() ? 0.04 : rng.Uniform(0.05, 0.3), .soft = 0.1});
  w.AddGround({.patches_m = 7, .cover = 0.14, .soft = 0.1});
  w.AddGround({.slope = kSteep});
}

// The first kind stands in groves, the second between them.
void AddForestTrees(LayerWriter& w, Rng& rng, const ForestKind& kind) {
  const MaskSpec stands = {.slope = kWalkable,
                           .patches_m = rng.Uniform(35, 70),
                           .cover = rng.Uniform(0.62, 0.9),
                           .soft = 0.12};
  TreeKind second = kind.second;
  second.per_m2 *= rng.Uniform(0.2, 0.6);
  AddTrees(w, kind.first, stands);
  AddTrees(w, second, {.slope = kWalkable, .patches_m = 45, .cover = 0.6, .soft = 0.15});
  w.Add({.name = "snags",
         .asset = "Snag",
         .shapes = 2,
         .each = true,
         .per_m2 = 0.0018,
         .spacing_m = 5,
         .reach_m = 160,
         .low = 0.8,
         .high = 1.6,
         .sink_m = 0.1,
         .claim_m = 0.4,
         .mask = {.slope = kWalkable}});
  AddSaplings(w, kind.first, {.slope = kWalkable, .patches_m = 21, .cover = 0.35, .soft = 0.1});
  AddSaplings(w, second, {.slope = kWalkable, .patches_m = 16, .cover = 0.35, .soft = 0.1});
}

void AddFallenWood(LayerWriter& w) {
  w.Add({.name = "fallen trunks",
         .asset = "FallenTrunk",
         .shapes = 3,
         .each = true,
         .per_m2 = 0.0028,
         .spacing_m = 3,
         .reach_m = 110,
         .low = 0.8,
         .high = 1.6,
         .upright = 0,
         .sink_m = 0.05,
         .claim_m = 0.6,
         .mask = {.slope = kWalkable}});
  w.Add({.name = "logs",
         .asset = "Log",
         .shapes = 2,
         .each = true,
         .per_m2 = 0.0015,
         .spacing_m = 2,
         .reach_m = 90,
         .low = 0.8,
         .high = 1.3,
         .upright = 0,
         .sink_m = 0.03,
         .claim_m = 0.5,
         .mask = {.slope = kWalkable}});
  w.Add({.name = "stumps",
         .asset = "Stump",
         .shapes = 3,
         .each = true,
         .per_m2 = 0.003,
         .spacing_m = 2,
         .reach_m = 90,
         .low = 0.8,
         .high = 1.5,
         .sink_m = 0.04,
         .claim_m = 0.4,
         .mask = {.slope = kWalkable}});
}

void AddUndergrowth(LayerWriter& w, Rng& rng) {
  w.Add({.name = "undergrowth",
         .asset = w.bare() ? "DryBush" : "Shrub",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.06,
         .spacing_m = 1.1,
         .reach_m = 110,
         .low = 0.4,
         .high = 1.2,
         .sink_m = 0.03,
         .claim_m = 0.3,
         .crown_m = 0.6,
         .mask = {
             .slope = kWalkable, .patches_m = 15, .cover = rng.Uniform(0.15, 0.45), .soft = 0.08}});
  AddStones(w, rng.Uniform(0.001, 0.012), 0.5, {.patches_m = 30, .cover = 0.4, .soft = 0.12});
  if (w.bare()) return;
  w.Add({.name = "ferns",
         .asset = "FernPlant",
         .shapes = 6,
         .per_m2 = 1.6,
         .spacing_m = 0.3,
         .reach_m = 70,
         .low = 0.5,
         .high = 1.25,
         .upright = 0.7,
         .sink_m = 0.01,
         .mask = {.slope = kWalkable,
                  .shade = {0.3, 1, 0.2},
                  .patches_m = 10,
                  .cover = rng.Uniform(0.12, 0.5),
                  .soft = 0.08}});
}

// Grass in the light between the crowns.
void AddForestGrass(LayerWriter& w) {
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = 18,
         .reach_m = 40,
         .low = 0.5,
         .high = 1.1,
         .upright = 0.5,
         .sink_m = 0.006,
         .mask = {.slope = kWalkable,
                  .shade = {0, 0.6, 0.3},
                  .patches_m = 4,
                  .cover = 0.45,
                  .soft = 0.12}});
  w.Add({.name = "meadow",
         .asset = "GrassClump",
         .shapes = 4,
         .per_m2 = 2.4,
         .reach_m = 100,
         .low = 0.6,
         .high = 1.2,
         .upright = 0.4,
         .sink_m = 0.015,
         .mask = {.slope = kWalkable,
                  .shade = {0, 0.5, 0.3},
                  .patches_m = 11,
                  .cover = 0.4,
                  .soft = 0.1}});
}

void AddFallenLeaves(LayerWriter& w, bool needles) {
  w.Add({.name = "leaves",
         .asset = "LeafLitter",
         .shapes = 6,
         .per_m2 = needles ? 4.0 : 13.0,
         .reach_m = 55,
         .low = 0.8,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = -0.002,
         .near_parents_m = 7,
         .mask = {.slope = kWalkable, .patches_m = 3, .cover = 0.85, .soft = 0.25}});
  if (!needles) return;
  w.Add({.name = "needles",
         .asset = "NeedlePatch",
         .shapes = 5,
         .per_m2 = 11,
         .reach_m = 42,
         .low = 0.8,
         .high = 1.5,
         .upright = 0.05,
         .sink_m = -0.001,
         .near_parents_m = 6,
         .mask = {.slope = kWalkable}});
  w.Add({.name = "cones",
         .asset = "Cones",
         .shapes = 4,
         .per_m2 = 0.4,
         .reach_m = 22,
         .upright = 0.05,
         .sink_m = 0.002,
         .near_parents_m = 5,
         .mask = {.slope = kWalkable}});
}

void AddForestFloor(LayerWriter& w) {
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 6,
         .per_m2 = 5,
         .reach_m = 45,
         .low = 0.7,
         .high = 1.6,
         .upright = 0.05,
         .sink_m = 0,
         .near_parents_m = 8,
         .mask = {.slope = kWalkable, .patches_m = 3.5, .cover = 0.6, .soft = 0.2}});
  if (w.draft().season != "autumn" && w.draft().season != "summer") return;
  w.Add({.name = "mushrooms",
         .asset = "Mushrooms",
         .shapes = 5,
         .per_m2 = 0.3,
         .reach_m = 16,
         .low = 0.7,
         .high = 1.5,
         .sink_m = 0.004,
         .mask = {.slope = kWalkable,
                  .shade = {0.3, 1, 0.2},
                  .patches_m = 5,
                  .cover = 0.2,
                  .soft = 0.05}});
}

void WriteForest(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("forest");
  AddForestGround(w, rng);
  const ForestKind kind = DrawForest(rng);
  AddForestTrees(w, rng, kind);
  AddFallenWood(w);
  AddUndergrowth(w, rng);
  AddForestGrass(w);
  AddFallenLeaves(w, kind.needles);
  AddForestFloor(w);
}

}  // namespace

const Biome kForest = {
    .name = "forest",
    .landform = "hills",
    .weight = [](const v1::BiomeWeights& weights) { return weights.forest(); },
    .ground = &ForestGround,
    .write = &WriteForest,
    .trace_times = 1.3,
};

}  // namespace parallax
