// First hits of pinhole eyes by rasterisation: the same triangles that camera rays meet (but for
// rounding along edges), at a fifth to a fiftieth of their cost.
//
// Triangles are seen from both sides, as rays see them. Of the triangles at a sample the one with
// the greatest 1/z counts, of equal ones that with the lower body, then triangle: the result
// depends neither on the order of drawing nor on strips or threads. Triangles of a mesh leave no
// gaps along the edges that they share. Nothing nearer than kNearM along the optical axis is seen.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera.h"
#include "worker/render/raster/clusters.h"
#include "worker/render/raster/visibility_buffer.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Draws the bodies of a scene as they are placed at that time. Borrows the scene. Draw is
// thread-safe and uses all threads.
class Rasteriser {
 public:
  static constexpr float kNearM = 0.01f;

  // Cuts all meshes and prototypes into clusters.
  // Errors: kResourceExhausted when they do not fit in memory.
  static absl::StatusOr<Rasteriser> Create(const RenderScene& scene);

  // Draws what a pinhole camera sees, at points of the stream. Once cancelled, leaves rows empty.
  VisibilityBuffer Draw(const PinholeCamera& camera, uint32_t stream_hash,
                        const CancelToken& cancel) const;

 private:
  explicit Rasteriser(const RenderScene& scene) : scene_(&scene) {}

  const RenderScene* scene_;
  ClusteredMeshes meshes_;
  std::vector<ClusteredMeshes::Range> ranges_;  // The meshes', then the prototypes'.
};

}  // namespace parallax
