// Level of detail: the same object with coarser or finer pieces.
#pragma once

#include <string_view>

#include "worker/assets/asset.h"

namespace parallax {

// `target_edge_m` > 0: curved surfaces and cloth are made of pieces about that long; flat faces
// stay whole, and what a shape needs to be recognised (a fluted column's flutes) stays. 0: each
// class's own, the default detail, as MakeAsset(class_name, seed) gives it. The parameters drawn
// from the seed don't depend on it. Same arguments, same bytes; thread-safe. Errors: kNotFound as
// MakeAsset; kInvalidArgument for an edge below 0.5 mm that is not 0.
absl::StatusOr<Asset> MakeAsset(std::string_view class_name, uint64_t seed, float target_edge_m);

}  // namespace parallax
