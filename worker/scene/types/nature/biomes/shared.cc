#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {

void AddStones(LayerWriter& w, double boulders, double pebbles, const MaskSpec& mask) {
  w.Add({.name = "boulders",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = boulders,
         .spacing_m = 0.9,
         .reach_m = 320,
         .low = 0.45,
         .high = 2.6,
         .broken = true,
         .upright = 0.45,
         .sink_m = 0.16,
         .claim_m = 0.7,
         .mask = mask});
  w.Add({.name = "pebbles",
         .asset = "Pebbles",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = pebbles,
         .reach_m = 26,
         .low = 0.8,
         .high = 2.4,
         .upright = 0.1,
         .sink_m = 0.008,
         .mask = {.patches_m = 9, .cover = 0.4, .soft = 0.12}});
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
  w.Add({.name = "blocks",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = 0.0014 * times,
         .spacing_m = 3.2,
         .reach_m = 500,
         .low = 2.1,
         .high = 5.5,
         .broken = true,
         .upright = 0.5,
         .sink_m = 0.14,
         .claim_m = 0.8,
         .snow_m = 0.4 * snow_m,
         .mask = RubblePatches(where, 60, 0.35)});
  w.Add({.name = "slabs",
         .asset = "Slab",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 4,
         .each = true,
         .per_m2 = 0.01 * times,
         .spacing_m = 1.2,
         .reach_m = 170,
         .low = 0.6,
         .high = 2.6,
         .broken = true,
         .upright = 0.1,
         .sink_m = 0.08,
         .claim_m = 0.6,
         .snow_m = snow_m,
         .mask = RubblePatches(where, 24, 0.4)});
  w.Add({.name = "rock piles",
         .asset = "RockPile",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 3,
         .each = true,
         .per_m2 = 0.004 * times,
         .spacing_m = 2,
         .reach_m = 150,
         .low = 0.6,
         .high = 1.7,
         .upright = 0.2,
         .sink_m = 0.12,
         .claim_m = 0.7,
         .snow_m = snow_m,
         .mask = RubblePatches(where, 28, 0.35)});
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
  w.Add({.name = "stones",
         .asset = "Boulder",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 12 * times,
         .reach_m = 70,
         .low = 0.05,
         .high = 0.4,
         .broken = true,
         .upright = 0.2,
         .sink_m = 0.12,
         .mask = of_stones});
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
