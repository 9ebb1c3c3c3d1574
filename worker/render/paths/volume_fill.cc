#include "worker/render/paths/volume_fill.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "common/base/status.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr int64_t kLooksPerBatch = 2048;
constexpr int64_t kLooksPerRound = 1 << 18;  // Bounds the memory of records on their way to cells.
constexpr int kDirections = 4;               // Records of a look.
constexpr int64_t kLooksTogether = PathTracer::kTogether / kDirections;
// Shares of all looks after which the volume is renewed; the first run without it.
constexpr double kRenewals[] = {0.1, 0.25, 0.5, 1.0};
// Light that was scattered often is in the first records too: all count alike in the end.
constexpr int kFirstBounces = 32;
constexpr float kSpread = 0.3f;                  // Angle of a record's ray cones, radians.
constexpr float kBrightestOverTypical = 64;      // Rare light above this multiple is cut.
constexpr uint32_t kLookPass = 6, kRayPass = 7;  // SampleStream.pass.

class VolumeFiller {
 public:
  VolumeFiller(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
               uint64_t scene_seed, const std::vector<StereoCamera>& rigs)
      : scene_(scene),
        lights_(lights),
        options_(options),
        rigs_(rigs),
        look_hash_(SampleStream{scene_seed, 0, 0, kLookPass}.Hash()),
        ray_hash_(SampleStream{scene_seed, 0, 0, kRayPass}.Hash()) {
    options_.clamp_luminance = 0;
    options_.cache = nullptr;
  }

  // A null volume: paths are traced.
  void UseVolume(const IrradianceVolume* volume, int max_bounces) {
    options_.volume = volume;
    options_.max_bounces = max_bounces;
  }
  PathTracer Tracer() const { return PathTracer(scene_, lights_, options_); }

  // Appends the records of looks [first, last), at most kLooksTogether.
  void Trace(PathTracer* tracer, int64_t first, int64_t last,
             std::vector<VolumeRecord>* records) const {
    const size_t before = records->size();
    std::vector<Path> paths;
    for (int64_t begin = first; begin < last; begin += kLanes) {
      Look(begin, static_cast<int>(std::min<int64_t>(kLanes, last - begin)), &paths, records);
    }
    tracer->Trace(paths);
    for (size_t i = 0; i < paths.size(); ++i) {
      Vec3f& radiance = (*records)[before + i].radiance;
      radiance = paths[i].result.radiance;
      if (!radiance.allFinite()) radiance.setZero();
    }
  }

 private:
  // Starts the rays of up to eight looks, and a record for each.
  void Look(int64_t begin, int count, std::vector<Path>* paths,
            std::vector<VolumeRecord>* records) const {
    const auto views = static_cast<int64_t>(2 * rigs_.size());
    Rays8 rays;
    for (int k = 0; k < kLanes; ++k) {
      const int64_t index = begin + std::min(k, count - 1);
      const auto view = static_cast<size_t>(index % views);
      const PinholeCamera& camera = rigs_[view / 2].eyes[view % 2];
      Sampler sampler(look_hash_, static_cast<uint32_t>(view), 0,
                      static_cast<uint32_t>(index / views));
      const Vec2f at = sampler.Pair();
      const Ray ray = CameraRays(camera).Through(at.x() * static_cast<float>(camera.width_px),
                                                 at.y() * static_cast<float>(camera.height_px));
      rays.origin.Set(k, ray.origin);
      rays.direction.Set(k, ray.direction);
    }
    Hits8 hits;
    scene_.trees().Intersect(RayTrees::Tree::kFast, rays, FirstLanes(count), /*coherent=*/false,
                             &hits);
    const SurfaceIds8 ids = scene_.Identify(hits);
    for (int k = 0; k < count; ++k) {
      if (hits.met[k] == 0) continue;
      Vec3f normal = ids.geometric_normal.Get(k);
      if (normal.dot(rays.direction.Get(k)) > 0) normal = -normal;
      const Vec3f position = hits.position.Get(k);
      const bool sheet = scene_.cache_group(static_cast<uint32_t>(hits.placed[k]))
                             .Sheet(static_cast<uint16_t>(ids.slot[k]));
      for (int d = 0; d < kDirections; ++d) {
        Path& path = paths->emplace_back(
            Sampler(ray_hash_, 0, 0, static_cast<uint32_t>((begin + k) * kDirections + d)));
        const Vec2f u = path.sampler.Pair();
        path.ray.direction = DirectionAt(1 - 2 * u.x(), 2 * kPi * u.y());
        // A sheet receives from both sides; other surfaces are what the air before them sees.
        const bool behind = sheet && path.ray.direction.dot(normal) < 0;
        path.ray.origin = OffsetPoint(position, behind ? Vec3f(-normal) : normal);
        path.ray.spread = kSpread;
        path.lights_sampled = true;
        records->push_back({position, path.ray.direction, Vec3f::Zero()});
      }
    }
  }

  const RenderScene& scene_;
  const LightTable& lights_;
  PathOptions options_;
  const std::vector<StereoCamera>& rigs_;
  const uint32_t look_hash_, ray_hash_;
};

// Square of the mean square root, which is robust to noise.
float TypicalLuminance(const std::vector<std::vector<VolumeRecord>>& batches) {
  double sum = 0, count = 0;
  for (const auto& records : batches) {
    for (const VolumeRecord& record : records) {
      sum += std::sqrt(std::max(Luminance(record.radiance), 0.0f));
    }
    count += static_cast<double>(records.size());
  }
  return count > 0 ? static_cast<float>(sum / count * (sum / count)) : 0.0f;
}

}  // namespace

absl::StatusOr<IrradianceVolume> FillIrradianceVolume(
    const RenderScene& scene, const LightTable& lights, const PathOptions& options,
    uint64_t scene_seed, const std::vector<StereoCamera>& rigs, const VolumeFill& fill,
    const CancelToken& cancel) {
  if (rigs.empty() || fill.looks <= 0) return IrradianceVolume();
  Box3f eyes;
  for (const StereoCamera& rig : rigs) {
    for (const PinholeCamera& eye : rig.eyes) eyes.extend(eye.origin.cast<float>().eval());
  }
  VolumeFiller filler(scene, lights, options, scene_seed, rigs);
  VolumeBuilder builder(CacheGrid(eyes, fill.cell_m), fill.max_cells);
  IrradianceVolume volume;
  float limit = 0;
  int64_t begin = 0;
  for (const double part : kRenewals) {
    const auto renewal = static_cast<int64_t>(part * static_cast<double>(fill.looks));
    filler.UseVolume(volume.empty() ? nullptr : &volume,
                     volume.empty() ? kFirstBounces : options.max_bounces);
    tbb::enumerable_thread_specific<PathTracer> tracers([&] { return filler.Tracer(); });
    while (begin < renewal) {
      const int64_t end = std::min(renewal, begin + kLooksPerRound);
      const auto count = static_cast<size_t>((end - begin + kLooksPerBatch - 1) / kLooksPerBatch);
      std::vector<std::vector<VolumeRecord>> records(count);
      tbb::parallel_for(size_t{0}, count, [&](size_t b) {
        const int64_t first = begin + static_cast<int64_t>(b) * kLooksPerBatch;
        const int64_t last = std::min(end, first + kLooksPerBatch);
        for (int64_t i = first; i < last && !cancel.cancelled(); i += kLooksTogether) {
          filler.Trace(&tracers.local(), i, std::min(i + kLooksTogether, last), &records[b]);
        }
      });
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      if (limit <= 0) limit = kBrightestOverTypical * TypicalLuminance(records);
      std::vector<VolumeBuilder::Batch> batches(count);
      tbb::parallel_for(size_t{0}, count, [&](size_t b) {
        for (VolumeRecord& record : records[b]) {
          const float luminance = Luminance(record.radiance);
          if (limit > 0 && luminance > limit) record.radiance *= limit / luminance;
          builder.Put(record, &batches[b]);
        }
      });
      builder.Add(batches);
      begin = end;
    }
    volume = builder.Freeze();
  }
  return volume;
}

}  // namespace parallax
