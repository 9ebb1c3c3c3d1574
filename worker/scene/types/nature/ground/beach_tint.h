// The colours of sand and shingle beside water.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "common/math/types.h"

namespace parallax {

// Returns the mean base colour, linear Rec. 709, that a material with this seed has from some
// metres away. Errors: as MakeMaterial.
absl::StatusOr<Vec3d> MeanColor(const char* material_class, uint64_t seed);

// Returns the tint, linear Rec. 709, of the material "Sand" beside water: waves wash the red and
// yellow coats off the grains, so it is as light as a dune's sand and nearer to beige. Errors: as
// MakeMaterial.
absl::StatusOr<Vec3d> BeachTint(uint64_t sand_seed);

// Returns the tint, linear Rec. 709, of the material "Gravel" on a beach of that sand: the sand is
// what the same stones were ground to, so both are alike, the stones somewhat darker. Errors: as
// MakeMaterial.
absl::StatusOr<Vec3d> ShingleTint(uint64_t gravel_seed, uint64_t sand_seed);

}  // namespace parallax
