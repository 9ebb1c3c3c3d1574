// The land that a house stands in, as its windows show it: a biome's own rules, made cheap.
#pragma once

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Draws biome, landform, season and rules from addresses below `root`: coarser rasters than a
// walk's, no small things beyond some metres, a plot as large as `house` (world, metres) at
// `level_m`. It has no materials, indices or hash yet (land_materials.h).
// Errors: as DrawLandform, TerrainOf and CheckRules.
absl::StatusOr<v1::Terrain> DrawHouseLand(const Rng& root, const Eigen::AlignedBox2d& house,
                                          double level_m);

}  // namespace parallax
