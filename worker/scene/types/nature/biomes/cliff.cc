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
    w.Add({.name = "stacks",
           .asset = "RockPillar",
           .role = v1::OBJECT_ROLE_ROCK,
           .shapes = 2,
           .each = true,
           .per_m2 = 0.0002,
           .spacing_m = 9,
           .reach_m = 600,
           .low = 0.5,
           .high = 2.4,
           .sink_m = 0.9,
           .claim_m = 2.4,
           .mask = below});
  }
  if (rng.Bernoulli(0.4)) {
    w.Add({.name = "arches",
           .asset = "RockArch",
           .role = v1::OBJECT_ROLE_ROCK,
           .shapes = 2,
           .each = true,
           .per_m2 = 0.00006,
           .spacing_m = 11,
           .reach_m = 600,
           .low = 0.7,
           .high = 1.8,
           .sink_m = 0.9,
           .claim_m = 4,
           .mask = below});
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
  w.Add(
      {.name = "bushes",
       .asset = w.bare() ? "DryBush" : "Shrub",
       .shapes = 4,
       .each = true,
       .per_m2 = 0.04,
       .spacing_m = 1.3,
       .reach_m = 260,
       .low = 0.3,
       .high = 1.1,
       .sink_m = 0.04,
       .claim_m = 0.35,
       .crown_m = 0.6,
       .mask = {
           .slope = kFirmLedge, .patches_m = 24, .cover = rng.Uniform(0.15, 0.45), .soft = 0.08}});
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 4,
         .per_m2 = rng.Uniform(0.4, 1.4),
         .spacing_m = 0.45,
         .reach_m = 80,
         .low = 0.4,
         .high = 1.0,
         .upright = 0.5,
         .sink_m = 0.02,
         .mask = {.slope = kFirmLedge, .patches_m = 12, .cover = 0.5, .soft = 0.12}});
}

void AddCliffMeadow(LayerWriter& w, Rng& rng) {
  w.Add({.name = "meadow",
         .asset = "GrassClump",
         .shapes = 5,
         .per_m2 = 3,
         .reach_m = 110,
         .low = 0.5,
         .high = 1.0,
         .upright = 0.3,
         .sink_m = 0.015,
         .mask = {.slope = {0, 0.6, 0.15},
                  .deposit_m = {-1, 0.9, 0.5},
                  .patches_m = 8,
                  .cover = 0.65,
                  .soft = 0.15}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = 20,
         .reach_m = 34,
         .low = 0.4,
         .high = 1.0,
         .upright = 0.4,
         .sink_m = 0.006,
         .mask = {.slope = kFirmLedge, .patches_m = 3, .cover = 0.65, .soft = 0.2}});
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  w.Add({.name = "flowers",
         .asset = "FlowerPlant",
         .shapes = 5,
         .per_m2 = rng.Uniform(0.3, 1.4),
         .reach_m = 40,
         .low = 0.5,
         .high = 1.0,
         .sink_m = 0.004,
         .mask = {.slope = kWalkable, .patches_m = 7, .cover = 0.3, .soft = 0.1}});
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
