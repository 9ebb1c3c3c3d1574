// Kitchen machines: ovens with hobs, microwaves, dishwashers, beverage fridges. Fronts face +y.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// A cooker: an oven below a hob. With `backguard`, a panel rises behind the hob.
struct OvenParams {
  float width_m = 0.6f;
  float depth_m = 0.6f;
  float height_m = 0.88f;  // Height of the hob above the floor.
  bool gas = true;         // Grates and burners instead of a glass hob.
  bool backguard = true;   // A panel behind the hob.
  bool drawer = true;      // Under the oven door.
  int knobs = 5;
  uint64_t seed = 0;
};
Asset MakeOven(const OvenParams& params);
Asset SampleOven(Rng& rng);

// A microwave oven with its controls beside the door.
struct MicrowaveParams {
  float width_m = 0.5f;
  float depth_m = 0.38f;
  float height_m = 0.29f;
  float panel_m = 0.11f;  // Width of the controls beside the door.
  bool keypad = true;     // Else two knobs.
  bool handle = true;
  uint64_t seed = 0;
};
Asset MakeMicrowave(const MicrowaveParams& params);
Asset SampleMicrowave(Rng& rng);

// A built-in dishwasher.
struct DishwasherParams {
  float width_m = 0.6f;
  float depth_m = 0.58f;
  float height_m = 0.84f;
  bool hidden_controls = false;  // On the door's upper edge.
  HandleStyle handle = HandleStyle::kBar;
  FrontStyle front = FrontStyle::kFlat;
  uint64_t seed = 0;
};
Asset MakeDishwasher(const DishwasherParams& params);
Asset SampleDishwasher(Rng& rng);

// A small fridge with a glass door.
struct BeverageFridgeParams {
  float width_m = 0.5f;
  float depth_m = 0.52f;
  float height_m = 0.82f;
  int shelves = 4;
  bool full = true;  // Bottles and cans on the shelves.
  uint64_t seed = 0;
};
Asset MakeBeverageFridge(const BeverageFridgeParams& params);
Asset SampleBeverageFridge(Rng& rng);

}  // namespace parallax
