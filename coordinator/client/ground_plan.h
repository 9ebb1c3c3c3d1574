// A place seen from above, drawn with characters. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/types.h"

namespace parallax::client {

// An object's extent on the floor, world frame, metres.
struct Footprint {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double top_m = 0;  // Higher ones cover lower ones.
  char symbol = '?';
};

struct GroundPlanOptions {
  int columns = 64;      // Width of the ground; its edge comes beside it.
  bool unicode = false;  // Arrows for rigs; else '^', '>', 'v', '<'.
};

// One line a row, north (larger y) up. The edge is '#' but for the plan's gaps; rigs are arrows
// that point where the camera looks. A character is about twice as high as wide, which the scale
// allows for.
std::vector<std::string> DrawGroundPlan(const GroundPlan& plan, const v1::Scene& scene,
                                        const std::vector<Footprint>& footprints,
                                        const GroundPlanOptions& options);

// Furniture is 'A'..'Z', floating objects 'a'..'z'; '+' when the letters are used up.
char PlanSymbol(bool floating, size_t nth);

}  // namespace parallax::client
