#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {

void AddCover(LayerWriter& w, const Cover& cover, const MaskSpec& mask, Matter matter) {
  w.Add({.name = cover.name,
         .asset = cover.asset,
         .role = matter == Matter::kPlants ? v1::OBJECT_ROLE_VEGETATION : v1::OBJECT_ROLE_ROCK,
         .shapes = cover.shapes,
         .per_m2 = cover.per_m2,
         .spacing_m = cover.spacing_m,
         .reach_m = cover.reach_m,
         .low = cover.low,
         .high = cover.high,
         .broken = matter == Matter::kBrokenRock,
         .upright = cover.upright,
         .sink_m = cover.sink_m,
         .claim_m = cover.claim_m,
         .near_parents_m = cover.near_parents_m,
         .mask = mask});
}

void AddPlant(LayerWriter& w, const Plant& plant, const MaskSpec& mask) {
  w.Add({.name = plant.name,
         .asset = plant.asset,
         .shapes = plant.shapes,
         .each = true,
         .per_m2 = plant.per_m2,
         .spacing_m = plant.spacing_m,
         .reach_m = plant.reach_m,
         .low = plant.low,
         .high = plant.high,
         .upright = plant.upright,
         .sink_m = plant.sink_m,
         .claim_m = plant.claim_m,
         .crown_m = plant.crown_m,
         .snow_m = plant.snow_m,
         .mask = mask});
}

void AddBlocks(LayerWriter& w, const Block& block, const MaskSpec& mask) {
  w.Add({.name = block.name,
         .asset = block.asset,
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = block.shapes,
         .each = true,
         .per_m2 = block.per_m2,
         .spacing_m = block.spacing_m,
         .reach_m = block.reach_m,
         .low = block.low,
         .high = block.high,
         .broken = block.broken,
         .upright = block.upright,
         .sink_m = block.sink_m,
         .claim_m = block.claim_m,
         .snow_m = block.snow_m,
         .mask = mask});
}

void AddStones(LayerWriter& w, double boulders, double pebbles, const MaskSpec& mask) {
  AddBlocks(w, {"boulders", "Boulder", 6, boulders, 0.9, 320, 0.45, 2.6, 0.45, 0.16, 0.7}, mask);
  AddCover(w, {"pebbles", "Pebbles", 6, pebbles, 26, 0.8, 2.4, 0.1, 0.008},
           {.patches_m = 9, .cover = 0.4, .soft = 0.12}, Matter::kStones);
}

namespace {

MaskSpec RubblePatches(MaskSpec where, double patches_m, double cover, double soft = 0.15) {
  where.patches_m = patches_m;
  where.cover = cover;
  where.soft = soft;
  return where;
}

// Rocks and slabs that a person walks round.
void AddLargeRubble(LayerWriter& w, double times, const MaskSpec& where, double snow_m) {
  AddBlocks(w,
            {"blocks", "Boulder", 6, 0.0014 * times, 3.2, 500, 2.1, 5.5, 0.5, 0.14, 0.8, true,
             0.4 * snow_m},
            RubblePatches(where, 60, 0.35));
  AddBlocks(w, {"slabs", "Slab", 4, 0.01 * times, 1.2, 170, 0.6, 2.6, 0.1, 0.08, 0.6, true, snow_m},
            RubblePatches(where, 24, 0.4));
  AddBlocks(
      w,
      {"rock piles", "RockPile", 3, 0.004 * times, 2, 150, 0.6, 1.7, 0.2, 0.12, 0.7, false, snow_m},
      RubblePatches(where, 28, 0.35));
}

void AddSmallRubble(LayerWriter& w, double times, const MaskSpec& where, double snow_m) {
  MaskSpec of_rubble = RubblePatches(where, 19, 0.45, 0.3);
  MaskSpec of_stones = RubblePatches(where, 8, 0.5, 0.4);
  if (snow_m > 0) {
    // Deep snow buries what is small; stones lie where wind or sun laid the ground bare.
    of_rubble.snow_m = {-1, 0.3, 0.4};
    of_stones.snow_m = {-1, 0.05, 0.06};
  }
  w.Add({.name = "rubble",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 0.34 * times,
         .spacing_m = 0.6,
         .reach_m = 200,
         .low = 0.22,
         .high = 1.1,
         .broken = true,
         .upright = 0.3,
         .sink_m = 0.12,
         .claim_m = 0.3,
         .snow_m = snow_m,
         .mask = of_rubble});
  AddCover(w, {"stones", "Boulder", 6, 12 * times, 70, 0.05, 0.4, 0.2, 0.12}, of_stones,
           Matter::kBrokenRock);
}

}  // namespace

void AddRubble(LayerWriter& w, double times, const MaskSpec& where, double snow_m) {
  AddLargeRubble(w, times, where, snow_m);
  AddSmallRubble(w, times, where, snow_m);
}

void AddTrees(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask) {
  w.Add({.name = kind.name,
         .asset = kind.asset,
         .shapes = 3,
         .each = true,
         .per_m2 = kind.per_m2,
         .spacing_m = kind.spacing_m,
         .reach_m = kind.reach_m,
         .low = kind.low,
         .high = kind.high,
         .sink_m = 0.24,
         .claim_m = 0.55,
         .crown_m = kind.crown_m,
         .litter = true,
         .snow_m = kind.snow_m,
         .mask = mask});
}

void AddSaplings(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask) {
  w.Add({.name = std::string("young ") + kind.name,
         .asset = kind.asset,
         .shapes = 3,
         .each = true,
         .per_m2 = 0.9 * kind.per_m2,
         .spacing_m = 1.4 * kind.spacing_m,
         .reach_m = 120,
         .low = 0.14,
         .high = 0.42,
         .sink_m = 0.14,
         .claim_m = 0.4,
         .crown_m = 0.8 * kind.crown_m,
         .snow_m = kind.snow_m,
         .mask = mask});
}

}  // namespace parallax
