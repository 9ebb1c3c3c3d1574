#include "worker/render/film/fragment_tracer.h"

#include <algorithm>
#include <bit>

namespace parallax {

FragmentTracer::FragmentTracer(const RenderScene& scene, const LightTable& lights,
                               const PathOptions& options, const PinholeCamera& camera,
                               const PixelSampling& sampling)
    : tracer_(scene, lights, options),
      rays_(camera),
      sampling_(sampling),
      camera_(camera),
      only_guides_(options.only_guides) {}

void FragmentTracer::AddFragments(const PixelAt& at, uint32_t pixel) {
  constexpr int kAlike = 4;  // Samples of one triangle that share a path.
  const uint32_t* const ids = sampling_.visible->Ids(at.x, at.y);
  const float* const x = sampling_.visible->points().X(at.x, at.y);
  const float* const y = sampling_.visible->points().Y(at.x, at.y);
  uint32_t left = (1u << VisibilityBuffer::kSamples) - 1;
  while (left != 0) {
    const uint32_t id = ids[std::countr_zero(left)];
    const int most = id == VisibilityBuffer::kNothing ? VisibilityBuffer::kSamples : kAlike;
    Fragment& fragment = fragments_.emplace_back();
    fragment.pixel = pixel;
    fragment.sample = static_cast<uint32_t>(std::countr_zero(left));
    for (uint32_t rest = left; rest != 0 && fragment.count < most; rest &= rest - 1) {
      const int sample = std::countr_zero(rest);
      if (ids[sample] != id) continue;
      left &= ~(1u << sample);
      fragment.x += x[sample];
      fragment.y += y[sample];
      ++fragment.count;
    }
  }
}

void FragmentTracer::Start(std::span<const PixelAt> pixels) {
  starts_.assign((fragments_.size() + kLanes - 1) / kLanes, PathStarts8());
  for (size_t begin = 0; begin < fragments_.size(); begin += kLanes) {
    PathStarts8& start = starts_[begin / kLanes];
    Bits8 x{}, y{}, sample{};
    Float8 u{}, v{};
    for (size_t k = 0; k < std::min<size_t>(kLanes, fragments_.size() - begin); ++k) {
      const Fragment& fragment = fragments_[begin + k];
      const PixelAt& at = pixels[fragment.pixel];
      x[k] = static_cast<uint32_t>(at.x);
      y[k] = static_cast<uint32_t>(at.y);
      sample[k] = fragment.sample;
      StartAtSeen(*sampling_.visible, at, fragment.sample, k, &start, &u, &v);
      u[k] = fragment.x / static_cast<float>(fragment.count);
      v[k] = fragment.y / static_cast<float>(fragment.count);
    }
    start.seed = Bits8{} + sampling_.stream_hash;
    start.sample = Sampler::NumberInImage(x, y, SamplePoints::kLog2Samples, sample);
    start.dimension = 1;
    start.rays = rays_.Through(ToFloat((Int8)x) + u, ToFloat((Int8)y) + v);
    start.spread = Splat(rays_.spread());
  }
}

uint64_t FragmentTracer::Trace(std::span<const PixelAt> pixels, const CancelToken& cancel,
                               Film* film) {
  if (cancel.cancelled()) return 0;
  fragments_.clear();
  for (uint32_t i = 0; i < pixels.size(); ++i) AddFragments(pixels[i], i);
  Start(pixels);
  results_.resize(fragments_.size());
  tracer_.Trace(starts_, results_);
  sums_.assign(pixels.size(), PixelSum());
  uint64_t rays = 0;
  for (size_t i = 0; i < fragments_.size(); ++i) {
    const Fragment& fragment = fragments_[i];
    PixelSum& sum = sums_[fragment.pixel];
    results_[i].guide_weight *= static_cast<float>(fragment.count);
    results_[i].radiance *= static_cast<float>(fragment.count);
    sum.Add(results_[i]);
    sampling_.Judge(camera_, pixels[fragment.pixel], results_[i], fragment.count, &sum);
    rays += results_[i].rays;
  }
  if (cancel.cancelled()) return rays;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (only_guides_) {
      film->AddGuides(pixels[i], sums_[i]);
    } else {
      film->Develop(pixels[i], sums_[i], VisibilityBuffer::kSamples);
    }
  }
  return rays;
}

}  // namespace parallax
