// Plants in pots, bushes, cactuses, and what one brings home from a walk.
#pragma once

#include "worker/assets/families.h"
#include "worker/assets/parts.h"

namespace parallax {

struct LeafParams {
  float length_m = 0.15f;
  float width_m = 0.05f;
  float droop = 0.5f;   // How far the tip bends down, in lengths.
  float fold = 0.25f;   // Of the halves about the midrib; 0 = flat.
  float wave = 0.0f;    // Undulation of the margin.
  float widest = 0.4f;  // Where along the length.
  float point = 1.0f;   // 1 = tapering tip, 0.5 = blunt.
  float thickness_m = 0.0006f;
  int lobes = 0;    // Cuts from the margin (monstera).
  int pieces = 10;  // Along the length.
};
// Starts at the origin and grows along +y, top side up (+z). A thin closed sheet.
kernel::Shape Leaf(const LeafParams& params);

enum class PlantKind { kBlades, kRosette, kBroad, kFern, kSnake, kCactus, kPalm, kTree, kCount };

struct PotPlantParams {
  PlantKind kind = PlantKind::kBroad;
  float pot_radius_m = 0.07f;
  float pot_height_m = 0.12f;
  float plant_m = 0.25f;  // Height above the soil, roughly.
  bool saucer = true;
  uint64_t seed = 0;
};
Asset MakePotPlant(const PotPlantParams& params);
Asset SamplePlantContainer(Rng& rng);
Asset SampleLargePlantContainer(Rng& rng);

Asset SampleBush(Rng& rng);
Asset SampleCactus(Rng& rng);
Asset SampleUrchin(Rng& rng);
// Shells, cones, pebbles, corals.
Asset SampleNatureShelfTrinkets(Rng& rng);
// A bowl of fruit.
Asset SampleFruitContainer(Rng& rng);

}  // namespace parallax
