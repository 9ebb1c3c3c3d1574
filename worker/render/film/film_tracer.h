// Traces the film of one eye: the samples of its picture, then more of them where few do not
// suffice (the denoiser's guides, edges of overexposed regions).
#pragma once

#include <atomic>
#include <vector>

#include "common/base/cancel.h"
#include "common/math/stereo.h"
#include "worker/render/film/film.h"
#include "worker/render/film/pixel_tracer.h"
#include "worker/render/paths/irradiance_volume.h"
#include "worker/render/paths/profiles.h"
#include "worker/render/raster/rasteriser.h"
#include "worker/render/renderer.h"

namespace parallax {

// Counts what has been traced of a pair, for its progress. Thread-safe.
class TraceMeter {
 public:
  // `pixels`: number of pixels of all films that will be traced. `progress` is borrowed; it may be
  // empty.
  TraceMeter(const ProgressFn& progress, double pixels) : progress_(progress), pixels_(pixels) {}

  // Counts pixels as done. Tracing takes nearly all of a pair's time; the rest counts as the last
  // twentieth.
  void AddPixels(int64_t count) {
    const int64_t now = done_.fetch_add(count) + count;
    if (progress_) progress_(0.95 * static_cast<double>(now) / pixels_);
  }
  void AddRays(uint64_t count) { rays_ += count; }
  uint64_t rays() const { return rays_; }

 private:
  const ProgressFn& progress_;
  const double pixels_;
  std::atomic<int64_t> done_{0};
  std::atomic<uint64_t> rays_{0};
};

// The exact disparities with which an eye's samples are compared; PixelSampling says what they are.
struct EyeTruth {
  ImageF disparity_px;  // Empty: no comparison.
  double focal_times_baseline = 0;
  std::vector<double> baselines;
};

// Returns the disparity f b / z of each pixel with a depth, and 0 of the others.
ImageF DisparityOf(const ImageF& depth_m, double focal_times_baseline);

// Light that was learnt before, in which paths end; null: not there.
struct StoredLight {
  const RadianceCache* cache = nullptr;      // Serves rooms and caves.
  const IrradianceVolume* volume = nullptr;  // Serves open land.
};

// Traces films. Borrows everything that it is made of. Its functions are thread-safe, use all
// threads, and leave pixels as they are once cancelled.
class FilmTracer {
 public:
  // `rasteriser` is null where NeedsRasteriser says that the profile has no use for it.
  FilmTracer(const RenderScene& geometry, const LightTable& lights, const RenderProfile& profile,
             const StoredLight& light, const Rasteriser* rasteriser)
      : geometry_(geometry),
        lights_(lights),
        profile_(profile),
        light_(light),
        rasteriser_(rasteriser) {}
  static bool NeedsRasteriser(const RenderProfile& profile);

  // Returns the options of paths whose contributions are cut at this luminance; 0: never.
  PathOptions Options(float clamp) const;

  // Returns the mean luminance of a coarse, cheap picture of both eyes, the reference for clamping.
  // Lamps that are seen directly are cut so that they do not raise it.
  float PilotLuminance(const SampleStream streams[2], const StereoCamera& stereo) const;

  // Rasterises what an eye sees at points of the stream. Returns none for a camera with a lens and
  // for profiles with many samples, whose looks are rays.
  std::optional<VisibilityBuffer> Draw(const PinholeCamera& camera, const SampleStream& stream,
                                       const CancelToken& cancel) const;
  // Traces all pixels of the picture. `visible` is what Draw returned for this stream, or null.
  void TraceEye(const PinholeCamera& camera, const SampleStream& stream,
                const VisibilityBuffer* visible, const EyeTruth& truth, float clamp,
                const CancelToken& cancel, TraceMeter* meter, Film* film) const;
  // Adds samples of the denoiser's guides, without light, where a pixel's few samples differ: all
  // that are in `visible`, or if that is null, traced ones. Does nothing for profiles without a
  // denoiser or with many samples.
  void TraceGuides(const PinholeCamera& camera, const SampleStream& stream,
                   const VisibilityBuffer* visible, const CancelToken& cancel, TraceMeter* meter,
                   Film* film) const;
  // Traces the edges of overexposed regions again, with more samples. Does nothing for profiles
  // without a clamp or with many samples.
  void TraceEdges(const PinholeCamera& camera, const SampleStream& stream, float clamp,
                  float exposure, const CancelToken& cancel, TraceMeter* meter, Film* film) const;

 private:
  int SamplesOf(const PinholeCamera& camera) const {
    return profile_.SamplesPerPixel(camera.width_px, camera.height_px);
  }
  // Traces single pixels independently, by tracers that `make` returns, one a thread.
  template <typename MakeTracer>
  static void TracePixels(const MakeTracer& make, const std::vector<PixelAt>& pixels,
                          const CancelToken& cancel, TraceMeter* meter, Film* film);

  const RenderScene& geometry_;
  const LightTable& lights_;
  const RenderProfile& profile_;
  const StoredLight light_;
  const Rasteriser* const rasteriser_;
};

}  // namespace parallax
