#include "worker/render/film/film_tracer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "worker/render/film/fragment_tracer.h"
#include "worker/render/film/overexposed.h"

namespace parallax {
namespace {

constexpr int kTile = 16;
constexpr int kFew = 16;  // Fewer samples than this need extra ones.

// Few samples are spread over neighbouring pixels together; many are spread within each pixel.
bool SampleTogether(const PinholeCamera& camera, int samples) {
  constexpr int kMost = 64;
  constexpr int kWidest = 1 << 13;  // Beyond, they could not be numbered.
  return samples <= kMost && std::max(camera.width_px, camera.height_px) <= kWidest;
}

// The square tiles that cover a picture.
class Tiles {
 public:
  explicit Tiles(const PinholeCamera& camera)
      : width_(camera.width_px),
        height_(camera.height_px),
        columns_((width_ + kTile - 1) / kTile),
        count_(columns_ * ((height_ + kTile - 1) / kTile)) {}

  int count() const { return count_; }
  // The pixels of a tile, row by row.
  std::vector<PixelAt> PixelsOf(int tile) const {
    const int x0 = tile % columns_ * kTile, y0 = tile / columns_ * kTile;
    std::vector<PixelAt> pixels;
    for (int y = y0; y < std::min(y0 + kTile, height_); ++y) {
      for (int x = x0; x < std::min(x0 + kTile, width_); ++x) pixels.push_back({x, y});
    }
    return pixels;
  }

 private:
  const int width_, height_, columns_, count_;
};

}  // namespace

ImageF DisparityOf(const ImageF& depth_m, double focal_times_baseline) {
  ImageF disparity(depth_m.width(), depth_m.height());
  for (size_t i = 0; i < depth_m.values().size(); ++i) {
    const float depth = depth_m.values()[i];
    if (depth > 0) disparity.values()[i] = static_cast<float>(focal_times_baseline / depth);
  }
  return disparity;
}

PathOptions FilmTracer::Options(float clamp) const {
  PathOptions options;
  options.max_bounces = profile_.max_bounces;
  options.clamp_luminance = clamp;
  options.cache = light_.cache && !light_.cache->empty() ? light_.cache : nullptr;
  options.cache_footprint = profile_.cache_footprint;
  if (light_.volume && !light_.volume->empty()) {
    options.volume = light_.volume;
    options.direct = DirectLight::kSunByLightSampling;
  }
  return options;
}

float FilmTracer::PilotLuminance(const SampleStream streams[2], const StereoCamera& stereo) const {
  constexpr int kColumns = 64;
  constexpr int kRows = 36;
  std::vector<float> rows(2 * kRows);
  tbb::parallel_for(0, 2 * kRows, [&](int index) {
    const int eye = index / kRows;
    const PinholeCamera& camera = stereo.eyes[eye];
    const uint32_t stream = streams[eye].Hash();
    const CameraRays rays(camera);
    std::vector<Path> paths;
    for (int column = 0; column < kColumns; ++column) {
      const int row = index % kRows;
      Sampler sampler(stream, static_cast<uint32_t>(column), static_cast<uint32_t>(row), 0);
      const Vec2f jitter = sampler.Pair();
      const Vec2f at((static_cast<float>(column) + jitter.x()) / kColumns,
                     (static_cast<float>(row) + jitter.y()) / kRows);
      Path& path = paths.emplace_back(sampler);
      path.ray = rays.Through(at.x() * static_cast<float>(camera.width_px),
                              at.y() * static_cast<float>(camera.height_px));
    }
    PathTracer(geometry_, lights_, Options(0)).Trace(paths);
    float sum = 0;
    for (const Path& path : paths) {
      sum += std::sqrt(std::max(Luminance(path.result.radiance), 0.0f));
    }
    rows[static_cast<size_t>(index)] = sum;
  });
  float sum = 0;
  for (const float row : rows) sum += row;
  // Square of the mean square root: between geometric and arithmetic mean, and robust to noise.
  return std::max(Square(sum / (2 * kRows * kColumns)), 1e-3f);
}

bool FilmTracer::NeedsRasteriser(const RenderProfile& profile) {
  return profile.samples_per_pixel < kFew;
}

std::optional<VisibilityBuffer> FilmTracer::Draw(const PinholeCamera& camera,
                                                 const SampleStream& stream,
                                                 const CancelToken& cancel) const {
  if (camera.lens != nullptr || SamplesOf(camera) >= kFew) return std::nullopt;
  return rasteriser_->Draw(camera, stream.Hash(), cancel);
}

void FilmTracer::TraceEye(const PinholeCamera& camera, const SampleStream& stream,
                          const VisibilityBuffer* visible, const EyeTruth& truth, float clamp,
                          const CancelToken& cancel, TraceMeter* meter, Film* film) const {
  const int samples = SamplesOf(camera);
  const PixelSampling sampling{stream.Hash(),
                               samples,
                               SampleTogether(camera, samples),
                               truth.disparity_px.empty() ? nullptr : &truth.disparity_px,
                               truth.focal_times_baseline,
                               truth.baselines,
                               visible};
  const PathOptions options = Options(clamp);
  const auto trace = [&](auto make) {
    tbb::enumerable_thread_specific<std::invoke_result_t<decltype(make)>> tracers(make);
    const Tiles tiles(camera);
    tbb::parallel_for(0, tiles.count(), [&](int tile) {
      const std::vector<PixelAt> pixels = tiles.PixelsOf(tile);
      meter->AddRays(tracers.local().Trace(pixels, cancel, film));
      if (!cancel.cancelled()) meter->AddPixels(static_cast<int64_t>(pixels.size()));
    });
  };
  if (visible && options.volume) {
    trace([&] { return FragmentTracer(geometry_, lights_, options, camera, sampling); });
  } else {
    trace([&] { return PixelTracer(geometry_, lights_, options, camera, sampling); });
  }
}

template <typename MakeTracer>
void FilmTracer::TracePixels(const MakeTracer& make, const std::vector<PixelAt>& pixels,
                             const CancelToken& cancel, TraceMeter* meter, Film* film) {
  constexpr size_t kAtOnce = kTile * kTile;
  tbb::enumerable_thread_specific<std::invoke_result_t<MakeTracer>> tracers(make);
  tbb::parallel_for(size_t{0}, (pixels.size() + kAtOnce - 1) / kAtOnce, [&](size_t part) {
    const std::span all(pixels);
    const auto some = all.subspan(part * kAtOnce, std::min(kAtOnce, all.size() - part * kAtOnce));
    meter->AddRays(tracers.local().Trace(some, cancel, film));
  });
}

void FilmTracer::TraceGuides(const PinholeCamera& camera, const SampleStream& stream,
                             const VisibilityBuffer* visible, const CancelToken& cancel,
                             TraceMeter* meter, Film* film) const {
  constexpr int kMoreRays = 8;
  const bool whole = visible && light_.volume;  // TraceEye has taken all that is visible.
  if (profile_.denoise == DenoiseQuality::kOff || SamplesOf(camera) >= kFew || whole) return;
  PathOptions options = Options(0);
  options.cache = nullptr;
  options.volume = nullptr;
  options.only_guides = true;
  const std::vector<PixelAt> mixed = film->MixedPixels();
  PixelSampling sampling{stream.Hash(), kMoreRays};
  sampling.visible = visible;
  if (visible) {
    const auto make = [&] { return FragmentTracer(geometry_, lights_, options, camera, sampling); };
    TracePixels(make, mixed, cancel, meter, film);
  } else {
    const auto make = [&] { return PixelTracer(geometry_, lights_, options, camera, sampling); };
    TracePixels(make, mixed, cancel, meter, film);
  }
}

void FilmTracer::TraceEdges(const PinholeCamera& camera, const SampleStream& stream, float clamp,
                            float exposure, const CancelToken& cancel, TraceMeter* meter,
                            Film* film) const {
  constexpr int kTimes = 4;
  const int samples = SamplesOf(camera);
  if (profile_.clamp <= 0.0f || samples >= kFew) return;
  const PixelSampling sampling{stream.Hash(), kTimes * samples};
  const auto make = [&] {
    return PixelTracer(geometry_, lights_, Options(clamp), camera, sampling);
  };
  TracePixels(make, EdgesOf(Overexposed(film->color, exposure)), cancel, meter, film);
}

}  // namespace parallax
