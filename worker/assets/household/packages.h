// Packages that food is sold in: cans and tins, cartons, bags.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

enum class CanStyle { kDrink, kSlimDrink, kTin, kFlatTin, kFishTin, kSpray, kCount };

// A can or tin.
struct CanParams {
  CanStyle style = CanStyle::kDrink;
  float radius_m = 0.033f;  // Half of the width for the fish tin.
  float height_m = 0.12f;
  bool opened = false;  // A tin's lid bent up, a drink's tab raised.
  uint64_t seed = 0;
};
Asset MakeCan(const CanParams& params);
Asset SampleCan(Rng& rng);

enum class FoodBoxStyle { kCereal, kGable, kTray, kSlab, kBrick, kCount };

// A carton.
struct FoodBoxParams {
  FoodBoxStyle style = FoodBoxStyle::kCereal;
  float width_m = 0.17f, depth_m = 0.06f, height_m = 0.24f;
  float flap_rad = 0;  // How far the lid's flap stands open; 0 = shut.
  uint64_t seed = 0;
};
Asset MakeFoodBox(const FoodBoxParams& params);
Asset SampleFoodBox(Rng& rng);

enum class FoodBagStyle { kPillow, kPouch, kBlock, kRolled, kCount };

// A bag or pouch.
struct FoodBagParams {
  FoodBagStyle style = FoodBagStyle::kPillow;
  float width_m = 0.17f, height_m = 0.24f, belly_m = 0.06f;
  bool spout = false;  // Only pouches have one.
  uint64_t seed = 0;
};
Asset MakeFoodBag(const FoodBagParams& params);
Asset SampleFoodBag(Rng& rng);

}  // namespace parallax
