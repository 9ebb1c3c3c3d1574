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
         .low = 0.3,
         .high = 2.1,
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
         .mask = mask});
}

}  // namespace parallax
