// Plants in pots, bushes, cactuses, and small finds from walks.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// The blade of a leaf, as a thin closed sheet.
struct LeafParams {
  float length_m = 0.15f;
  float width_m = 0.05f;
  float droop = 0.5f;   // How far the tip bends down, in lengths.
  float fold = 0.25f;   // Fold of the halves about the midrib; 0 = flat.
  float wave = 0.0f;    // Undulation of the margin.
  float widest = 0.4f;  // Where along the length.
  float point = 1.0f;   // 1 = tapering tip, 0.5 = blunt.
  float thickness_m = 0.0006f;
  int lobes = 0;    // Cuts from the margin (monstera).
  int pieces = 10;  // Along the length.
};
// Starts at the origin and grows along +y, top side up (+z). A thin closed sheet.
kernel::Shape Leaf(const LeafParams& params);

// The habit of a potted plant.
enum class PlantKind { kBlades, kRosette, kBroad, kFern, kSnake, kCactus, kPalm, kTree, kCount };

// A plant in a pot, with its soil.
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

// A bush without a pot.
struct BushParams {
  float size_m = 0.8f;       // Height, roughly.
  float leaf_width = 0.45f;  // In lengths.
  int stems = 12;
  uint64_t seed = 0;
};
Asset MakeBush(const BushParams& params);
Asset SampleBush(Rng& rng);

// A ribbed cactus with arms.
struct CactusParams {
  float height_m = 0.9f, radius_m = 0.08f;
  int ribs = 12, arms = 2;
  uint64_t seed = 0;
};
Asset MakeCactus(const CactusParams& params);
Asset SampleCactus(Rng& rng);

// A sea urchin's shell with spines.
struct UrchinParams {
  float radius_m = 0.028f;  // Radius of the body.
  float spine_m = 0.045f;   // The longest.
  uint64_t seed = 0;
};
Asset MakeUrchin(const UrchinParams& params);
Asset SampleUrchin(Rng& rng);

// Kinds of small finds.
enum class Trinket { kSnailShell, kScallop, kPineCone, kPebbles, kCoral, kAnimal, kCount };

// One small find for a shelf.
struct TrinketParams {
  Trinket kind = Trinket::kScallop;
  float size_m = 0.07f;
  uint64_t seed = 0;
};
Asset MakeNatureShelfTrinkets(const TrinketParams& params);
Asset SampleNatureShelfTrinkets(Rng& rng);

// A bowl with fruit.
struct FruitContainerParams {
  float radius_m = 0.125f;
  int fruit = 0;  // The most: 0 apples, 1 oranges, 2 pears, 3 lemons.
  uint64_t seed = 0;
};
// A bowl of fruit.
Asset MakeFruitContainer(const FruitContainerParams& params);
Asset SampleFruitContainer(Rng& rng);

}  // namespace parallax
