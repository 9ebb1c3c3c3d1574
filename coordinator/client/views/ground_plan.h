// Draws a place from above with characters. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/scene_types.h"

namespace parallax::client {

// An object's extent on the floor, world frame, in metres.
struct Footprint {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double top_m = 0;  // Height of its top: higher objects cover lower ones.
  char symbol = '?';
};

struct GroundPlanOptions {
  int columns = 64;      // Width of the ground in characters, without its edge.
  bool unicode = false;  // Arrows for rigs; else '^', '>', 'v', '<'.
};

// Returns the rows of the drawing, north (larger y) first. The edge is '#' except for the plan's
// gaps; rigs are arrows in the direction of view. The scale allows for characters that are twice as
// high as wide.
std::vector<std::string> DrawGroundPlan(const GroundPlan& plan, const v1::Scene& scene,
                                        const std::vector<Footprint>& footprints,
                                        const GroundPlanOptions& options);

// Returns the symbol of the nth object: 'A'..'Z' for furniture, 'a'..'z' for floating objects, '+'
// when the letters are used up.
char PlanSymbol(bool floating, size_t nth);

}  // namespace parallax::client
