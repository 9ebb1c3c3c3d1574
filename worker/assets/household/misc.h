// Things of no family: pallets, racks, balloons, baskets.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// A wooden pallet for goods.
struct PalletParams {
  float width_m = 1.2f, depth_m = 0.8f;
  int top_boards = 6;
  uint64_t seed = 0;
};
// Stretcher boards over nine blocks, nailed.
Asset MakePallet(const PalletParams& params);
Asset SamplePallet(Rng& rng);

// A storage rack with its load.
struct RackParams {
  float width_m = 1.5f, depth_m = 0.6f, height_m = 2.0f;
  int levels = 3;
  uint64_t seed = 0;  // Which cartons and bins stand on it.
};
// Steel uprights, beams, wire decks, cartons and bins on them.
Asset MakeRack(const RackParams& params);
Asset SampleRack(Rng& rng);

// A few balloons.
struct BalloonParams {
  bool letters = false;  // Foil letters or numbers, else rubber ones on ribbons.
  int count = 2;
  float height_m = 0.45f;  // Height of a letter.
  uint64_t seed = 0;
};
Asset MakeBalloon(const BalloonParams& params);
Asset SampleBalloon(Rng& rng);

// A woven basket.
struct BasketParams {
  float radius_m = 0.16f, height_m = 0.18f;
  float flare = 0.1f;  // The rim's radius less the base's, in radii.
  int stakes = 23;     // Uprights; odd, so that each round goes the other way round.
  bool handles = true;
  uint64_t seed = 0;
};
// Woven: uprights, weavers that go in and out, a plaited rim.
Asset MakeBasketBase(const BasketParams& params);
Asset SampleBasketBase(Rng& rng);

}  // namespace parallax
