// Taps, and basins: one body from the foot over the rim to the drain, as sinks and bathtubs have.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

enum class TapStyle { kArc, kBridge, kBlock, kLow, kCount };

// A tap; its spout reaches along +y.
struct TapParams {
  TapStyle style = TapStyle::kArc;
  float height_m = 0.3f;
  float reach_m = 0.18f;
  float pipe_m = 0.011f;  // Radius.
  bool two_handles = false;
  bool cross_handles = false;
  uint64_t seed = 0;
};

// Adds a tap to another asset, with its base at `at`; its spout reaches along +y from there.
void AddTap(kernel::AssetBuilder& builder, const TapParams& params, const Vec3f& at);

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
