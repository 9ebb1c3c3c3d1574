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
  AddBlocks(
      w, {"boulders", "Boulder", 6, rng.Uniform(0.01, 0.06), 1.1, 320, 0.42, 2.1, 0.45, 0.16, 0.7},
      {.above_water_m = {-0.75, 0.6, 0.3}, .patches_m = 26, .cover = 0.45, .soft = 0.12});
  AddCover(w, {"stones", "Boulder", 6, rng.Uniform(4, 9), 90, 0.05, 0.42, 0.25, 0.12},
           {.above_water_m = {-0.25, 0.45, 0.2}, .patches_m = 9, .cover = 0.6, .soft = 0.2},
           Matter::kBrokenRock);
  AddCover(w, {"pebbles", "Pebbles", 6, 5, 30, 0.8, 2.6, 0.1, 0.008},
           {.above_water_m = {-0.08, 0.5, 0.15}, .patches_m = 5, .cover = 0.6, .soft = 0.15},
           Matter::kStones);
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
  AddPlant(w,
           {"bushes", w.bare() ? "DryBush" : "Shrub", 4, 0.07, 1.2, 260, 0.5, 1.5, 0.04, 0.35, 0.7},
           {.slope = {0, 0.8, 0.2},
            .above_water_m = {0.5, 1e4, 0.2},
            .patches_m = 20,
            .cover = rng.Uniform(0.2, 0.5),
            .soft = 0.08});
  AddPlant(w, {"driftwood", "Driftwood", 4, 0.012, 1.5, 120, 0.7, 1.6, 0.04, 0.4, 0, 0.1},
           {.slope = {0, 0.4, 0.2},
            .above_water_m = {0.05, 0.7, 0.2},
            .patches_m = 14,
            .cover = 0.35,
            .soft = 0.1});
}

// Plants at the edge of the water and in it.
void AddReeds(LayerWriter& w, Rng& rng) {
  AddCover(w, {"reeds", "Reed", 6, 5, 150, 0.55, 1.15, 1, 0.02, 0.3},
           {.slope = {0, 0.6, 0.2},
            .above_water_m = {-0.28, 0.16, 0.12},
            .patches_m = 21,
            .cover = rng.Uniform(0.08, 0.28),
            .soft = 0.06});
  AddCover(w, {"tussocks", "Tussock", 4, 2.2, 95, 0.6, 1.2, 0.6, 0.02, 0.45},
           {.slope = {0, 0.9, 0.2},
            .above_water_m = {0.22, 2.5, 0.1},
            .patches_m = 11,
            .cover = 0.5,
            .soft = 0.12});
}

constexpr MaskSpec::Range kAboveBank = {0.5, 1e4, 0.2};  // Height above the water.

void AddRiverMeadow(LayerWriter& w) {
  AddCover(w, {"meadow", "GrassClump", 6, 3.4, 130, 0.7, 1.35, 0.35, 0.015},
           {.slope = {0, 0.85, 0.15},
            .above_water_m = kAboveBank,
            .shade = {0, 0.85, 0.1},
            .patches_m = 7,
            .cover = 0.8,
            .soft = 0.2});
  AddCover(w, {"grass", "GrassTuft", 8, 30, 34, 0.5, 1.2, 0.5, 0.006},
           {.slope = {0, 0.85, 0.15},
            .above_water_m = {0.35, 1e4, 0.2},
            .patches_m = 2.4,
            .cover = 0.78,
            .soft = 0.25});
}

void AddRiverFlowers(LayerWriter& w, Rng& rng) {
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  AddCover(w, {"flowers", "FlowerPlant", 6, rng.Uniform(0.5, 2), 40, 0.7, 1.4, 1, 0.004},
           {.slope = kWalkable,
            .above_water_m = kAboveBank,
            .patches_m = 8,
            .cover = 0.25,
            .soft = 0.1});
}

void AddRiverLitter(LayerWriter& w) {
  AddCover(w, {"leaves", "LeafLitter", 5, 4, 36, 0.7, 1.3, 0.05, -0.002, 0, 5},
           {.slope = kWalkable});
  AddCover(w, {"twigs", "Twigs", 4, 1, 24, 0.7, 1.3, 0.05, 0},
           {.slope = kWalkable,
            .above_water_m = {0.15, 0.9, 0.1},
            .patches_m = 4,
            .cover = 0.4,
            .soft = 0.1});
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
