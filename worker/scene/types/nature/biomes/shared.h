// Layers that several biomes have.
#pragma once

#include <string>
#include <vector>

#include "worker/scene/types/nature/layer_writer.h"

namespace parallax {

// Slopes (rise over run) on which plants stand and people walk, and those where rock is bare.
inline constexpr MaskSpec::Range kWalkable = {0, 0.6, 0.2}, kSteep = {0.75, 99, 0.2};

// Boulders and pebbles, so many a square metre. `mask`: where boulders lie.
void AddStones(LayerWriter& w, double boulders, double pebbles, const MaskSpec& mask);

// Broken rock that lies about below a wall or on stony ground, of five sizes from blocks that stand
// alone down to stones; so many times as much as on a mountain's scree. `snow_m`: that lies on it.
void AddRubble(LayerWriter& w, double times, const MaskSpec& where, double snow_m = 0);

// A tree of its species in three ages, the old ones first: they claim the ground.
struct TreeKind {
  const char* name;
  std::string asset;
  double crown_m, per_m2, spacing_m, reach_m, low, high;
  double snow_m = 0;  // That lies on it.
};
// Grown trees, which claim the ground, and smaller ones of the same species.
void AddTrees(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask);
void AddSaplings(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask);

}  // namespace parallax
