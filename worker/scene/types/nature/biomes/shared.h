// Layers that several biomes have.
#pragma once

#include <string>
#include <vector>

#include "worker/scene/types/nature/rules/layer_writer.h"

namespace parallax {

// Slopes (rise over run) of ground for plants and people, and of bare rock.
inline constexpr MaskSpec::Range kWalkable = {0, 0.6, 0.2}, kSteep = {0.75, 99, 0.2};
// Slopes on which broken rock stays: up to its angle of repose, 36 degrees.
inline constexpr MaskSpec::Range kLoose = {0, 0.72, 0.12};

// Cover of the ground by things in numbers, without an index of their own: grass, herbs, litter,
// small stones. The fields are those of LayerSpec.
struct Cover {
  std::string name, asset;
  uint32_t shapes;
  double per_m2, reach_m, low, high, upright, sink_m;
  double spacing_m = 0, near_parents_m = 0, claim_m = 0;
};
// kBrokenRock: stones whose sizes are those of broken rock.
enum class Matter { kPlants, kStones, kBrokenRock };
void AddCover(LayerWriter& w, const Cover& cover, const MaskSpec& mask,
              Matter matter = Matter::kPlants);

// Plants that have an index each.
struct Plant {
  std::string name, asset;
  uint32_t shapes;
  double per_m2, spacing_m, reach_m, low, high, sink_m, claim_m;
  double crown_m = 0, upright = 1, snow_m = 0;
};
void AddPlant(LayerWriter& w, const Plant& plant, const MaskSpec& mask);

// Rocks and blocks of ice that have an index each.
struct Block {
  std::string name, asset;
  uint32_t shapes;
  double per_m2, spacing_m, reach_m, low, high, upright, sink_m, claim_m;
  bool broken = true;
  double snow_m = 0;
};
void AddBlocks(LayerWriter& w, const Block& block, const MaskSpec& mask);

// Adds boulders and pebbles; both numbers are per square metre. `mask`: where boulders lie.
void AddStones(LayerWriter& w, double boulders, double pebbles, const MaskSpec& mask);

// Adds broken rock below a wall or on stony ground, in five sizes from single blocks to stones;
// `times` is 1 for the scree below a wall. `snow_m` is the depth of the snow on it; where there is
// some, small stones lie only on bare ground.
void AddRubble(LayerWriter& w, double times, const MaskSpec& where, double snow_m = 0);

// A species of tree in three ages; old trees come first, because they claim the ground.
struct TreeKind {
  const char* name;
  std::string asset;
  double crown_m, per_m2, spacing_m, reach_m, low, high;
  double snow_m = 0;  // Depth of the snow on it.
};
// Adds grown trees, which claim the ground; AddSaplings adds smaller ones of the same species.
void AddTrees(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask);
void AddSaplings(LayerWriter& w, const TreeKind& kind, const MaskSpec& mask);

}  // namespace parallax
