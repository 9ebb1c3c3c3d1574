// Windows with their curtains, blinds and shutters, and small hardware: handles, hooks, rails.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Coverings of windows.
enum class WindowDressing { kNone, kBlind, kCurtains, kShutters, kCount };

// A window in its frame, with casing and sill.
struct WindowParams {
  float width_m = 1.2f;
  float height_m = 1.3f;
  float frame_m = 0.055f;
  int sashes = 2;
  int lites_x = 1, lites_y = 2;  // A sash.
  bool sill = true;
  bool casing = true;
  WindowDressing dressing = WindowDressing::kNone;
  float drawn = 0.4f;  // How far the blind or the curtains are drawn.
  uint64_t seed = 0;
};
Asset MakeWindow(const WindowParams& params);
Asset SampleWindow(Rng& rng);
Asset SampleHardware(Rng& rng);

}  // namespace parallax
