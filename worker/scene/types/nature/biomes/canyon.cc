#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> CanyonGround(const std::string&) {
  return {"DesertSand", "Gravel", "Soil", "Gravel", "RedStrata"};
}

void AddFormation(LayerWriter& w, const char* name, const char* asset, double per_m2) {
  w.Add({.name = name,
         .asset = asset,
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 2,
         .each = true,
         .per_m2 = per_m2,
         .spacing_m = 9,
         .reach_m = 700,
         .low = 0.5,
         .high = 2.2,
         .sink_m = 0.9,
         .claim_m = 3,
         .mask = {.slope = {0, 0.9, 0.2}, .patches_m = 90, .cover = 0.35, .soft = 0.15}});
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
  w.Add({.name = "bushes",
         .asset = "Shrub",
         .shapes = 5,
         .each = true,
         .per_m2 = 0.03,
         .spacing_m = 1.6,
         .reach_m = 300,
         .low = 0.3,
         .high = 1.0,
         .sink_m = 0.03,
         .claim_m = 0.4,
         .crown_m = 0.6,
         .mask = {
             .slope = kFirmFloor, .patches_m = 28, .cover = rng.Uniform(0.3, 0.6), .soft = 0.12}});
  w.Add({.name = "dry bushes",
         .asset = "DryBush",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.025,
         .spacing_m = 1.4,
         .reach_m = 240,
         .low = 0.25,
         .high = 0.8,
         .sink_m = 0.03,
         .claim_m = 0.4,
         .mask = {.slope = kFirmFloor, .patches_m = 22, .cover = 0.45, .soft = 0.12}});
}

void AddSucculents(LayerWriter& w, Rng& rng) {
  if (rng.Bernoulli(0.6)) {
    w.Add({.name = "prickly pears",
           .asset = "PricklyPear",
           .shapes = 4,
           .each = true,
           .per_m2 = 0.012,
           .spacing_m = 1.6,
           .reach_m = 160,
           .low = 0.7,
           .high = 1.6,
           .sink_m = 0.03,
           .claim_m = 0.6,
           .mask = {.slope = kFirmFloor, .patches_m = 19, .cover = 0.35, .soft = 0.12}});
  }
  if (rng.Bernoulli(0.5)) {
    w.Add({.name = "agaves",
           .asset = "Agave",
           .shapes = 4,
           .each = true,
           .per_m2 = 0.012,
           .spacing_m = 1.5,
           .reach_m = 160,
           .low = 0.6,
           .high = 1.2,
           .sink_m = 0.03,
           .claim_m = 0.6,
           .mask = {.slope = kFirmFloor, .patches_m = 24, .cover = 0.35, .soft = 0.12}});
  }
}

void AddCanyonGrass(LayerWriter& w) {
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 5,
         .per_m2 = 0.3,
         .spacing_m = 0.7,
         .reach_m = 90,
         .low = 0.35,
         .high = 0.9,
         .upright = 0.6,
         .sink_m = 0.02,
         .claim_m = 0.25,
         .mask = {.slope = kFirmFloor, .patches_m = 14, .cover = 0.5, .soft = 0.12}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = 3,
         .reach_m = 34,
         .low = 0.4,
         .high = 0.9,
         .upright = 0.5,
         .sink_m = 0.006,
         .mask = {.slope = kFirmFloor, .patches_m = 5, .cover = 0.35, .soft = 0.15}});
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
  w.Add({.name = "pebbles",
         .asset = "Pebbles",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 8,
         .per_m2 = 5,
         .reach_m = 28,
         .low = 0.8,
         .high = 2.6,
         .upright = 0.1,
         .sink_m = 0.008,
         .mask = {.slope = {0, 0.7, 0.2}, .patches_m = 8, .cover = 0.5, .soft = 0.2}});
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 4,
         .per_m2 = 0.3,
         .reach_m = 24,
         .upright = 0.05,
         .sink_m = 0,
         .mask = {.slope = {0, 0.5, 0.2}, .patches_m = 8, .cover = 0.4, .soft = 0.15}});
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
