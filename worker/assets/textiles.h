// Rugs and clothes.
#pragma once

#include "worker/assets/families.h"
#include "worker/assets/parts.h"

namespace parallax {

enum class RugStyle { kSquare, kRound, kOval, kRunner, kHide, kCount };

struct RugParams {
  RugStyle style = RugStyle::kSquare;
  float width_m = 2.0f, depth_m = 1.4f;
  float thickness_m = 0.01f;
  float fringe_m = 0;  // Length of the threads at the short ends; 0 = none.
  uint64_t seed = 0;
};
Asset MakeRug(const RugParams& params);
Asset SampleRug(Rng& rng);

}  // namespace parallax
