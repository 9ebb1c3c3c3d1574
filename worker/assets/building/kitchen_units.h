// Fitted kitchens: islands and runs along a wall.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// A kitchen island, or a run of units along a wall.
struct KitchenParams {
  float width_m = 2.4f;
  float depth_m = 0.62f;
  float height_m = 0.9f;
  int columns = 4;
  FrontStyle fronts = FrontStyle::kShaker;
  HandleStyle handles = HandleStyle::kBar;
  int sink_column = 1;   // Where the basin is let in; -1 = none.
  float overhang_m = 0;  // How far the worktop juts out at the back: an island's bar.
  // Kitchen runs only:
  float upper_low_m = 1.42f, upper_high_m = 2.15f;
  int hood_column = 3;  // An extractor hood instead of a wall cabinet; -1 = none.
  int open_column = 0;  // Shelves instead of doors; -1 = none.
  uint64_t seed = 0;
};
Asset MakeKitchenIsland(const KitchenParams& params);
Asset MakeKitchenSpace(const KitchenParams& params);
Asset SampleKitchenIsland(Rng& rng);
Asset SampleKitchenSpace(Rng& rng);

}  // namespace parallax
