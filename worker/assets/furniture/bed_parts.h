// Beds: their parameters, the mattress, headboards, and the frame's dimensions that they refer to.
#pragma once

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

// Plain ticking, stitched lozenges, deep buttoned tufts, or rows of channels across.
enum class MattressTop { kPlain, kLozenges, kTufts, kChannels, kCount };

// A mattress by itself, lying flat.
struct MattressParams {
  float width_m = 1.6f, length_m = 2.0f, height_m = 0.22f;
  MattressTop top = MattressTop::kLozenges;
  int straps = 2;  // To carry it by, on each long side.
  uint64_t seed = 0;
};

// A mattress with rounded edges, two cords and a worked top; its sides are group 1. Its underside
// is at z = 0.
kernel::Shape MattressBody(const MattressParams& params);

// Inside of the side rails; y of head and foot; height of the slats' top. Metres.
struct BedLayout {
  explicit BedLayout(const BedParams& p)
      : x(0.5f * p.width_m + 0.012f),
        head(-0.5f * p.length_m - 0.015f),
        foot(0.5f * p.length_m + 0.015f),
        slats(p.frame_top_m - 0.09f) {}
  float x, head, foot, slats;
};

// Adds the headboard with its posts; kNone adds nothing.
void AddHeadboard(kernel::AssetBuilder& b, const BedParams& p, const BedLayout& layout);

}  // namespace parallax
