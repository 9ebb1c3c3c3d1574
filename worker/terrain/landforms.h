// The shapes of land that biomes stand on: one function each, which draws a TerrainSpec.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// "arctic", "canyon", "cave"...: in order of name.
std::vector<std::string> LandformNames();

// Terms, erosion and roughness of a landform, drawn from `rng`; rasters as TerrainSpec's defaults.
// Errors: kInvalidArgument naming the landforms that there are.
absl::StatusOr<TerrainSpec> DrawLandform(std::string_view name, const Rng& rng);

}  // namespace parallax
