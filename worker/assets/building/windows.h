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

// A handle, rail or row of hooks.
struct HardwareParams {
  float length_m = 0.2f;
  float rod_m = 0.007f;  // Radius.
  int form = 0;          // 0 bar handle, 1 bow handle, 2 towel rail, 3 row of hooks, 4 lever.
  uint64_t seed = 0;
};
Asset MakeHardware(const HardwareParams& params);
Asset SampleHardware(Rng& rng);

}  // namespace parallax
