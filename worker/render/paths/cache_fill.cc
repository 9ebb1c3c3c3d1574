#include "worker/render/paths/cache_fill.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "common/base/status.h"
#include "worker/render/camera/camera_rays.h"

namespace parallax {
namespace {

constexpr int64_t kPathsPerBatch = 2048;
constexpr int64_t kTogether = PathTracer::kTogether;
// Shares of all paths after which the cache is renewed; the first paths run without it.
constexpr double kRounds[] = {0.1, 0.25, 0.5, 1.0};
// In dark rooms, light scattered many times matters, and such paths are few.
constexpr int kFewestBounces = 32;
constexpr int kRegion = 12;               // Cells across a region: 0.7 m near the rigs.
constexpr uint32_t kFillPass = 2;         // SampleStream.pass.
constexpr float kBrightestOverMean = 64;  // Rare light above this multiple is clamped.

class Filler {
 public:
  Filler(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
         uint64_t scene_seed, const std::vector<StereoCamera>& rigs, const CacheGrid& grid)
      : scene_(scene), lights_(lights), options_(options), rigs_(rigs), grid_(grid) {
    options_.clamp_luminance = 0;
    options_.cache_from = 2;
    options_.max_bounces = std::max(options_.max_bounces, kFewestBounces);
    stream_hash_ = SampleStream{scene_seed, 0, 0, kFillPass}.Hash();
  }

  void UseCache(const RadianceCache* cache) { options_.cache = cache; }
  PathTracer Tracer() const { return PathTracer(scene_, lights_, options_); }

  // Adds the records of the paths with these indices. `limit`: luminance above which light is
  // clamped; 0 = none.
  void Trace(PathTracer* tracer, int64_t first, int64_t last, float limit,
             CacheBuilder::Batch* batch, std::vector<LightTrial>* trials,
             std::vector<LightSeen>* seen) const {
    std::vector<PathTrail> trails(static_cast<size_t>(last - first));
    std::vector<Path> paths;
    for (int64_t i = first; i < last; ++i) {
      paths.push_back(Start(i));
      paths.back().trail = &trails[static_cast<size_t>(i - first)];
    }
    tracer->Trace(paths);
    for (const Path& path : paths) {
      Learn(path, limit, batch, seen);
      for (int k = 0; k < path.trail->size; ++k) {
        const LightTrial& trial = path.trail->vertices[static_cast<size_t>(k)].trial;
        if (trial.room >= 0) trials->push_back(trial);
      }
    }
  }

 private:
  Path Start(int64_t index) const {
    const auto views = static_cast<int64_t>(2 * rigs_.size());
    const auto view = static_cast<size_t>(index % views);
    const PinholeCamera& camera = rigs_[view / 2].eyes[view % 2];
    Path path(Sampler(stream_hash_, static_cast<uint32_t>(view), 0,
                      static_cast<uint32_t>(index / views)));
    const Vec2f at = path.sampler.Pair();
    path.ray = CameraRays(camera).Through(at.x() * static_cast<float>(camera.width_px),
                                          at.y() * static_cast<float>(camera.height_px));
    return path;
  }

  void Learn(const Path& path, float limit, CacheBuilder::Batch* batch,
             std::vector<LightSeen>* seen) const {
    for (int k = 0; k < path.trail->size; ++k) {
      const PathVertex& vertex = path.trail->vertices[static_cast<size_t>(k)];
      if (!(vertex.throughput.minCoeff() > 0.0f)) continue;
      CacheRecord record;
      record.rough = vertex.rough;
      record.radiance = (path.result.radiance - vertex.before).cwiseQuotient(vertex.throughput);
      if (!record.radiance.allFinite()) continue;
      record.radiance = record.radiance.cwiseMax(0.0f);
      seen->push_back({vertex.place.position, vertex.place.normal, Luminance(record.radiance)});
      if (limit > 0.0f) record.Cut(limit);
      const float width_m = grid_.WidthOf(vertex.place);
      record.key = CacheGrid::KeyOf(vertex.place, width_m);
      record.region = CacheGrid::KeyOf(vertex.place, kRegion * width_m);
      batch->Add(record);
    }
  }

  const RenderScene& scene_;
  const LightTable& lights_;
  PathOptions options_;
  const std::vector<StereoCamera>& rigs_;
  const CacheGrid& grid_;
  uint32_t stream_hash_ = 0;
};

// Square of the mean square root, which is robust to noise.
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

absl::StatusOr<RadianceCache> FillRadianceCache(const RenderScene& scene, LightTable* lights,
                                                const PathOptions& options, uint64_t scene_seed,
                                                const std::vector<StereoCamera>& rigs,
                                                const CacheFill& fill, const CancelToken& cancel) {
  if (rigs.empty() || fill.paths <= 0) return RadianceCache();
  Box3f eyes;
  for (const StereoCamera& rig : rigs) {
    for (const PinholeCamera& eye : rig.eyes) eyes.extend(eye.origin.cast<float>().eval());
  }
  ForgetLights(lights);  // Trials of a cancelled fill.
  const CacheGrid grid(eyes, fill.cell_m);
  Filler filler(scene, *lights, options, scene_seed, rigs, grid);
  CacheBuilder builder(grid, fill.max_cells);
  RadianceCache cache;
  float limit = 0;
  int64_t begin = 0;
  for (const double part : kRounds) {
    const auto end = static_cast<int64_t>(part * static_cast<double>(fill.paths));
    filler.UseCache(cache.empty() ? nullptr : &cache);
    std::vector<CacheBuilder::Batch> batches(
        static_cast<size_t>((end - begin + kPathsPerBatch - 1) / kPathsPerBatch));
    std::vector<std::vector<LightTrial>> trials(batches.size());
    std::vector<std::vector<LightSeen>> seen(batches.size());
    tbb::enumerable_thread_specific<PathTracer> tracers([&] { return filler.Tracer(); });
    tbb::parallel_for(size_t{0}, batches.size(), [&](size_t b) {
      const int64_t first = begin + static_cast<int64_t>(b) * kPathsPerBatch;
      const int64_t last = std::min(end, first + kPathsPerBatch);
      for (int64_t i = first; i < last && !cancel.cancelled(); i += kTogether) {
        filler.Trace(&tracers.local(), i, std::min(i + kTogether, last), limit, &batches[b],
                     &trials[b], &seen[b]);
      }
    });
    if (cancel.cancelled()) return Cancelled("render: cancelled");
    if (begin == 0) {
      limit = kBrightestOverMean * TypicalLuminance(batches);
      for (CacheBuilder::Batch& batch : batches) {
        for (auto& shard : batch.shards) {
          for (CacheRecord& record : shard) record.Cut(limit);
        }
      }
    }
    builder.Add(batches);
    LearnGains(trials, lights);
    LearnSpots(seen, lights);
    cache = builder.Freeze(fill.min_records);
    begin = end;
  }
  return cache;
}

}  // namespace parallax
