#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

// Lower than this above the water a beach is not grown over, metres.
struct Beach {
  bool sandy = true;
  double foot_m = 1;  // Where dunes or a bank begin.
  // Heights above the water of the land behind them.
  MaskSpec::Range Inland() const { return {foot_m + 1, 1e4, 0.7}; }
};

Beach BeachOf(const v1::Water& water) {
  return {water.slope() < 0.12, water.slope() * water.width_m()};
}

std::vector<std::string> CoastGround(const std::string&) {
  return {"Sand", "ForestFloor", "Gravel", "Rock"};
}

void AddCoastGround(LayerWriter& w, const Beach& beach) {
  w.AddGround({});
  w.AddGround({.slope = {0, 0.7, 0.2},
               .above_water_m = {beach.foot_m + (beach.sandy ? 1.2 : 0.5), 1e4, 0.8},
               .patches_m = 13,
               .cover = beach.sandy ? 0.62 : 0.85,
               .soft = 0.15});
  w.AddGround({.above_water_m = {-3, 0.9 * beach.foot_m, 0.5},
               .patches_m = beach.sandy ? 24.0 : 40.0,
               .cover = beach.sandy ? 0.16 : 0.88,
               .soft = 0.1});
  w.AddGround({.slope = {beach.sandy ? 0.7 : 0.5, 99, 0.15}});
}

void AddSeaStacks(LayerWriter& w, const Beach& beach) {
  w.Add({.name = "stacks",
         .asset = "SeaStack",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 3,
         .each = true,
         .per_m2 = beach.sandy ? 0.0003 : 0.001,
         .spacing_m = 2.2,
         .reach_m = 1200,
         .low = 1.6,
         .high = 6.5,
         .sink_m = 0.35,
         .claim_m = 1,
         .mask = {.above_water_m = {-4, -0.5, 0.8}, .patches_m = 110, .cover = 0.35, .soft = 0.1}});
}

void AddShoreRocks(LayerWriter& w, const Beach& beach) {
  w.Add({.name = "boulders",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = beach.sandy ? 0.012 : 0.06,
         .spacing_m = 1,
         .reach_m = 420,
         .low = 0.45,
         .high = 3,
         .broken = true,
         .upright = 0.4,
         .sink_m = 0.18,
         .claim_m = 0.7,
         .mask = {.above_water_m = {-1.2, 0.9 * beach.foot_m, 0.5},
                  .patches_m = 38,
                  .cover = beach.sandy ? 0.2 : 0.6,
                  .soft = 0.1}});
  w.Add({.name = "stones",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = beach.sandy ? 5.0 : 12.0,
         .reach_m = 85,
         .low = 0.04,
         .high = 0.42,
         .broken = true,
         .upright = 0.2,
         .sink_m = 0.12,
         .mask = {.above_water_m = {-0.15, 0.9 * beach.foot_m, 0.3},
                  .patches_m = 15,
                  .cover = beach.sandy ? 0.22 : 0.8,
                  .soft = 0.15}});
  w.Add({.name = "pebbles",
         .asset = "Pebbles",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 5,
         .reach_m = 28,
         .low = 0.7,
         .high = 2.2,
         .upright = 0.1,
         .sink_m = 0.008,
         .mask = {.above_water_m = {0.02, 0.9 * beach.foot_m, 0.2},
                  .patches_m = 6,
                  .cover = beach.sandy ? 0.3 : 0.7,
                  .soft = 0.15}});
}

// Wood and weed in lines, as high as tides and storms left them; `line_m` above the water.
void AddDriftLines(LayerWriter& w, Rng& rng, double line_m) {
  w.Add({.name = "driftwood",
         .asset = "Driftwood",
         .shapes = 5,
         .each = true,
         .per_m2 = rng.Uniform(0.004, 0.02),
         .spacing_m = 1.2,
         .reach_m = 160,
         .low = 0.6,
         .high = 1.8,
         .upright = 0.1,
         .sink_m = 0.04,
         .claim_m = 0.4,
         .mask = {.slope = {0, 0.5, 0.2},
                  .above_water_m = {line_m, line_m + 1.1, 0.25},
                  .patches_m = 18,
                  .cover = 0.45,
                  .soft = 0.1}});
  w.Add({.name = "wrack",
         .asset = "Wrack",
         .shapes = 6,
         .per_m2 = 1.3,
         .spacing_m = 0.35,
         .reach_m = 60,
         .low = 0.6,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = 0.004,
         .mask = {.above_water_m = {line_m - 0.05, line_m + 0.03, 0.05},
                  .patches_m = 6,
                  .cover = 0.6,
                  .soft = 0.15}});
}

// Small flotsam between the water and the lines.
void AddShells(LayerWriter& w, Rng& rng, double line_m) {
  w.Add({.name = "broken wood",
         .asset = "Twigs",
         .shapes = 5,
         .per_m2 = 1.2,
         .reach_m = 32,
         .low = 0.6,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = 0.002,
         .mask = {.above_water_m = {line_m, line_m + 0.4, 0.15},
                  .patches_m = 5,
                  .cover = 0.4,
                  .soft = 0.1}});
  w.Add(
      {.name = "shells",
       .asset = "Shells",
       .shapes = 6,
       .per_m2 = rng.Uniform(0.3, 2),
       .reach_m = 20,
       .low = 0.8,
       .high = 1.5,
       .upright = 0.05,
       .sink_m = 0.004,
       .mask = {
           .above_water_m = {0.2, line_m + 0.3, 0.1}, .patches_m = 5, .cover = 0.5, .soft = 0.15}});
}

// Trees and bushes behind the beach.
void AddInlandBushes(LayerWriter& w, Rng& rng, const Beach& beach) {
  const std::array<TreeKind, 3> kinds = {{
      {"pines", "Conifer/pine", 2.2, 0.016, 2.8, 1200, 0.6, 1.2},
      {"birches", "BroadleafTree/birch", 2.1, 0.016, 2.8, 1200, 0.6, 1.1},
      {"acacias", "BroadleafTree/acacia", 3.4, 0.01, 4.5, 1200, 0.6, 1.1},
  }};
  AddTrees(w, kinds[static_cast<size_t>(rng.UniformInt(0, 2))],
           {.slope = kWalkable,
            .above_water_m = {beach.foot_m + 2, 1e4, 1},
            .patches_m = rng.Uniform(70, 130),
            .cover = rng.Uniform(0.05, 0.4),
            .soft = 0.07});
  w.Add({.name = "bushes",
         .asset = w.bare() || rng.Bernoulli(0.25) ? "DryBush" : "Shrub",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.06,
         .spacing_m = 1.2,
         .reach_m = 300,
         .low = 0.4,
         .high = 1.1,
         .sink_m = 0.05,
         .claim_m = 0.35,
         .crown_m = 0.7,
         .mask = {.slope = kWalkable,
                  .above_water_m = beach.Inland(),
                  .patches_m = 24,
                  .cover = rng.Uniform(0.15, 0.45),
                  .soft = 0.08}});
}

void AddDuneGrass(LayerWriter& w, Rng& rng, const Beach& beach) {
  const MaskSpec::Range above = {beach.foot_m + 0.35, 1e4, 0.4};
  w.Add({.name = "dune grass",
         .asset = "Tussock",
         .shapes = 5,
         .per_m2 = 2.6,
         .spacing_m = 0.42,
         .reach_m = 130,
         .low = 0.6,
         .high = 1.3,
         .upright = 0.7,
         .sink_m = 0.03,
         .mask = {.slope = {0, 0.9, 0.2},
                  .above_water_m = above,
                  .patches_m = 9,
                  .cover = rng.Uniform(0.4, 0.65),
                  .soft = 0.12}});
  w.Add({.name = "meadow",
         .asset = "GrassClump",
         .shapes = 5,
         .per_m2 = 2.6,
         .reach_m = 130,
         .low = 0.6,
         .high = 1.2,
         .upright = 0.4,
         .sink_m = 0.015,
         .mask = {.slope = {0, 0.8, 0.2},
                  .above_water_m = beach.Inland(),
                  .patches_m = 10,
                  .cover = beach.sandy ? 0.45 : 0.75,
                  .soft = 0.12}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = beach.sandy ? 9.0 : 20.0,
         .reach_m = 34,
         .low = 0.5,
         .high = 1.1,
         .upright = 0.5,
         .sink_m = 0.006,
         .mask = {.slope = {0, 0.8, 0.2},
                  .above_water_m = above,
                  .patches_m = 4,
                  .cover = 0.5,
                  .soft = 0.15}});
}

void WriteCoast(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("coast");
  const Beach beach = BeachOf(draft.recipe.water());
  AddCoastGround(w, beach);
  if (!beach.sandy || rng.Bernoulli(0.3)) AddSeaStacks(w, beach);
  AddShoreRocks(w, beach);
  const double line_m = rng.Uniform(0.4, 0.75);
  AddDriftLines(w, rng, line_m);
  AddShells(w, rng, line_m);
  AddInlandBushes(w, rng, beach);
  AddDuneGrass(w, rng, beach);
}

}  // namespace

const Biome kCoast = {
    .name = "coast",
    .landform = "coast",
    .weight = [](const v1::BiomeWeights& weights) { return weights.coast(); },
    .ground = &CoastGround,
    .write = &WriteCoast,
    .trace_times = 0.6,
    .clarity = 1.6,
};

}  // namespace parallax
