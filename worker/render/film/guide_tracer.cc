#include "worker/render/film/guide_tracer.h"

#include <algorithm>
#include <bit>

namespace parallax {

GuideTracer::GuideTracer(const RenderScene& scene, const LightTable& lights,
                         const PathOptions& options, const PinholeCamera& camera,
                         uint32_t stream_hash, const VisibilityBuffer& visible)
    : tracer_(scene, lights, options),
      rays_(camera),
      stream_hash_(stream_hash),
      visible_(visible) {}

void GuideTracer::AddFragments(const PixelAt& at, uint32_t pixel) {
  constexpr int kAlike = 4;  // Samples of one triangle that share an evaluation.
  const uint32_t* const ids = visible_.Ids(at.x, at.y);
  uint32_t left = (1u << VisibilityBuffer::kSamples) - 1;
  while (left != 0) {
    const uint32_t id = ids[std::countr_zero(left)];
    int alike = 0;
    for (uint32_t rest = left; rest != 0; rest &= rest - 1) {
      const int sample = std::countr_zero(rest);
      if (ids[sample] != id) continue;
      left &= ~(1u << sample);
      if (alike++ % kAlike == 0) {
        fragments_.push_back({pixel, static_cast<uint32_t>(sample), id, 0});
      }
      fragments_.back().weight += 1;
    }
  }
}

void GuideTracer::Start(std::span<const PixelAt> pixels) {
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
      StartAtSeen(visible_, at, fragment.sample, k, &start, &u, &v);
    }
    start.seed = Bits8{} + stream_hash_;
    start.sample = Sampler::NumberInImage(x, y, SamplePoints::kLog2Samples, sample);
    start.dimension = 1;
    start.rays = rays_.Through(ToFloat((Int8)x) + u, ToFloat((Int8)y) + v);
    start.spread = Splat(rays_.spread());
  }
}

uint64_t GuideTracer::Trace(std::span<const PixelAt> pixels, const CancelToken& cancel,
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
    results_[i].guide_weight *= fragments_[i].weight;
    sums_[fragments_[i].pixel].Add(results_[i]);
    rays += results_[i].rays;
  }
  if (cancel.cancelled()) return rays;
  for (size_t i = 0; i < pixels.size(); ++i) film->AddGuides(pixels[i], sums_[i]);
  return rays;
}

}  // namespace parallax
