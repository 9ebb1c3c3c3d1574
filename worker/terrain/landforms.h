// The landforms of biomes: one function each, which draws a TerrainSpec.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Returns the names in alphabetical order: "arctic", "canyon", "cave"...
std::vector<std::string> LandformNames();

// Draws terms, erosion and roughness of a landform from `rng`; rasters are TerrainSpec's defaults.
// Errors: kInvalidArgument for an unknown name, listing the landforms.
absl::StatusOr<TerrainSpec> DrawLandform(std::string_view name, const Rng& rng);

}  // namespace parallax
