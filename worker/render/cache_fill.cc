#include "worker/render/cache_fill.h"

#include <tbb/parallel_for.h>

namespace parallax {
namespace {

constexpr int64_t kPathsPerBatch = 2048;
// Parts of all paths after which the cache is renewed; the first ones run without it.
constexpr double kRounds[] = {0.1, 0.25, 0.5, 1.0};
constexpr int kRegion = 12;               // Cells across a region: 0.7 m near the rigs.
constexpr uint32_t kFillPass = 2;         // SampleStream.pass.
constexpr float kBrightestOverMean = 64;  // Brighter light than this is cut where it is rare.

void Limit(float limit, CacheRecord* record) {
  const float luminance = Luminance(record->radiance);
  if (luminance <= limit) return;
  const Vec3f kept = record->radiance * (limit / luminance);
  record->excess = record->radiance - kept;
  record->radiance = kept;
}

class Filler {
 public:
  Filler(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
         uint64_t scene_seed, const std::vector<StereoCamera>& rigs, const CacheGrid& grid)
      : scene_(scene), lights_(lights), options_(options), rigs_(rigs), grid_(grid) {
    options_.clamp_luminance = 0;
    options_.cache_from = 2;
    stream_hash_ = SampleStream{scene_seed, 0, 0, kFillPass}.Hash();
  }

  void UseCache(const RadianceCache* cache) { options_.cache = cache; }

  // Adds what one path learns. `limit`: luminance above which light is cut; 0 = none.
  void Trace(int64_t index, float limit, CacheBuilder::Batch* batch) const {
    const auto views = static_cast<int64_t>(2 * rigs_.size());
    const auto view = static_cast<size_t>(index % views);
    const PinholeCamera& camera = rigs_[view / 2].eyes[view % 2];
    Sampler sampler(stream_hash_, static_cast<uint32_t>(view), 0,
                    static_cast<uint32_t>(index / views));
    const Vec2f at = sampler.Pair();
    Ray ray;
    ray.origin = camera.origin.cast<float>();
    ray.direction = (camera.world_from_camera *
                     camera.DirectionAt(at.x() * camera.width_px, at.y() * camera.height_px))
                        .normalized()
                        .cast<float>();
    ray.spread = static_cast<float>(1.0 / camera.fx_px);
    PathTrail trail;
    const PathResult path = TracePath(scene_, lights_, options_, ray, sampler, &trail);
    for (int k = 0; k < trail.size; ++k) {
      const PathVertex& vertex = trail.vertices[static_cast<size_t>(k)];
      if (!(vertex.throughput.minCoeff() > 0.0f)) continue;
      CacheRecord record;
      record.rough = vertex.rough;
      record.radiance = (path.radiance - vertex.before).cwiseQuotient(vertex.throughput);
      if (!record.radiance.allFinite()) continue;
      record.radiance = record.radiance.cwiseMax(0.0f);
      if (limit > 0.0f) Limit(limit, &record);
      record.key = grid_.KeyOf(vertex.place);
      record.region = grid_.KeyOf(vertex.place, kRegion);
      batch->Add(record);
    }
  }

 private:
  const RenderScene& scene_;
  const LightTable& lights_;
  PathOptions options_;
  const std::vector<StereoCamera>& rigs_;
  const CacheGrid& grid_;
  uint32_t stream_hash_ = 0;
};

// Square of the mean root, as calm under noise as a mean can be.
float TypicalLuminance(const std::vector<CacheBuilder::Batch>& batches) {
  double sum = 0, count = 0;
  for (const CacheBuilder::Batch& batch : batches) {
    for (const auto& shard : batch.shards) {
      for (const CacheRecord& record : shard) sum += std::sqrt(Luminance(record.radiance));
      count += static_cast<double>(shard.size());
    }
  }
  return count > 0 ? static_cast<float>(sum / count * (sum / count)) : 0.0f;
}

}  // namespace

absl::StatusOr<RadianceCache> FillRadianceCache(const RenderScene& scene, const LightTable& lights,
                                                const PathOptions& options, uint64_t scene_seed,
                                                const std::vector<StereoCamera>& rigs,
                                                const CacheFill& fill, const CancelToken& cancel) {
  if (rigs.empty() || fill.paths <= 0) return RadianceCache();
  Box3f eyes;
  for (const StereoCamera& rig : rigs) {
    for (const PinholeCamera& eye : rig.eyes) eyes.extend(eye.origin.cast<float>().eval());
  }
  const CacheGrid grid(eyes, fill.cell_m);
  Filler filler(scene, lights, options, scene_seed, rigs, grid);
  CacheBuilder builder(grid, fill.max_cells);
  RadianceCache cache;
  float limit = 0;
  int64_t begin = 0;
  for (const double part : kRounds) {
    const auto end = static_cast<int64_t>(part * static_cast<double>(fill.paths));
    filler.UseCache(cache.empty() ? nullptr : &cache);
    std::vector<CacheBuilder::Batch> batches(
        static_cast<size_t>((end - begin + kPathsPerBatch - 1) / kPathsPerBatch));
    tbb::parallel_for(size_t{0}, batches.size(), [&](size_t b) {
      const int64_t first = begin + static_cast<int64_t>(b) * kPathsPerBatch;
      const int64_t last = std::min(end, first + kPathsPerBatch);
      for (int64_t i = first; i < last && !cancel.cancelled(); ++i) {
        filler.Trace(i, limit, &batches[b]);
      }
    });
    if (cancel.cancelled()) return MakeError(absl::StatusCode::kCancelled, "render: cancelled");
    if (begin == 0) {
      limit = kBrightestOverMean * TypicalLuminance(batches);
      for (CacheBuilder::Batch& batch : batches) {
        for (auto& shard : batch.shards) {
          for (CacheRecord& record : shard) Limit(limit, &record);
        }
      }
    }
    builder.Add(batches);
    cache = builder.Freeze(fill.min_records);
    begin = end;
  }
  return cache;
}

}  // namespace parallax
