// Converts between recipes and TerrainSpec, and checks the bounds of a recipe's rules.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Writes the spec into the recipe: terms, rasters, erosion, roughness, seed.
void SetTerrainSpec(const TerrainSpec& spec, v1::Terrain& recipe);

// Returns the spec that SetTerrainSpec has written. Everything is checked, because recipes may come
// from strangers. Errors: kInvalidArgument for terms that are unknown, and for rasters, counts or
// numbers out of bounds.
absl::StatusOr<TerrainSpec> TerrainSpecOf(const v1::Terrain& recipe);

// Returns the ground of a recipe. The process caches the newest one, so that the stages of one
// scene erode it only once. Thread-safe. Errors: those of TerrainSpecOf.
absl::StatusOr<std::shared_ptr<const Terrain>> TerrainOf(const v1::Terrain& recipe);

// Index of the ground among a landscape's objects. Other parts, such as water, follow; layers are
// numbered after them.
inline constexpr uint32_t kGroundIndex = 1;
// Index of a cave's roof; a landscape without a roof has no object of this index.
inline constexpr uint32_t kRoofIndex = 2;

// The most things a square metre of a layer.
inline constexpr double kMostPerM2 = 60;
// The most holes of a roof.
inline constexpr int kMostSkylights = 64;

// Checks the bounds of the rules: prototypes of layers, densities, masks, ranges. Errors:
// kInvalidArgument.
absl::Status CheckRules(const v1::Terrain& recipe);

}  // namespace parallax
