#include "worker/render/film/pixel_tracer.h"

#include <bit>

namespace parallax {

void PixelSampling::Samplers(Bits8 x, Bits8 y, Bits8 sample, Bits8* seeds, Bits8* numbers) const {
  if (together) {
    *seeds = Bits8{} + stream_hash;
    *numbers =
        Sampler::NumberInImage(x, y, std::bit_width(static_cast<uint32_t>(samples) - 1), sample);
  } else {
    *seeds = Sampler::SeedOfPixel(Bits8{} + stream_hash, x, y);
    *numbers = sample;
  }
}

void PixelSampling::Judge(const PinholeCamera& camera, const PixelAt& at, const PathResult& result,
                          int count, PixelSum* sum) const {
  if (!disparity_px) return;
  const double along = camera.DirectionAt(at.x + 0.5, at.y + 0.5).norm();
  const double seen =
      result.distance > 0 ? focal_times_baseline * along / static_cast<double>(result.distance) : 0;
  const double off = std::abs(seen - static_cast<double>((*disparity_px)(at.x, at.y)));
  sum->judged = true;
  for (size_t k = 0; k < baselines.size(); ++k) {
    if (baselines[k] * off <= 1) sum->agreeing[k] += count;
  }
}

PixelTracer::PixelTracer(const RenderScene& scene, const LightTable& lights,
                         const PathOptions& options, const PinholeCamera& camera,
                         const PixelSampling& sampling)
    : tracer_(scene, lights, options),
      rays_(camera),
      sampling_(sampling),
      camera_(camera),
      only_guides_(options.only_guides) {}

size_t PixelTracer::Start(std::span<const PixelAt> pixels, size_t first) {
  const auto samples = static_cast<size_t>(sampling_.samples);
  const size_t count = std::min(pixels.size() * samples - first, kAtOnce);
  size_t pixel = first / samples, number = first % samples;
  for (size_t begin = 0; begin < count; begin += kLanes) {
    PathStarts8& start = starts_[begin / kLanes];
    Bits8 x{}, y{}, sample{};
    Float8 u{}, v{};
    for (size_t k = 0; k < std::min<size_t>(kLanes, count - begin); ++k) {
      x[k] = static_cast<uint32_t>(pixels[pixel].x);
      y[k] = static_cast<uint32_t>(pixels[pixel].y);
      sample[k] = static_cast<uint32_t>(number);
      if (sampling_.visible) {
        StartAtSeen(*sampling_.visible, pixels[pixel], number, k, &start, &u, &v);
      }
      if (++number < samples) continue;
      number = 0;
      ++pixel;
    }
    sampling_.Samplers(x, y, sample, &start.seed, &start.sample);
    if (!sampling_.visible) Sampler::Pairs(start.seed, start.sample, Bits8{}, &u, &v);
    start.dimension = 1;
    start.rays = rays_.Through(ToFloat((Int8)x) + u, ToFloat((Int8)y) + v);
    start.spread = Splat(rays_.spread());
  }
  return count;
}

uint64_t PixelTracer::Trace(std::span<const PixelAt> pixels, const CancelToken& cancel,
                            Film* film) {
  sums_.assign(pixels.size(), {});
  const auto samples = static_cast<size_t>(sampling_.samples);
  uint64_t rays = 0;
  for (size_t first = 0; first < pixels.size() * samples;) {
    if (cancel.cancelled()) return rays;
    const size_t count = Start(pixels, first);
    const auto results = std::span(results_).first(count);
    tracer_.Trace(starts_, results);
    size_t pixel = first / samples, left = samples - first % samples;
    for (const PathResult& result : results) {
      sums_[pixel].Add(result);
      sampling_.Judge(camera_, pixels[pixel], result, 1, &sums_[pixel]);
      rays += result.rays;
      if (--left > 0) continue;
      left = samples;
      ++pixel;
    }
    first += count;
  }
  if (cancel.cancelled()) return rays;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (only_guides_) {
      film->AddGuides(pixels[i], sums_[i]);
    } else {
      film->Develop(pixels[i], sums_[i], sampling_.samples);
    }
  }
  return rays;
}

}  // namespace parallax
