#include "worker/render/paths/volume_fill.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "common/base/status.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr int64_t kLooksPerBatch = 2048;
constexpr int64_t kLooksPerRound = 1 << 18;  // Bounds the memory of records on their way to cells.
constexpr uint32_t kDirections = 4;          // Records of a look.
constexpr float kRows = 48;                  // Rows of a picture, by which looks are sorted.
constexpr size_t kMetTogether = PathTracer::kTogether / kDirections;
// Shares of all looks after which the volume is renewed; the first run without it.
constexpr double kRenewals[] = {0.04, 0.15, 0.4, 1.0};
// Light that was scattered often is in the first records too: all count alike in the end.
constexpr int kFirstBounces = 32;
constexpr float kSpread = 0.3f;                  // Angle of a record's ray cones, radians.
constexpr float kBrightestOverTypical = 64;      // Rare light above this multiple is cut.
constexpr uint32_t kLookPass = 6, kRayPass = 7;  // SampleStream.pass.

// A place that a look met.
struct Met {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();  // On the look's side.
  bool sheet = false;
  uint64_t place = 0;   // PlaceCode.
  uint64_t cell = 0;    // VolumeBuilder::KeyAt.
  uint32_t number = 0;  // Among the looks that met the cell.
};

// Returns the number of a position along a Z-curve through cubes of a quarter of a metre: close
// positions have close numbers.
uint64_t PlaceCode(const Vec3f& position) {
  uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    auto x =
        static_cast<uint64_t>(static_cast<int64_t>(std::floor(4 * position[axis])) + (1 << 20));
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    x = (x | x << 2) & 0x1249249249249249;
    code |= x << axis;
  }
  return code;
}

struct CellLooks {
  uint64_t key = 0;
  uint32_t count = 0;
};

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

  // Returns what looks [begin, end) meet, along PlaceCode: neighbours, which meet the same parts of
  // the scene's trees, are to be traced together. Only `number` is not set.
  std::vector<Met> Look(int64_t begin, int64_t end, const VolumeBuilder& builder) const {
    std::vector<std::vector<Met>> met(2 * rigs_.size());
    tbb::parallel_for(size_t{0}, met.size(), [&](size_t view) {
      // View v has the looks v, v + views, v + 2 views...
      const auto before = [&](int64_t looks) {
        return (looks + static_cast<int64_t>(met.size() - 1 - view)) /
               static_cast<int64_t>(met.size());
      };
      met[view] = LookFrom(view, before(begin), before(end));
      for (Met& at : met[view]) {
        at.cell = builder.KeyAt(at.position);
        at.place = PlaceCode(at.position);
      }
    });
    std::vector<Met> all;
    for (const auto& of_view : met) all.insert(all.end(), of_view.begin(), of_view.end());
    std::stable_sort(all.begin(), all.end(),
                     [](const Met& a, const Met& b) { return a.place < b.place; });
    return all;
  }

  // Appends the records of at most kMetTogether places.
  void Trace(PathTracer* tracer, std::span<const Met> met,
             std::vector<VolumeRecord>* records) const {
    std::vector<Path> paths;
    for (const Met& at : met) {
      for (uint32_t d = 0; d < kDirections; ++d) {
        Path& path = paths.emplace_back(
            Sampler(CombineHash(ray_hash_, static_cast<uint32_t>(at.cell)),
                    static_cast<uint32_t>(at.cell >> 32), 0, at.number * kDirections + d));
        const Vec2f u = path.sampler.Pair();
        path.ray.direction = DirectionAt(1 - 2 * u.x(), 2 * kPi * u.y());
        // A sheet receives from both sides; other surfaces are what the air before them sees.
        const bool behind = at.sheet && path.ray.direction.dot(at.normal) < 0;
        path.ray.origin = OffsetPoint(at.position, behind ? Vec3f(-at.normal) : at.normal);
        path.ray.spread = kSpread;
        path.lights_sampled = true;
      }
    }
    tracer->Trace(paths);
    for (size_t i = 0; i < paths.size(); ++i) {
      const Vec3f& radiance = paths[i].result.radiance;
      records->push_back({met[i / kDirections].position, paths[i].ray.direction,
                          radiance.allFinite() ? radiance : Vec3f::Zero()});
    }
  }

 private:
  // Returns what looks [first, last) of a view meet.
  std::vector<Met> LookFrom(size_t view, int64_t first, int64_t last) const {
    const PinholeCamera& camera = rigs_[view / 2].eyes[view % 2];
    std::vector<Vec2f> points;
    for (int64_t sample = first; sample < last; ++sample) {
      points.push_back(
          Sampler(look_hash_, static_cast<uint32_t>(view), 0, static_cast<uint32_t>(sample))
              .Pair());
    }
    // Neighbours in the picture are traced together, row by row.
    std::sort(points.begin(), points.end(), [](const Vec2f& a, const Vec2f& b) {
      const float row_a = std::floor(kRows * a.y()), row_b = std::floor(kRows * b.y());
      return row_a != row_b ? row_a < row_b : a.x() < b.x();
    });
    std::vector<Met> met;
    for (size_t i = 0; i < points.size(); i += kLanes) {
      LookEight(camera, std::span(points).subspan(i, std::min<size_t>(kLanes, points.size() - i)),
                &met);
    }
    return met;
  }

  void LookEight(const PinholeCamera& camera, std::span<const Vec2f> points,
                 std::vector<Met>* met) const {
    const CameraRays through(camera);
    const auto count = static_cast<int>(points.size());
    Rays8 rays;
    for (int k = 0; k < kLanes; ++k) {
      const Vec2f& at = points[static_cast<size_t>(std::min(k, count - 1))];
      const Ray ray = through.Through(at.x() * static_cast<float>(camera.width_px),
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
      Met& at = met->emplace_back();
      at.position = hits.position.Get(k);
      at.normal = ids.geometric_normal.Get(k);
      if (at.normal.dot(rays.direction.Get(k)) > 0) at.normal = -at.normal;
      at.sheet = scene_.cache_group(static_cast<uint32_t>(hits.placed[k]))
                     .Sheet(static_cast<uint16_t>(ids.slot[k]));
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
  CellTable<CellLooks> cell_looks(fill.max_cells);
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
      std::vector<Met> all = filler.Look(begin, end, builder);
      // The rays of a cell are points of one sequence, so that they cover all directions evenly.
      for (Met& at : all) {
        CellLooks* looks = cell_looks.Get(at.cell);
        at.number = looks ? looks->count++ : 0;
      }
      std::vector<std::vector<VolumeRecord>> records(count);
      tbb::parallel_for(size_t{0}, count, [&](size_t b) {
        const size_t last = std::min(all.size(), (b + 1) * kLooksPerBatch);
        for (size_t i = b * kLooksPerBatch; i < last && !cancel.cancelled(); i += kMetTogether) {
          filler.Trace(&tracers.local(),
                       std::span(all).subspan(i, std::min(kMetTogether, last - i)), &records[b]);
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
