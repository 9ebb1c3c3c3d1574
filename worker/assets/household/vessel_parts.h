// Profiles, labels and handles that vessels and packages share.
#pragma once

#include <utility>
#include <vector>

#include "worker/assets/parts.h"

namespace parallax {

// Returns a smooth wall: a spline through the points (radius, height), which are given as shares of
// `radius` and `height`, with `steps` segments between two points.
kernel::Path2 Profile(const std::vector<std::pair<float, float>>& shares, float radius,
                      float height, int steps);

// Returns the profile of a flat underside followed by the wall.
kernel::Path2 WithFoot(const kernel::Path2& wall);

// Returns the number of copies of a label around a can or bottle, so that one copy is about square
// and can be read from one side: 1 to 3.
int LabelCopies(float radius_m, float height_m);

// Returns the wall's radius where it first reaches the height `z`.
float RadiusAt(const kernel::Path2& wall, float z);

// The ends of a loop handle on a vessel's wall at +x (x: radius, z: height), and the handle's size.
struct LoopHandleParams {
  float low_x = 0, low_z = 0, high_x = 0, high_z = 0;
  float out_m = 0.03f;  // How far it stands off.
  float width_m = 0.012f, thickness_m = 0.008f;
};
// Returns a loop handle, bent in the plane y = 0.
kernel::Shape LoopHandle(const LoopHandleParams& params);

}  // namespace parallax
