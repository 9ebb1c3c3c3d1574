#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> RiverGround(const std::string&) {
  return {"ForestFloor", "Soil", "Soil", "Gravel", "Rock"};
}

// Bars of gravel, banks of bare soil, mud in the bed's quiet parts.
void AddRiverGround(LayerWriter& w, Rng& rng) {
  w.AddGround({});
  w.AddGround({.patches_m = 6, .cover = 0.3, .soft = 0.2});
  w.AddGround({.slope = {0.3, 1.4, 0.15}, .above_water_m = {-1, 1.3, 0.4}});
  w.AddGround({.above_water_m = {-99, rng.Uniform(0.2, 0.5), 0.3},
               .patches_m = 17,
               .cover = rng.Uniform(0.7, 0.95),
               .soft = 0.12});
  w.AddGround({.slope = kSteep, .above_water_m = {1.5, 1e4, 0.5}});
}

void AddRiverStones(LayerWriter& w, Rng& rng) {
  w.Add(
      {.name = "boulders",
       .asset = "Boulder",
       .role = v1::OBJECT_ROLE_ROCK,
       .shapes = 6,
       .each = true,
       .per_m2 = rng.Uniform(0.01, 0.06),
       .spacing_m = 1.1,
       .reach_m = 320,
       .low = 0.42,
       .high = 2.1,
       .broken = true,
       .upright = 0.45,
       .sink_m = 0.16,
       .claim_m = 0.7,
       .mask = {.above_water_m = {-0.75, 0.6, 0.3}, .patches_m = 26, .cover = 0.45, .soft = 0.12}});
  w.Add({.name = "stones",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = rng.Uniform(4, 9),
         .reach_m = 90,
         .low = 0.05,
         .high = 0.42,
         .broken = true,
         .upright = 0.25,
         .sink_m = 0.12,
         .mask = {.above_water_m = {-0.25, 0.45, 0.2}, .patches_m = 9, .cover = 0.6, .soft = 0.2}});
  w.Add(
      {.name = "pebbles",
       .asset = "Pebbles",
       .role = v1::OBJECT_ROLE_ROCK,
       .shapes = 6,
       .per_m2 = 5,
       .reach_m = 30,
       .low = 0.8,
       .high = 2.6,
       .upright = 0.1,
       .sink_m = 0.008,
       .mask = {.above_water_m = {-0.08, 0.5, 0.15}, .patches_m = 5, .cover = 0.6, .soft = 0.15}});
}

void AddBankTrees(LayerWriter& w, Rng& rng) {
  const std::array<TreeKind, 5> kinds = {{
      {"birches", "BroadleafTree/birch", 2.2, 0.03, 2.6, 900, 0.7, 1.4},
      {"oaks", "BroadleafTree/oak", 3.5, 0.016, 4.2, 900, 0.8, 1.5},
      {"maples", "BroadleafTree/maple", 3.0, 0.02, 3.6, 900, 0.8, 1.5},
      {"pines", "Conifer/pine", 2.2, 0.025, 2.6, 1100, 0.8, 1.5},
      {"larches", "Conifer/larch", 2.1, 0.025, 2.6, 1100, 0.8, 1.5},
  }};
  const TreeKind willow{"willows", "BroadleafTree/willow", 3.2, 0.022, 4.0, 600, 0.6, 1.15};
  const TreeKind& kind = kinds[static_cast<size_t>(rng.UniformInt(0, 4))];
  AddTrees(w, willow,
           {.slope = kWalkable,
            .above_water_m = {0.5, 2.2, 0.4},
            .patches_m = 34,
            .cover = rng.Uniform(0.15, 0.5),
            .soft = 0.1});
  AddTrees(w, kind,
           {.slope = {0, 0.8, 0.2},
            .above_water_m = {0.9, 1e4, 0.3},
            .patches_m = rng.Uniform(50, 110),
            .cover = rng.Uniform(0.2, 0.7),
            .soft = 0.08});
  AddSaplings(w, kind,
              {.slope = kWalkable,
               .above_water_m = {0.7, 1e4, 0.3},
               .patches_m = 28,
               .cover = 0.3,
               .soft = 0.1});
}

void AddBankBushes(LayerWriter& w, Rng& rng) {
  w.Add({.name = "bushes",
         .asset = w.bare() ? "DryBush" : "Shrub",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.07,
         .spacing_m = 1.2,
         .reach_m = 260,
         .low = 0.5,
         .high = 1.5,
         .sink_m = 0.04,
         .claim_m = 0.35,
         .crown_m = 0.7,
         .mask = {.slope = {0, 0.8, 0.2},
                  .above_water_m = {0.5, 1e4, 0.2},
                  .patches_m = 20,
                  .cover = rng.Uniform(0.2, 0.5),
                  .soft = 0.08}});
  w.Add({.name = "driftwood",
         .asset = "Driftwood",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.012,
         .spacing_m = 1.5,
         .reach_m = 120,
         .low = 0.7,
         .high = 1.6,
         .upright = 0.1,
         .sink_m = 0.04,
         .claim_m = 0.4,
         .mask = {.slope = {0, 0.4, 0.2},
                  .above_water_m = {0.05, 0.7, 0.2},
                  .patches_m = 14,
                  .cover = 0.35,
                  .soft = 0.1}});
}

// Plants at the edge of the water and in it.
void AddReeds(LayerWriter& w, Rng& rng) {
  w.Add({.name = "reeds",
         .asset = "Reed",
         .shapes = 6,
         .per_m2 = 5,
         .spacing_m = 0.3,
         .reach_m = 150,
         .low = 0.55,
         .high = 1.15,
         .sink_m = 0.02,
         .mask = {.slope = {0, 0.6, 0.2},
                  .above_water_m = {-0.28, 0.16, 0.12},
                  .patches_m = 21,
                  .cover = rng.Uniform(0.08, 0.28),
                  .soft = 0.06}});
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 4,
         .per_m2 = 2.2,
         .spacing_m = 0.45,
         .reach_m = 95,
         .low = 0.6,
         .high = 1.2,
         .upright = 0.6,
         .sink_m = 0.02,
         .mask = {.slope = {0, 0.9, 0.2},
                  .above_water_m = {0.22, 2.5, 0.1},
                  .patches_m = 11,
                  .cover = 0.5,
                  .soft = 0.12}});
}

constexpr MaskSpec::Range kAboveBank = {0.5, 1e4, 0.2};  // Height above the water.

void AddRiverMeadow(LayerWriter& w) {
  w.Add({.name = "meadow",
         .asset = "GrassClump",
         .shapes = 6,
         .per_m2 = 3.4,
         .reach_m = 130,
         .low = 0.7,
         .high = 1.35,
         .upright = 0.35,
         .sink_m = 0.015,
         .mask = {.slope = {0, 0.85, 0.15},
                  .above_water_m = kAboveBank,
                  .shade = {0, 0.85, 0.1},
                  .patches_m = 7,
                  .cover = 0.8,
                  .soft = 0.2}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 8,
         .per_m2 = 30,
         .reach_m = 34,
         .low = 0.5,
         .high = 1.2,
         .upright = 0.5,
         .sink_m = 0.006,
         .mask = {.slope = {0, 0.85, 0.15},
                  .above_water_m = {0.35, 1e4, 0.2},
                  .patches_m = 2.4,
                  .cover = 0.78,
                  .soft = 0.25}});
}

void AddRiverFlowers(LayerWriter& w, Rng& rng) {
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  w.Add({.name = "flowers",
         .asset = "FlowerPlant",
         .shapes = 6,
         .per_m2 = rng.Uniform(0.5, 2),
         .reach_m = 40,
         .low = 0.7,
         .high = 1.4,
         .sink_m = 0.004,
         .mask = {.slope = kWalkable,
                  .above_water_m = kAboveBank,
                  .patches_m = 8,
                  .cover = 0.25,
                  .soft = 0.1}});
}

void AddRiverLitter(LayerWriter& w) {
  w.Add({.name = "leaves",
         .asset = "LeafLitter",
         .shapes = 5,
         .per_m2 = 4,
         .reach_m = 36,
         .upright = 0.05,
         .sink_m = -0.002,
         .near_parents_m = 5,
         .mask = {.slope = kWalkable}});
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 4,
         .per_m2 = 1,
         .reach_m = 24,
         .upright = 0.05,
         .sink_m = 0,
         .mask = {.slope = kWalkable,
                  .above_water_m = {0.15, 0.9, 0.1},
                  .patches_m = 4,
                  .cover = 0.4,
                  .soft = 0.1}});
}

void WriteRiver(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("river");
  AddRiverGround(w, rng);
  AddRiverStones(w, rng);
  AddBankTrees(w, rng);
  AddBankBushes(w, rng);
  AddReeds(w, rng);
  AddRiverMeadow(w);
  AddRiverFlowers(w, rng);
  AddRiverLitter(w);
}

}  // namespace

const Biome kRiver = {
    .name = "river",
    .landform = "river",
    .weight = [](const v1::BiomeWeights& weights) { return weights.river(); },
    .ground = &RiverGround,
    .write = &WriteRiver,
    .trace_times = 1.7,
    .wind = 0.5,
    .clarity = 0.7,
    .clear_water = {0.012f, 0.03f, 0.024f},
    .murky_water = {0.085f, 0.078f, 0.045f},
};

}  // namespace parallax
