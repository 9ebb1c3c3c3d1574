// Beds and what lies on them.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

enum class HeadboardStyle { kPanel, kSlats, kUpholstered, kTufted, kArched, kMetal, kNone, kCount };

// A bed, with or without bedding.
struct BedParams {
  float width_m = 1.6f;  // Width of the mattress: 0.9, 1.2, 1.4, 1.6, 1.8.
  float length_m = 2.0f;
  float mattress_m = 0.22f;   // Its thickness.
  float frame_top_m = 0.34f;  // Upper edge of the side rails.
  float headboard_m = 1.1f;   // Its top above the floor.
  HeadboardStyle headboard = HeadboardStyle::kPanel;
  bool footboard = false;
  LegStyle legs = LegStyle::kTapered;
  bool mattress = true;  // The parts: BedFrame has neither mattress nor bedding.
  bool bedding = true;
  bool folded_blanket = true;  // Turned down at the pillows, or drawn up.
  bool throw_blanket = false;  // A second one across the foot.
  uint64_t seed = 0;
};
// The head is at -y, so the foot faces +y.
Asset MakeBed(const BedParams& params);
Asset SampleBed(Rng& rng);
Asset SampleBedFrame(Rng& rng);

// Plain ticking, stitched lozenges, deep buttoned tufts, or rows of channels across.
enum class MattressTop { kPlain, kLozenges, kTufts, kChannels, kCount };

// A mattress by itself, lying flat.
struct MattressParams {
  float width_m = 1.6f, length_m = 2.0f, height_m = 0.22f;
  MattressTop top = MattressTop::kLozenges;
  int straps = 2;  // To carry it by, on each long side.
  uint64_t seed = 0;
};
Asset MakeMattress(const MattressParams& params);
Asset SampleMattress(Rng& rng);

// A stuffed pillow, lying flat.
struct PillowParams {
  float width_m = 0.6f, depth_m = 0.4f, height_m = 0.14f;
  float flange_m = 0.0f;  // A flat border; 0 = none.
  uint64_t seed = 0;
};
Asset MakePillow(const PillowParams& params);
Asset SamplePillow(Rng& rng);

// How a cloth lies: folded to and fro in layers, rolled up, several folded ones stacked, or thrown
// down in a heap.
enum class FoldStyle { kFolded, kRolled, kStacked, kThrown, kCount };

// Folded, rolled or thrown cloths: blankets and towels.
struct BlanketParams {
  FoldStyle style = FoldStyle::kFolded;
  float width_m = 0.5f, depth_m = 0.4f;  // Folded size; length and width if rolled.
  int layers = 4;                        // Or turns of the roll.
  float layer_m = 0.022f;
  int stack = 1;       // Folded cloths on each other.
  float fringe_m = 0;  // Threads along the front edge of a folded one; 0 = hemmed.
  bool terry = false;  // A towel's cloth.
  uint64_t seed = 0;
};
Asset MakeBlanket(const BlanketParams& params);
Asset SampleBlanket(Rng& rng);
Asset SampleTowel(Rng& rng);

}  // namespace parallax
