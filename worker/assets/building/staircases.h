// Staircases of one storey: straight, curved, spiral and with a landing. They climb away from the
// front (+y).
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Construction: risers and stringers; treads on stringers only; masonry.
enum class StairBody { kClosed, kOpen, kSolid, kCount };
enum class StairRail { kBalusters, kCables, kGlass, kCount };

// The flight, its construction and its rails.
struct StairParams {
  StairBody body = StairBody::kClosed;
  StairRail rail = StairRail::kBalusters;
  int steps = 13;
  float rise_m = 0.18f;
  float run_m = 0.27f;  // On the walking line.
  float width_m = 0.9f;
  float tread_m = 0.035f;
  float rail_height_m = 0.9f;
  bool rail_left = true, rail_right = true;
  float turn_rad = 1.6f;  // Total turn of a curved stair or of a spiral.
  uint64_t seed = 0;
};
Asset MakeSpiralStaircase(const StairParams& params);
Asset MakeUShapedStaircase(const StairParams& params);

}  // namespace parallax
