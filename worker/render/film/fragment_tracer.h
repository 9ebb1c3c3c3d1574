// Pixels of one eye's picture, or the denoiser's guides of single pixels, from the triangles that a
// visibility buffer has there.
#pragma once

#include <span>
#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/film/film.h"
#include "worker/render/film/pixel_tracer.h"
#include "worker/render/film/seen_starts.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// Begins a path at each of a pixel's triangles for every few of its samples that show it, at the
// middle of these, weighted by their number. Reuses its scratch memory between calls: not
// thread-safe. All arguments must outlive it.
class FragmentTracer {
 public:
  // `sampling.visible` is set; its samples are all that the buffer has.
  FragmentTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
                 const PinholeCamera& camera, const PixelSampling& sampling);

  // Renders these pixels of the film; with PathOptions::only_guides it only adds guides to them.
  // After a cancel the pixels are left unchanged. Returns the number of rays traced.
  uint64_t Trace(std::span<const PixelAt> pixels, const CancelToken& cancel, Film* film);

 private:
  // Samples of a pixel that one path stands for.
  struct Fragment {
    uint32_t pixel = 0;   // Index among those that are traced together.
    uint32_t sample = 0;  // The first of them.
    int count = 0;
    float x = 0, y = 0;  // Sum of their places in the pixel.
  };

  void AddFragments(const PixelAt& at, uint32_t pixel);
  void Start(std::span<const PixelAt> pixels);

  PathTracer tracer_;
  const CameraRays rays_;
  const PixelSampling sampling_;
  const PinholeCamera& camera_;
  const bool only_guides_;
  std::vector<Fragment> fragments_;
  std::vector<PathStarts8> starts_;
  std::vector<PathResult> results_;
  std::vector<PixelSum> sums_;
};

}  // namespace parallax
