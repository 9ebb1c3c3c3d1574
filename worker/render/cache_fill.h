// Fills a radiance cache with paths from all viewpoints of a scene; lights learn from them too.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera.h"
#include "worker/render/path_tracer.h"

namespace parallax {

struct CacheFill {
  int64_t paths = 1 << 20;  // Total over all rigs. Time is proportional to it.
  float cell_m = 0.06f;     // Width of cells near the rigs.
  int min_records = 8;      // A cell with fewer is left out: paths go on there.
  size_t max_cells =
      1 << 20;  // Bounds memory: 56 bytes a cell at most while filling, 8 an entry later.
};

// `lights` forget what they learnt before, and learn from the same paths what each of them gives to
// each part of the scene, and where its surfaces are bright.
// Every `rig` gets the same share of paths, from both eyes. The first rounds of paths run to their
// end, after 32 bounces at the least; later ones end at their third surface with what the rounds
// before have learnt. The result depends on the arguments only, not on threads.
// Errors: kCancelled.
absl::StatusOr<RadianceCache> FillRadianceCache(const RenderScene& scene, LightTable* lights,
                                                const PathOptions& options, uint64_t scene_seed,
                                                const std::vector<StereoCamera>& rigs,
                                                const CacheFill& fill, const CancelToken& cancel);

}  // namespace parallax
