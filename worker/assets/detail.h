// Level of detail: the same object made of coarser or finer pieces.
#pragma once

#include <string_view>

#include "worker/assets/asset.h"

namespace parallax {

// `target_edge_m` > 0: curved surfaces and cloth are made of pieces about that long; flat faces
// stay whole, and so do features by which a shape is recognised (a fluted column's flutes). 0: the
// class's default detail, as MakeAsset(class_name, seed) gives it. The parameters drawn from the
// seed do not depend on it. Equal arguments give equal bytes; thread-safe. Errors: kNotFound as
// MakeAsset; kInvalidArgument for an edge below 0.5 mm that is not 0.
absl::StatusOr<Asset> MakeAsset(std::string_view class_name, uint64_t seed, float target_edge_m);

}  // namespace parallax
