// Shelves and cabinets. Every board that can carry things is declared as a support, with the free
// height above it.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// An upright carcass of boards with columns and rows of cells.
struct ShelfParams {
  float width_m = 0.8f;
  float depth_m = 0.3f;
  float height_m = 1.8f;
  float board_m = 0.02f;
  int columns = 1;
  int rows = 5;
  float plinth_m = 0.06f;  // Height of the recessed base; 0 with legs.
  float leg_m = 0.0f;      // Height of legs instead of a plinth.
  LegStyle legs = LegStyle::kTapered;
  bool back = true;
  bool cornice = false;      // A moulding on top and a face frame.
  float unevenness = 0.15f;  // How much the rows' heights differ.
  int drawers_low = 0;       // The lowest rows closed by drawers...
  int doors_low = 0;         // ...or by doors.
  FrontStyle fronts = FrontStyle::kFlat;
  HandleStyle handles = HandleStyle::kKnob;
  uint64_t seed = 0;
};
Asset MakeShelf(const ShelfParams& params);
Asset SampleSimpleBookcase(Rng& rng);
Asset SampleLargeShelf(Rng& rng);
Asset SampleCellShelf(Rng& rng);
Asset SampleTVStand(Rng& rng);

// Boards in a corner or between A-frames: a shelf that narrows upwards.
struct TriangleShelfParams {
  float width_m = 0.6f;
  float depth_m = 0.4f;
  float height_m = 1.6f;
  int rows = 4;
  bool ladder = true;  // A-frame ladders; false: a corner shelf with triangular boards.
  uint64_t seed = 0;
};
Asset MakeTriangleShelf(const TriangleShelfParams& params);
Asset SampleTriangleShelf(Rng& rng);

// A cabinet with doors and drawers: wardrobe, chest, kitchen unit.
struct CabinetParams {
  float width_m = 0.9f;
  float depth_m = 0.45f;
  float height_m = 1.9f;
  int columns = 2;      // Doors side by side.
  int drawer_rows = 0;  // Rows of drawers below the doors (wardrobe) or instead of them (chest).
  bool doors = true;
  float leg_m = 0.0f;
  LegStyle legs = LegStyle::kTapered;
  bool crown = false;
  bool top_overhang = true;
  FrontStyle fronts = FrontStyle::kShaker;
  HandleStyle handles = HandleStyle::kKnob;
  bool worktop = false;    // A kitchen's: stone slab, recessed plinth, back panel.
  bool sink_side = false;  // Drawers in one column, doors in the others.
  uint64_t seed = 0;
};
Asset MakeCabinet(const CabinetParams& params);
Asset SampleSingleCabinet(Rng& rng);
Asset SampleKitchenCabinet(Rng& rng);

}  // namespace parallax
