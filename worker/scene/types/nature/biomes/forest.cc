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
  AddPlant(w, {"snags", "Snag", 2, 0.0018, 5, 160, 0.8, 1.6, 0.1, 0.4}, {.slope = kWalkable});
  AddSaplings(w, kind.first, {.slope = kWalkable, .patches_m = 21, .cover = 0.35, .soft = 0.1});
  AddSaplings(w, second, {.slope = kWalkable, .patches_m = 16, .cover = 0.35, .soft = 0.1});
}

void AddFallenWood(LayerWriter& w) {
  AddPlant(w, {"fallen trunks", "FallenTrunk", 3, 0.0028, 3, 110, 0.8, 1.6, 0.05, 0.6, 0, 0},
           {.slope = kWalkable});
  AddPlant(w, {"logs", "Log", 2, 0.0015, 2, 90, 0.8, 1.3, 0.03, 0.5, 0, 0}, {.slope = kWalkable});
  AddPlant(w, {"stumps", "Stump", 3, 0.003, 2, 90, 0.8, 1.5, 0.04, 0.4}, {.slope = kWalkable});
}

void AddUndergrowth(LayerWriter& w, Rng& rng) {
  AddPlant(
      w,
      {"undergrowth", w.bare() ? "DryBush" : "Shrub", 4, 0.06, 1.1, 110, 0.4, 1.2, 0.03, 0.3, 0.6},
      {.slope = kWalkable, .patches_m = 15, .cover = rng.Uniform(0.15, 0.45), .soft = 0.08});
  AddStones(w, rng.Uniform(0.001, 0.012), 0.5, {.patches_m = 30, .cover = 0.4, .soft = 0.12});
  if (w.bare()) return;
  AddCover(w, {"ferns", "FernPlant", 6, 1.6, 70, 0.5, 1.25, 0.7, 0.01, 0.3},
           {.slope = kWalkable,
            .shade = {0.3, 1, 0.2},
            .patches_m = 10,
            .cover = rng.Uniform(0.12, 0.5),
            .soft = 0.08});
}

// Grass in the light between the crowns.
void AddForestGrass(LayerWriter& w) {
  AddCover(
      w, {"grass", "GrassTuft", 6, 18, 40, 0.5, 1.1, 0.5, 0.006},
      {.slope = kWalkable, .shade = {0, 0.6, 0.3}, .patches_m = 4, .cover = 0.45, .soft = 0.12});
  AddCover(
      w, {"meadow", "GrassClump", 4, 2.4, 100, 0.6, 1.2, 0.4, 0.015},
      {.slope = kWalkable, .shade = {0, 0.5, 0.3}, .patches_m = 11, .cover = 0.4, .soft = 0.1});
}

void AddFallenLeaves(LayerWriter& w, bool needles) {
  AddCover(w, {"leaves", "LeafLitter", 6, needles ? 4.0 : 13.0, 55, 0.8, 1.4, 0.05, -0.002, 0, 7},
           {.slope = kWalkable, .patches_m = 3, .cover = 0.85, .soft = 0.25});
  if (!needles) return;
  AddCover(w, {"needles", "NeedlePatch", 5, 11, 42, 0.8, 1.5, 0.05, -0.001, 0, 6},
           {.slope = kWalkable});
  AddCover(w, {"cones", "Cones", 4, 0.4, 22, 0.7, 1.3, 0.05, 0.002, 0, 5}, {.slope = kWalkable});
}

void AddForestFloor(LayerWriter& w) {
  AddCover(w, {"twigs", "Twigs", 6, 5, 45, 0.7, 1.6, 0.05, 0, 0, 8},
           {.slope = kWalkable, .patches_m = 3.5, .cover = 0.6, .soft = 0.2});
  if (w.draft().season != "autumn" && w.draft().season != "summer") return;
  AddCover(
      w, {"mushrooms", "Mushrooms", 5, 0.3, 16, 0.7, 1.5, 1, 0.004},
      {.slope = kWalkable, .shade = {0.3, 1, 0.2}, .patches_m = 5, .cover = 0.2, .soft = 0.05});
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
