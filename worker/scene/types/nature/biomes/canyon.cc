#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> CanyonGround(const std::string&) {
  return {"DesertSand", "Gravel", "Soil", "Gravel", "RedStrata"};
}

void AddFormation(LayerWriter& w, const char* name, const char* asset, double per_m2) {
  AddBlocks(w, {name, asset, 2, per_m2, 9, 700, 0.5, 2.2, 1, 0.9, 3, false},
            {.slope = {0, 0.9, 0.2}, .patches_m = 90, .cover = 0.35, .soft = 0.15});
}

constexpr MaskSpec::Range kFirmFloor = {0, 0.55, 0.2};  // Slope.

void AddCanyonTrees(LayerWriter& w, Rng& rng) {
  if (!rng.Bernoulli(0.6)) return;
  const TreeKind kind =
      rng.Bernoulli(0.5)
          ? TreeKind{"pines", "Conifer/pine", 2.1, 0.008, 4, 600, 0.35, 0.8}
          : TreeKind{"acacias", "BroadleafTree/acacia", 3.6, 0.006, 5, 600, 0.4, 0.9};
  AddTrees(w, kind,
           {.slope = kFirmFloor, .patches_m = 60, .cover = rng.Uniform(0.2, 0.5), .soft = 0.1});
}

void AddCanyonBushes(LayerWriter& w, Rng& rng) {
  AddPlant(w, {"bushes", "Shrub", 5, 0.03, 1.6, 300, 0.3, 1.0, 0.03, 0.4, 0.6},
           {.slope = kFirmFloor, .patches_m = 28, .cover = rng.Uniform(0.3, 0.6), .soft = 0.12});
  AddPlant(w, {"dry bushes", "DryBush", 4, 0.025, 1.4, 240, 0.25, 0.8, 0.03, 0.4},
           {.slope = kFirmFloor, .patches_m = 22, .cover = 0.45, .soft = 0.12});
}

void AddSucculents(LayerWriter& w, Rng& rng) {
  if (rng.Bernoulli(0.6)) {
    AddPlant(w, {"prickly pears", "PricklyPear", 4, 0.012, 1.6, 160, 0.7, 1.6, 0.03, 0.6},
             {.slope = kFirmFloor, .patches_m = 19, .cover = 0.35, .soft = 0.12});
  }
  if (rng.Bernoulli(0.5)) {
    AddPlant(w, {"agaves", "Agave", 4, 0.012, 1.5, 160, 0.6, 1.2, 0.03, 0.6},
             {.slope = kFirmFloor, .patches_m = 24, .cover = 0.35, .soft = 0.12});
  }
}

void AddCanyonGrass(LayerWriter& w) {
  AddCover(w, {"tussocks", "Tussock", 5, 0.3, 90, 0.35, 0.9, 0.6, 0.02, 0.7, 0, 0.25},
           {.slope = kFirmFloor, .patches_m = 14, .cover = 0.5, .soft = 0.12});
  AddCover(w, {"grass", "GrassTuft", 6, 3, 34, 0.4, 0.9, 0.5, 0.006},
           {.slope = kFirmFloor, .patches_m = 5, .cover = 0.35, .soft = 0.15});
}

void WriteCanyon(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("canyon");
  w.AddGround({});
  w.AddGround({.patches_m = 9, .cover = rng.Uniform(0.35, 0.65), .soft = 0.2});
  w.AddGround({.slope = {0, 0.5, 0.2}, .patches_m = 23, .cover = 0.25, .soft = 0.15});
  w.AddGround({.slope = {0.36, 0.9, 0.12}});
  w.AddGround({.slope = {0.5, 99, 0.12}});  // Sand and gravel slide off.
  if (rng.Bernoulli(0.35)) AddFormation(w, "arches", "RockArch", 0.00004);
  if (rng.Bernoulli(0.5)) AddFormation(w, "pillars", "RockPillar", 0.00012);
  AddRubble(w, rng.Uniform(0.5, 1.1), {.slope = kLoose});
  AddCanyonTrees(w, rng);
  AddCanyonBushes(w, rng);
  AddSucculents(w, rng);
  AddCanyonGrass(w);
  AddCover(w, {"pebbles", "Pebbles", 8, 5, 28, 0.8, 2.6, 0.1, 0.008},
           {.slope = {0, 0.7, 0.2}, .patches_m = 8, .cover = 0.5, .soft = 0.2}, Matter::kStones);
  AddCover(w, {"twigs", "Twigs", 4, 0.3, 24, 0.7, 1.3, 0.05, 0},
           {.slope = {0, 0.5, 0.2}, .patches_m = 8, .cover = 0.4, .soft = 0.15});
}

}  // namespace

const Biome kCanyon = {
    .name = "canyon",
    .landform = "canyon",
    .weight = [](const v1::BiomeWeights& weights) { return weights.canyon(); },
    .ground = &CanyonGround,
    .write = &WriteCanyon,
    .trace_times = 0.6,
};

}  // namespace parallax
