// Basins: one body from the foot over the rim to the drain, as sinks and bathtubs have.
#pragma once

#include "worker/assets/building/bathroom_fixtures.h"

namespace parallax {

MaterialSlot ChromeSlot();

// One level of a basin: its outline between two corners. They go from the foot up the outside, over
// the rim and down inside.
struct BasinLevel {
  Vec2f low, high;
  float z;
  float exponent;  // Exponent of the superellipse; 0: a rectangle.
  float sharpness = 0, corners = 0;
};

kernel::Shape Basin(const std::vector<BasinLevel>& levels);

// A ring with a plug; `at` is the middle of its underside.
void AddDrain(kernel::AssetBuilder& b, const Vec3f& at, float radius);

}  // namespace parallax
