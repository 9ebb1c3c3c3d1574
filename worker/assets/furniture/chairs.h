// Seats for one person without thick upholstery: dining chairs, office chairs, bar stools.
#pragma once

#include "worker/assets/asset_families.h"
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
Asset MakeChair(const ChairParams& params);
Asset SampleChair(Rng& rng);

// A swivel chair on a five-spoke base.
struct OfficeChairParams {
  float seat_width_m = 0.50f;
  float seat_height_m = 0.48f;
  float back_height_m = 0.56f;  // Above the seat.
  float base_radius_m = 0.32f;
  bool mesh_back = false;  // A framed net instead of a cushion.
  bool arms = true;
  bool headrest = false;
  uint64_t seed = 0;
};
Asset MakeOfficeChair(const OfficeChairParams& params);
Asset SampleOfficeChair(Rng& rng);

// The base, and whether there is a low back.
enum class BarChairStyle { kFourLegs, kPedestal, kLowBack, kCount };

// A high stool at bar or counter height.
struct BarChairParams {
  BarChairStyle style = BarChairStyle::kFourLegs;
  float seat_height_m = 0.74f;  // [0.62, 0.82]
  float seat_width_m = 0.36f;
  bool round_seat = true;
  bool padded = true;
  LegStyle legs = LegStyle::kRound;
  int leg_variant = 0;
  uint64_t seed = 0;
};
Asset MakeBarChair(const BarChairParams& params);
Asset SampleBarChair(Rng& rng);

}  // namespace parallax
