// Level ground about a house, v1::Plot: what it does to a land's ground and to what stands on it.
// Pure; thread-safe.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/terrain/ground_mesh.h"

namespace parallax {

// The ground of `terrain`, which must outlive it, lowered by the plot's base and level about it.
MeshedSurface GroundWithPlot(const v1::Plot& plot, const Terrain& terrain);

// Metres from the plot's rectangle; 0 within.
float FromPlot(const v1::Plot& plot, const Vec2f& p);

// Bounds of its numbers. Errors: kInvalidArgument naming the first that is out of them.
absl::Status CheckPlot(const v1::Plot& plot);

}  // namespace parallax
