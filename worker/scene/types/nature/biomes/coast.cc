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
  AddBlocks(w,
            {"stacks", "SeaStack", 3, beach.sandy ? 0.0003 : 0.001, 2.2, 1200, 1.6, 6.5, 1, 0.35, 1,
             false},
            {.above_water_m = {-4, -0.5, 0.8}, .patches_m = 110, .cover = 0.35, .soft = 0.1});
}

void AddShoreRocks(LayerWriter& w, const Beach& beach) {
  AddBlocks(w,
            {"boulders", "Boulder", 6, beach.sandy ? 0.012 : 0.06, 1, 420, 0.45, 3, 0.4, 0.18, 0.7},
            {.above_water_m = {-1.2, 0.9 * beach.foot_m, 0.5},
             .patches_m = 38,
             .cover = beach.sandy ? 0.2 : 0.6,
             .soft = 0.1});
  AddCover(w, {"stones", "Boulder", 6, beach.sandy ? 5.0 : 12.0, 85, 0.04, 0.42, 0.2, 0.12},
           {.above_water_m = {-0.15, 0.9 * beach.foot_m, 0.3},
            .patches_m = 15,
            .cover = beach.sandy ? 0.22 : 0.8,
            .soft = 0.15},
           Matter::kBrokenRock);
  AddCover(w, {"pebbles", "Pebbles", 6, 5, 28, 0.7, 2.2, 0.1, 0.008},
           {.above_water_m = {0.02, 0.9 * beach.foot_m, 0.2},
            .patches_m = 6,
            .cover = beach.sandy ? 0.3 : 0.7,
            .soft = 0.15},
           Matter::kStones);
}

// Wood and weed in lines, as high as tides and storms left them; `line_m` above the water.
void AddDriftLines(LayerWriter& w, Rng& rng, double line_m) {
  AddPlant(w,
           {"driftwood", "Driftwood", 5, rng.Uniform(0.004, 0.02), 1.2, 160, 0.6, 1.8, 0.04, 0.4, 0,
            0.1},
           {.slope = {0, 0.5, 0.2},
            .above_water_m = {line_m, line_m + 1.1, 0.25},
            .patches_m = 18,
            .cover = 0.45,
            .soft = 0.1});
  AddCover(w, {"wrack", "Wrack", 6, 1.3, 60, 0.6, 1.4, 0.05, 0.004, 0.35},
           {.above_water_m = {line_m - 0.05, line_m + 0.03, 0.05},
            .patches_m = 6,
            .cover = 0.6,
            .soft = 0.15});
}

// Small flotsam between the water and the lines.
void AddShells(LayerWriter& w, Rng& rng, double line_m) {
  AddCover(
      w, {"broken wood", "Twigs", 5, 1.2, 32, 0.6, 1.4, 0.05, 0.002},
      {.above_water_m = {line_m, line_m + 0.4, 0.15}, .patches_m = 5, .cover = 0.4, .soft = 0.1});
  AddCover(w, {"shells", "Shells", 6, rng.Uniform(0.3, 2), 20, 0.8, 1.5, 0.05, 0.004},
           {.above_water_m = {0.2, line_m + 0.3, 0.1}, .patches_m = 5, .cover = 0.5, .soft = 0.15});
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
  AddCover(w, {"dune grass", "Tussock", 5, 2.6, 130, 0.6, 1.3, 0.7, 0.03, 0.42},
           {.slope = {0, 0.9, 0.2},
            .above_water_m = above,
            .patches_m = 9,
            .cover = rng.Uniform(0.4, 0.65),
            .soft = 0.12});
  AddCover(w, {"meadow", "GrassClump", 5, 2.6, 130, 0.6, 1.2, 0.4, 0.015},
           {.slope = {0, 0.8, 0.2},
            .above_water_m = beach.Inland(),
            .patches_m = 10,
            .cover = beach.sandy ? 0.45 : 0.75,
            .soft = 0.12});
  AddCover(
      w, {"grass", "GrassTuft", 6, beach.sandy ? 9.0 : 20.0, 34, 0.5, 1.1, 0.5, 0.006},
      {.slope = {0, 0.8, 0.2}, .above_water_m = above, .patches_m = 4, .cover = 0.5, .soft = 0.15});
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
