// Renders pixels of one eye's picture by tracing paths through them.
#pragma once

#include <span>
#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/film/film.h"
#include "worker/render/film/seen_starts.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// The samples of a pixel.
struct PixelSampling {
  uint32_t stream_hash = 0;
  int samples = 1;
  // Stratifies the samples over neighbouring pixels together, which is better for few samples; else
  // over each pixel by itself.
  bool together = false;
  // Ground truth with which samples are compared (Film::ambiguous), and focal length times
  // baseline. Null: no comparison. Borrowed.
  const ImageF* disparity_px = nullptr;
  double focal_times_baseline = 0;
  // For each rig that shares this eye: its baseline over the one above. At most kMostPartners.
  std::vector<double> baselines = {1.0};
  // The triangles that the eye sees: paths begin at the first `samples` of a pixel's, without a
  // ray. Null: camera rays are traced. Borrowed.
  const VisibilityBuffer* visible = nullptr;

  // Sets the seeds and numbers of the samplers for eight samples of pixels (x, y).
  void Samplers(Bits8 x, Bits8 y, Bits8 sample, Bits8* seeds, Bits8* numbers) const;
  // Compares `count` samples of a pixel with its ground truth, where that is given, and counts them
  // for each rig for which they lie within 1 px of it.
  void Judge(const PinholeCamera& camera, const PixelAt& at, const PathResult& result, int count,
             PixelSum* sum) const;
};

// Reuses its scratch memory between calls: not thread-safe. All arguments must outlive it.
class PixelTracer {
 public:
  PixelTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
              const PinholeCamera& camera, const PixelSampling& sampling);

  // Renders these pixels of the film; with PathOptions::only_guides it only adds guides to them.
  // After a cancel the pixels are left unchanged. Returns the number of rays traced.
  uint64_t Trace(std::span<const PixelAt> pixels, const CancelToken& cancel, Film* film);

 private:
  // Starts up to kAtOnce paths from sample `first` on; returns their number.
  size_t Start(std::span<const PixelAt> pixels, size_t first);

  PathTracer tracer_;
  const CameraRays rays_;
  const PixelSampling sampling_;
  const PinholeCamera& camera_;
  const bool only_guides_;
  static constexpr size_t kAtOnce = 1024;  // Paths.
  std::array<PathStarts8, kAtOnce / kLanes> starts_;
  std::array<PathResult, kAtOnce> results_;
  std::vector<PixelSum> sums_;
};

}  // namespace parallax
