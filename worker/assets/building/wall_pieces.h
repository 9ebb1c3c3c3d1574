// Objects with a picture that hang on walls or stand before them: art, mirrors, screens.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// A framed picture or mirror.
struct FrameParams {
  float width_m = 0.6f, height_m = 0.45f;  // Outside.
  float frame_m = 0.03f;  // Width of the frame's bars; 0 = a bare stretched canvas.
  float depth_m = 0.025f;
  int profile = 0;      // 0 flat, 1 rounded, 2 stepped, 3 hollow moulding.
  float mat_m = 0.05f;  // Card border inside the frame; 0 = none.
  bool mirror = false;
  uint64_t seed = 0;
};
Asset MakeFramed(const FrameParams& params);
Asset SampleWallArt(Rng& rng);
Asset SampleMirror(Rng& rng);

// A television or monitor.
struct ScreenParams {
  float diagonal_m = 1.2f;
  float aspect = 16.0f / 9;
  float bezel_m = 0.012f;
  int stand = 0;         // 0 neck and foot, 1 two feet, 2 arm on a foot, 3 slab.
  float lift_m = 0.08f;  // Lower edge above what it stands on.
  uint64_t seed = 0;
};
Asset MakeScreen(const ScreenParams& params);
Asset SampleTv(Rng& rng);
Asset SampleMonitor(Rng& rng);

}  // namespace parallax
