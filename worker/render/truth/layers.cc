#include "worker/render/truth/layers.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

#include "common/base/status.h"
#include "worker/render/truth/truth_tracer.h"

namespace parallax {
namespace {

constexpr int kMostHits = 64;  // Bounds the hits of one line.

bool IsSamePlace(const SurfaceHit& a, const SurfaceHit& b) {
  return a.raw.placed == b.raw.placed && a.id.material == b.id.material &&
         double{b.raw.distance} - double{a.raw.distance} < kSamePlace_m;
}

// The layers of one eye, being traced row by row.
class LayerTracer {
 public:
  LayerTracer(const RenderScene& scene, const PinholeCamera& camera, double baseline_m)
      : tracer_(scene, camera),
        width_(camera.width_px),
        focal_times_baseline_(camera.fx_px * baseline_m) {
    maps_.count = ImageU8(width_, camera.height_px);
    for (LayerMaps::Layer& layer : maps_.behind) {
      layer = {ImageF(width_, camera.height_px), ImageF(width_, camera.height_px),
               ImageU16(width_, camera.height_px), ImageU16(width_, camera.height_px)};
    }
  }

  // Thread-safe for different rows.
  void Row(int y) {
    std::array<PixelTruth, TruthTracer::kRun> truths;
    std::array<SurfaceHit, TruthTracer::kRun> hits;
    std::map<uint32_t, Clearness> clear;
    for (int x = 0; x < width_; ++x) {
      const auto k = static_cast<size_t>(x % TruthTracer::kRun);
      if (k == 0) {
        tracer_.At(x, y, std::min(TruthTracer::kRun, width_ - x), truths.data(), &hits);
      }
      maps_.count(x, y) = Pixel(x, y, truths[k], hits[k], &clear);
    }
    std::lock_guard<std::mutex> lock(mutex_);
    maps_.clear.merge(clear);
  }

  LayerMaps Take() {
    size_t most = 0;  // Layers that any pixel has.
    for (const uint8_t count : maps_.count.values()) {
      most = std::max(most, static_cast<size_t>(count & ~kMoreLayers));
    }
    for (size_t i = 0; i < maps_.behind.size(); ++i) {
      if (most < i + 2) maps_.behind[i] = {};
    }
    return std::move(maps_);
  }

 private:
  // Follows one line. Returns the pixel's count.
  uint8_t Pixel(int x, int y, const PixelTruth& first, SurfaceHit hit,
                std::map<uint32_t, Clearness>* clear) {
    if (!first.surface) return 0;
    PixelTruth last = first;
    SurfaceHit counted = hit;
    int count = 1;
    for (int hits = 0; last.clear != Clearness::kOpaque && hits < kMostHits; ++hits) {
      clear->emplace(last.material, last.clear);
      const PixelTruth next = tracer_.Behind(&hit);
      if (!next.surface) break;
      if (IsSamePlace(counted, hit)) continue;
      const auto depth = static_cast<float>(next.depth);
      if (!(depth > static_cast<float>(last.depth))) continue;
      if (count == kMostLayers) return static_cast<uint8_t>(count | kMoreLayers);
      LayerMaps::Layer& layer = maps_.behind[static_cast<size_t>(count - 1)];
      layer.depth_m(x, y) = depth;
      layer.disparity_px(x, y) = static_cast<float>(focal_times_baseline_ / double{depth});
      layer.objects(x, y) = static_cast<uint16_t>(next.object);
      layer.materials(x, y) = static_cast<uint16_t>(next.material);
      ++count;
      last = next;
      counted = hit;
    }
    return static_cast<uint8_t>(count);
  }

  const TruthTracer tracer_;
  const int width_;
  const double focal_times_baseline_;
  LayerMaps maps_;
  std::mutex mutex_;  // Guards maps_.clear.
};

}  // namespace

absl::StatusOr<LayerMaps> TraceLayers(const RenderScene& scene, const PinholeCamera& camera,
                                      double baseline_m, const CancelToken& cancel) {
  LayerTracer tracer(scene, camera, baseline_m);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    if (!cancel.cancelled()) tracer.Row(y);
  });
  if (cancel.cancelled()) return Cancelled("render: cancelled");
  return tracer.Take();
}

}  // namespace parallax
