// The ground that a recipe describes, and the bounds of its rules.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Writes the spec into the recipe: terms, rasters, erosion, roughness, seed.
void SetTerrainSpec(const TerrainSpec& spec, v1::Terrain& recipe);

// Errors: kInvalidArgument for what no ground can be made of: unknown terms, rasters, counts or
// numbers out of bounds. Recipes come from strangers.
absl::StatusOr<TerrainSpec> TerrainSpecOf(const v1::Terrain& recipe);

// The ground of a recipe. The process remembers the newest: layout, scene and render of one scene
// wear it down once. Thread-safe. Errors: as TerrainSpecOf.
absl::StatusOr<std::shared_ptr<const Terrain>> TerrainOf(const v1::Terrain& recipe);

// Bounds of the rules: prototypes that layers name, densities, ranges. Errors: kInvalidArgument.
absl::Status CheckRules(const v1::Terrain& recipe);

}  // namespace parallax
