#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> CliffGround(const std::string&) {
  return {"ForestFloor", "Soil", "Gravel", "Gravel", "GreyStrata"};
}

constexpr MaskSpec::Range kScree = {0.5, 1e4, 0.5};  // Deposit, metres.

void AddFormations(LayerWriter& w, Rng& rng) {
  const MaskSpec below = {.slope = {0, 0.85, 0.15}, .patches_m = 70, .cover = 0.45, .soft = 0.15};
  if (rng.Bernoulli(0.6)) {
    AddBlocks(w, {"stacks", "RockPillar", 2, 0.0002, 9, 600, 0.5, 2.4, 1, 0.9, 2.4, false}, below);
  }
  if (rng.Bernoulli(0.4)) {
    AddBlocks(w, {"arches", "RockArch", 2, 0.00006, 11, 600, 0.7, 1.8, 1, 0.9, 4, false}, below);
  }
}

constexpr MaskSpec::Range kFirmLedge = {0, 0.75, 0.15};  // Slope.

void AddCliffTrees(LayerWriter& w, Rng& rng) {
  const std::array<TreeKind, 3> kinds = {{
      {"pines", "Conifer/pine", 2.1, 0.02, 3, 900, 0.5, 1.2},
      {"birches", "BroadleafTree/birch", 2.2, 0.02, 3, 900, 0.6, 1.2},
      {"oaks", "BroadleafTree/oak", 3.6, 0.012, 5, 900, 0.6, 1.2},
  }};
  if (rng.Bernoulli(0.75)) {
    const TreeKind kind = kinds[static_cast<size_t>(rng.UniformInt(0, 2))];
    AddTrees(w, kind,
             {.slope = kWalkable, .patches_m = 80, .cover = rng.Uniform(0.05, 0.35), .soft = 0.08});
    AddSaplings(w, kind, {.slope = kFirmLedge, .patches_m = 45, .cover = 0.25, .soft = 0.1});
  }
}

void AddCliffBushes(LayerWriter& w, Rng& rng) {
  AddPlant(w,
           {"bushes", w.bare() ? "DryBush" : "Shrub", 4, 0.04, 1.3, 260, 0.3, 1.1, 0.04, 0.35, 0.6},
           {.slope = kFirmLedge, .patches_m = 24, .cover = rng.Uniform(0.15, 0.45), .soft = 0.08});
  AddCover(w, {"tussocks", "Tussock", 4, rng.Uniform(0.4, 1.4), 80, 0.4, 1.0, 0.5, 0.02, 0.45},
           {.slope = kFirmLedge, .patches_m = 12, .cover = 0.5, .soft = 0.12});
}

void AddCliffMeadow(LayerWriter& w, Rng& rng) {
  AddCover(w, {"meadow", "GrassClump", 5, 3, 110, 0.5, 1.0, 0.3, 0.015},
           {.slope = {0, 0.6, 0.15},
            .deposit_m = {-1, 0.9, 0.5},
            .patches_m = 8,
            .cover = 0.65,
            .soft = 0.15});
  AddCover(w, {"grass", "GrassTuft", 6, 20, 34, 0.4, 1.0, 0.4, 0.006},
           {.slope = kFirmLedge, .patches_m = 3, .cover = 0.65, .soft = 0.2});
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  AddCover(w, {"flowers", "FlowerPlant", 5, rng.Uniform(0.3, 1.4), 40, 0.5, 1.0, 1, 0.004},
           {.slope = kWalkable, .patches_m = 7, .cover = 0.3, .soft = 0.1});
}

void WriteCliff(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("cliff");
  w.AddGround({});
  w.AddGround({.patches_m = 6, .cover = 0.25, .soft = 0.15});
  w.AddGround({.patches_m = 13, .cover = 0.12, .soft = 0.12});
  w.AddGround({.slope = {0.3, 0.95, 0.15}, .deposit_m = kScree});
  w.AddGround({.slope = {0.82, 99, 0.14}});
  AddFormations(w, rng);
  AddRubble(w, rng.Uniform(0.7, 1.4), {.slope = kLoose, .deposit_m = {0.2, 1e4, 0.6}});
  AddStones(w, rng.Uniform(0.003, 0.012), 3,
            {.slope = kWalkable, .patches_m = 30, .cover = 0.4, .soft = 0.15});
  AddCliffTrees(w, rng);
  AddCliffBushes(w, rng);
  AddCliffMeadow(w, rng);
}

}  // namespace

const Biome kCliff = {
    .name = "cliff",
    .landform = "cliff",
    .weight = [](const v1::BiomeWeights& weights) { return weights.cliff(); },
    .ground = &CliffGround,
    .write = &WriteCliff,
    .trace_times = 1.2,
};

}  // namespace parallax
