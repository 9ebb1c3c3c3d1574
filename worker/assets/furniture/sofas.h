// Upholstered seats: armchairs and sofas of one to four places, straight or L-shaped.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Forms of arm rests.
enum class ArmStyle { kTrack, kRolled, kFlared, kSlope, kWood, kCount };
enum class BackStyle { kLoose, kTight, kPillows, kCount };

// A sofa; an armchair is one of one place.
struct SofaParams {
  int places = 3;               // Seat cushions, [1, 4].
  float place_m = 0.62f;        // Width of a seat cushion.
  float seat_depth_m = 0.58f;   // In front of the back cushions, [0.5, 0.68].
  float seat_height_m = 0.43f;  // Top of the cushion, [0.38, 0.48].
  float back_height_m = 0.82f;  // [0.7, 1.0]
  float arm_height_m = 0.62f;
  float arm_width_m = 0.16f;
  float cushion_m = 0.16f;  // Thickness of the seat cushions.
  ArmStyle arms = ArmStyle::kTrack;
  BackStyle back = BackStyle::kLoose;
  LegStyle legs = LegStyle::kTapered;
  float leg_height_m = 0.11f;
  float piping_m = 0.0f;  // Radius of the seam cord; 0 = none.
  bool tufted = false;    // Buttons in a tight back.
  bool barrel = false;    // One shell, round in plan, instead of arms and back.
  bool chaise = false;    // The last place is drawn out to lie on.
  int throw_pillows = 0;  // Small cushions of another cloth.
  uint64_t seed = 0;
};
Asset MakeSofa(const SofaParams& params);
Asset SampleSofa(Rng& rng);
Asset SampleArmChair(Rng& rng);

}  // namespace parallax
