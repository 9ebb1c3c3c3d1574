// Fills a radiance cache with paths from all viewpoints of a scene, from which the light sampler
// learns too.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// The number of paths that fill the cache, and its resolution.
struct CacheFill {
  int64_t paths = 1 << 20;  // Total over all rigs. Time is proportional to it.
  float cell_m = 0.06f;     // Width of cells near the rigs.
  int min_records = 8;      // Cells with fewer are left out: paths go on there.
  // Bounds the memory: at most 56 bytes a cell while filling, 8 bytes an entry later.
  size_t max_cells = 1 << 20;
};

// Traces `fill.paths` paths, from both eyes and in equal shares for each rig, and returns the cache
// of the radiance that surfaces on them scatter. `lights` forgets what it has learnt and learns
// from these paths the gain of each light in each part of the scene, and the bright spots. The
// first rounds trace paths of up to 32 bounces, or the limit of `options` if that is larger; later
// rounds end a path at its third surface with the radiance that earlier rounds have stored. The
// result depends only on the arguments, not on threads. Errors: kCancelled.
absl::StatusOr<RadianceCache> FillRadianceCache(const RenderScene& scene, LightTable* lights,
                                                const PathOptions& options, uint64_t scene_seed,
                                                const std::vector<StereoCamera>& rigs,
                                                const CacheFill& fill, const CancelToken& cancel);

}  // namespace parallax
