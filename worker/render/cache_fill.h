// Fills a radiance cache with paths from all viewpoints of a scene; lights learn from them too.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera.h"
#include "worker/render/path_tracer.h"

namespace parallax {

// How many paths fill the cache, and how fine it is.
struct CacheFill {
  int64_t paths = 1 << 20;  // Total over all rigs. Time is proportional to it.
  float cell_m = 0.06f;     // Width of cells near the rigs.
  int min_records = 8;      // Cells with fewer are left out: paths go on there.
  // Bounds the memory: at most 56 bytes a cell while filling, 8 bytes an entry later.
  size_t max_cells = 1 << 20;
};

// Traces `fill.paths` paths, from both eyes and in equal shares for each rig, and returns the cache
// of what their surfaces scatter. `lights` forgets what it learnt before and learns from the same
// paths the gain of each light in each part of the scene, and the bright spots.
// The first rounds of paths run to their end, after 32 bounces at the least; later ones end at
// their third surface with the radiance that earlier rounds learnt. The result depends only on the
// arguments, not on threads. Errors: kCancelled.
absl::StatusOr<RadianceCache> FillRadianceCache(const RenderScene& scene, LightTable* lights,
                                                const PathOptions& options, uint64_t scene_seed,
                                                const std::vector<StereoCamera>& rigs,
                                                const CacheFill& fill, const CancelToken& cancel);

}  // namespace parallax
