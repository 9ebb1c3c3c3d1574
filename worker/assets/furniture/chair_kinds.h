// Chairs: their parameters, and makers of those that share nothing with the four-legged wooden ones
// of chairs.cc.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

// Construction of the back and the legs.
enum class ChairStyle {
  kSlat,
  kLadder,
  kSpindle,
  kUpholstered,
  kCrossed,
  kWindsor,
  kShell,
  kCantilever,
  kCount
};

// A chair with a back. Brackets give usual ranges.
struct ChairParams {
  ChairStyle style = ChairStyle::kSlat;
  float width_m = 0.46f;        // [0.40, 0.52]
  float depth_m = 0.44f;        // [0.38, 0.50]
  float seat_height_m = 0.45f;  // [0.42, 0.49]
  float back_height_m = 0.90f;  // Floor to crest, [0.76, 1.08]
  float lean_m = 0.07f;         // How far the crest lies behind the seat.
  float leg_m = 0.036f;
  float bow_m = 0.03f;  // Curvature of crest and rails.
  LegStyle legs = LegStyle::kTapered;
  int leg_variant = 0;
  int back_parts = 5;  // Slats, rungs, spindles.
  bool arms = false;
  bool cushion = false;  // A padded seat instead of a wooden one.
  bool stretchers = true;
  uint64_t seed = 0;  // Wrinkles and texture offsets.
};

// A hollowed plank on splayed turned legs, sticks in the plank, a bent bow over them.
void AddWindsorChair(kernel::AssetBuilder& b, const ChairParams& p);

// A moulded shell on dowels or wire.
void AddShellChair(kernel::AssetBuilder& b, const ChairParams& p);

// One bent tube and two pads.
void AddCantileverChair(kernel::AssetBuilder& b, const ChairParams& p, const kernel::Noise& noise);

}  // namespace parallax
