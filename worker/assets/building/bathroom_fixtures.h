// Sanitary ware: taps, wash basins, kitchen sinks, bathtubs.
#pragma once

#include "worker/assets/asset_families.h"
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
Asset MakeTap(const TapParams& params);
Asset SampleTap(Rng& rng);

enum class BasinMount { kPedestal, kVanity, kCount };

// A wash basin with its pedestal or vanity, and its tap.
struct BathroomSinkParams {
  BasinMount mount = BasinMount::kPedestal;
  float width_m = 0.55f;
  float depth_m = 0.44f;
  float basin_m = 0.15f;    // Its height.
  float squareness = 2.6f;  // 2 an ellipse, larger squarer.
  TapParams tap;
  uint64_t seed = 0;
};
Asset MakeBathroomSink(const BathroomSinkParams& params);
Asset SampleBathroomSink(Rng& rng);

// A kitchen sink that is set into a worktop, with its tap.
struct SinkParams {
  float width_m = 0.6f;
  float depth_m = 0.46f;
  float basin_m = 0.2f;
  bool two_basins = false;
  bool drainer = false;  // Ribs beside the basin.
  TapParams tap;
  uint64_t seed = 0;
};
Asset MakeSink(const SinkParams& params);
Asset SampleSink(Rng& rng);

enum class BathtubStyle { kFreestanding, kClawFoot, kBuiltIn, kCount };

// A bathtub, with or without a tap.
struct BathtubParams {
  BathtubStyle style = BathtubStyle::kFreestanding;
  float length_m = 1.65f;
  float width_m = 0.75f;
  float height_m = 0.58f;
  float squareness = 2.8f;
  float slope = 0.25f;  // Slope of the end to lie against; the other walls are steeper.
  float slipper_m = 0;  // How far the head's end rises above the rim.
  bool tap = true;
  uint64_t seed = 0;
};
Asset MakeBathtub(const BathtubParams& params);
Asset SampleBathtub(Rng& rng);

}  // namespace parallax
