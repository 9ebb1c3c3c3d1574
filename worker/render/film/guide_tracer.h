// The denoiser's guides of single pixels, from the triangles that a visibility buffer has there.
#pragma once

#include <span>
#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/film/film.h"
#include "worker/render/film/seen_starts.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// Evaluates each of a pixel's triangles at one sample for every few that show it, weighted by their
// number, and follows rays from mirrors, panes and holes only. Reuses its scratch memory between
// calls: not thread-safe. All arguments must outlive it.
class GuideTracer {
 public:
  // `stream_hash` is that of the visibility buffer.
  GuideTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
              const PinholeCamera& camera, uint32_t stream_hash, const VisibilityBuffer& visible);

  // Adds guides to these pixels of the film; leaves them as they are once cancelled. Returns the
  // number of rays traced.
  uint64_t Trace(std::span<const PixelAt> pixels, const CancelToken& cancel, Film* film);

 private:
  // A sample that stands for some of its pixel.
  struct Fragment {
    uint32_t pixel = 0;  // Index among those that are traced together.
    uint32_t sample = 0;
    uint32_t id = 0;  // VisibilityBuffer's.
    float weight = 0;
  };

  void AddFragments(const PixelAt& at, uint32_t pixel);
  void Start(std::span<const PixelAt> pixels);

  PathTracer tracer_;
  const CameraRays rays_;
  const uint32_t stream_hash_;
  const VisibilityBuffer& visible_;
  std::vector<Fragment> fragments_;
  std::vector<PathStarts8> starts_;
  std::vector<PathResult> results_;
  std::vector<PixelSum> sums_;
};

}  // namespace parallax
