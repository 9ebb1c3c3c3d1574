// Rugs and clothes.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Outlines of rugs; kHide is an animal's skin.
enum class RugStyle { kSquare, kRound, kOval, kRunner, kHide, kCount };

// A rug; its pattern comes from its material.
struct RugParams {
  RugStyle style = RugStyle::kSquare;
  float width_m = 2.0f, depth_m = 1.4f;
  float thickness_m = 0.01f;
  float fringe_m = 0;  // Length of the threads at the short ends; 0 = none.
  uint64_t seed = 0;
};
Asset MakeRug(const RugParams& params);
Asset SampleRug(Rng& rng);

// A shirt or vest, lying flat.
struct ShirtParams {
  float width_m = 0.5f, length_m = 0.68f;         // Size of the trunk.
  float sleeve_m = 0.2f;                          // 0 = a vest.
  float cuff_m = 0.14f;                           // Width of the sleeve's end.
  float droop_rad = 0.5f, droop_left_rad = 0.5f;  // Angles of the sleeves below the shoulder line.
  float neck_m = 0.09f;                           // Depth of the neck's cut.
  float flare = 1.0f;                             // The hem's width in parts of the trunk's.
  bool collar = false;                            // With a strip of buttons.
  uint64_t seed = 0;
};
Asset MakeShirt(const ShirtParams& params);
Asset SampleShirt(Rng& rng);

// Trousers, lying flat.
struct PantsParams {
  float waist_m = 0.38f, length_m = 1.0f;
  float rise_m = 0.27f;                                 // Waist to crotch.
  float hem_m = 0.18f;                                  // Width of a leg's end.
  float spread_right_m = 0.06f, spread_left_m = 0.06f;  // How far each leg lies from the middle.
  bool belt = false;
  uint64_t seed = 0;
};
Asset MakePants(const PantsParams& params);
Asset SamplePants(Rng& rng);

}  // namespace parallax
