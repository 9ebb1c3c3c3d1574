// Lamps: standing, on desks, hanging. Each has emissive slots: "bulb", and "shade_inside" for a
// glowing lining.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Forms of lamp shades.
enum class ShadeStyle { kDrum, kEmpire, kPleated, kDome, kGlobe, kCount };

// A standing lamp.
struct FloorLampParams {
  float height_m = 1.6f;
  float shade_radius_m = 0.2f;
  ShadeStyle shade = ShadeStyle::kEmpire;
  // 0 straight pole, 1 turned column, 2 tripod, 3 arc, 4 uplighter, 5 paper lantern, 6 three
  // globes up a pole.
  int stand = 0;
  uint64_t seed = 0;
};
Asset MakeFloorLamp(const FloorLampParams& params);
Asset SampleFloorLamp(Rng& rng);

// A table or desk lamp.
struct DeskLampParams {
  float height_m = 0.5f;
  // 0 jointed arms, 1 vase body with shade, 2 turned column with shade, 3 gooseneck.
  int style = 0;
  ShadeStyle shade = ShadeStyle::kEmpire;
  uint64_t seed = 0;
};
Asset MakeDeskLamp(const DeskLampParams& params);
Asset SampleDeskLamp(Rng& rng);

// A lamp that hangs from the ceiling.
struct CeilingLampParams {
  float drop_m = 0.7f;  // Ceiling to the lamp's underside.
  float radius_m = 0.22f;
  // 0 dome pendant, 1 drum pendant, 2 globe, 3 chandelier, 4 bowl close to the ceiling.
  int style = 0;
  int arms = 5;  // Arms of a chandelier.
  uint64_t seed = 0;
};
// The ceiling is z = 0; the lamp hangs below it.
Asset MakeCeilingLamp(const CeilingLampParams& params);
Asset SampleCeilingClassicLamp(Rng& rng);

}  // namespace parallax
