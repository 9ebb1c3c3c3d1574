// The colour of sand beside water.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "common/math/types.h"

namespace parallax {

// Returns the mean base colour, linear Rec. 709, that the material "Sand" with this seed has from
// some metres away. Errors: as MakeMaterial.
absl::StatusOr<Vec3d> MeanSandColor(uint64_t sand_seed);

// Returns the tint, linear Rec. 709, of that sand beside water: waves wash the red and yellow coats
// off the grains, so it is as light as a dune's sand and nearer to beige. Errors: as MakeMaterial.
absl::StatusOr<Vec3d> BeachTint(uint64_t sand_seed);

}  // namespace parallax
