// Profiles, labels and handles that vessels and packages share.
#pragma once

#include <utility>
#include <vector>

#include "worker/assets/parts.h"

namespace parallax {

// A smooth wall through points (radius, height), given in shares of the largest radius and the
// height.
kernel::Path2 Profile(const std::vector<std::pair<float, float>>& shares, float radius,
                      float height, int steps);

// The wall, preceded by a flat underside.
kernel::Path2 WithFoot(const kernel::Path2& wall);

// Number of copies of a label around a can or bottle, so that one copy is about square and can be
// read from one side: 1 to 3.
int LabelCopies(float radius_m, float height_m);

// The wall's radius at a height, on its way up.
float RadiusAt(const kernel::Path2& wall, float z);

// The ends of a loop handle on the wall at +x, and its size.
struct LoopHandleParams {
  float low_x = 0, low_z = 0, high_x = 0, high_z = 0;
  float out_m = 0.03f;  // How far it stands off.
  float width_m = 0.012f, thickness_m = 0.008f;
};
// The handle in the plane y = 0.
kernel::Shape LoopHandle(const LoopHandleParams& params);

}  // namespace parallax
