// Parts of beds: the mattress, headboards, and the frame's dimensions that they refer to.
#pragma once

#include "worker/assets/furniture/beds.h"

namespace parallax {

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
