#include "worker/render/truth/ground_truth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "common/base/status.h"

namespace parallax {
namespace {

constexpr int kMaxHoles = 64;

struct PixelTruth {
  bool surface = false;
  double depth = 0;
  Vec3f normal = Vec3f::Zero();  // Camera frame.
  uint32_t object = 0;
  uint32_t material = 0;
  uint8_t mask = 0;
};

bool IsWater(const MaterialSlot& slot) {
  return !slot.families.empty() && slot.families.front() == "water";
}

class TruthTracer {
 public:
  TruthTracer(const RenderScene& scene, const PinholeCamera& camera)
      : scene_(scene), surroundings_(scene.geometry().surroundings), camera_(camera) {}

  static constexpr int kRun = kLanes;

  // Truths of up to kRun pixels of a row, from x on.
  void At(int x, int y, int count, PixelTruth* truths) const {
    std::array<Vec3d, kRun> in_world;
    std::array<RawHit, kRun> raws;
    Rays8 rays{Vec3x8(camera_.origin.cast<float>()), Vec3x8::Zero()};
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<size_t>(k);
      in_world[i] = camera_.world_from_camera * camera_.DirectionAt(x + k + 0.5, y + 0.5);
      rays.direction.Set(k, in_world[i].normalized().cast<float>());
    }
    Hits8 hits;
    scene_.trees().Intersect(kTree, rays, FirstLanes(count), true, &hits);
    std::array<SurfaceId, kRun> ids;
    HitBatch8 batch{};
    std::array<size_t, kRun> pixel;
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<size_t>(k);
      raws[i] = hits.Get(k);
      const Ray ray{rays.origin.Get(k), rays.direction.Get(k)};
      truths[i] = Look(ray, hits.met[k] != 0, &raws[i], &ids[i]);
      if (!truths[i].surface) continue;
      pixel[static_cast<size_t>(batch.count)] = i;
      batch.Add(raws[i], ids[i], 0);
    }
    if (batch.count == 0) return;
    const Vec3x8 normals = scene_.Interpolate(batch).shading_normal;
    for (int seen = 0; seen < batch.count; ++seen) {
      const size_t i = pixel[static_cast<size_t>(seen)];
      Measure(raws[i], ids[i], normals.Get(seen), in_world[i], &truths[i]);
    }
  }

  void Judge(std::span<Sight> sights) const {
    Rays8 rays{Vec3x8(camera_.origin.cast<float>()), Vec3x8::Zero()};
    for (size_t k = 0; k < sights.size(); ++k) {
      rays.direction.Set(static_cast<int>(k), sights[k].to.normalized().cast<float>());
    }
    Hits8 hits;
    scene_.trees().Intersect(kTree, rays, FirstLanes(static_cast<int>(sights.size())), true, &hits);
    for (size_t k = 0; k < sights.size(); ++k) {
      const auto lane = static_cast<int>(k);
      RawHit raw = hits.Get(lane);
      SurfaceId id;
      const Ray ray{rays.origin.Get(lane), rays.direction.Get(lane)};
      const bool met = Look(ray, hits.met[lane] != 0, &raw, &id).surface;
      const double distance = sights[k].to.norm();
      sights[k].hidden = met && (sights[k].infinite || static_cast<double>(raw.distance) <
                                                           (1 - kOcclusionThreshold) * distance);
    }
  }

 private:
  static constexpr RayTrees::Tree kTree = RayTrees::Tree::kRobust;

  // The surface seen, through holes. `raw`: the first hit, if the ray `met` anything; then the
  // surface's.
  PixelTruth Look(const Ray& ray, bool met, RawHit* raw, SurfaceId* id) const {
    PixelTruth truth;
    const auto spread = static_cast<float>(1.0 / camera_.fx_px);
    for (int hole = 0; hole <= kMaxHoles && met; ++hole) {
      *id = scene_.Identify(*raw);
      const MaterialTraits& traits = scene_.traits(id->material);
      if (traits.may_be_open || traits.may_be_transmissive || traits.may_be_mirror) {
        const SurfaceSample s = scene_.Evaluate(*raw, *id, spread * raw->distance);
        if (s.opacity < 0.5f) {
          const float from = raw->distance + 1e-5f + 2e-6f * raw->distance;
          met = scene_.trees().Intersect(kTree, ray, from, raw);
          continue;
        }
        if (s.transmission * (1.0f - s.metallic) > 0.25f) truth.mask |= kMaskTransparent;
        if (s.metallic >= 0.5f && s.roughness <= 0.1f) truth.mask |= kMaskMirror;
      }
      truth.surface = true;
      return truth;
    }
    truth.mask = kMaskSky;
    return truth;
  }

  void Measure(const RawHit& raw, const SurfaceId& id, const Vec3f& shading_normal,
               const Vec3d& in_world, PixelTruth* measured) const {
    PixelTruth& truth = *measured;
    Vec3f corners[3];
    scene_.Corners(raw.placed, raw.triangle, corners);
    const Vec3d a = corners[0].cast<double>();
    const Vec3d plane = (corners[1].cast<double>() - a).cross(corners[2].cast<double>() - a);
    const double along = plane.dot(in_world);
    truth.depth = along != 0 ? plane.dot(a - camera_.origin) / along : 0;
    // Edge-on, the plane has no usable intersection: use the ray's own distance.
    const double by_ray = raw.distance / in_world.norm();
    if (!(std::abs(truth.depth - by_ray) <= 1e-3 * by_ray)) truth.depth = by_ray;

    const Vec3f out = -in_world.normalized().cast<float>();
    const float side = id.geometric_normal.dot(out) >= 0.0f ? 1.0f : -1.0f;
    Vec3f n = side * shading_normal;
    // At silhouettes of smooth meshes the interpolated normal may face away: bend it perpendicular
    // to the line of sight.
    const float facing = n.dot(out);
    if (facing < 0.0f) n = (n - facing * out).normalized();
    truth.normal = camera_.world_from_camera.transpose().cast<float>() * n;
    if (!truth.normal.allFinite()) {
      truth.normal = camera_.world_from_camera.transpose().cast<float>() * out;
    }
    truth.object = scene_.ObjectIndex(raw.placed);
    truth.material = id.material;
    // Water shows its bed and reflections, though its material is opaque.
    if (IsWater(scene_.MeshOf(raw.placed).slots[id.slot])) {
      truth.mask |= kMaskTransparent | kMaskMirror;
    }
    // A step back towards the viewer: the face of a wall belongs to the side from which it is seen.
    const Vec3f at = raw.position + side * 2e-3f * id.geometric_normal;
    if (surroundings_.IsExterior(at)) truth.mask |= kMaskExterior;
  }

  const RenderScene& scene_;
  const Surroundings& surroundings_;
  const PinholeCamera& camera_;
};

bool Visible(const ImageF& other, int row, double x, double z) {
  if (x < 0 || x >= other.width()) return false;
  const int last = other.width() - 1;
  const double c = x - 0.5;
  const int x0 = std::clamp(static_cast<int>(std::floor(c)), 0, last);
  const int x1 = std::min(x0 + 1, last);
  const auto near = [&](double depth) {
    return depth > 0 && std::abs(depth - z) <= kOcclusionThreshold * z;
  };
  const double d0 = other(x0, row);
  const double d1 = other(x1, row);
  if (near(d0) || near(d1)) return true;
  if (d0 <= 0 || d1 <= 0) return false;
  const double t = std::clamp(c - x0, 0.0, 1.0);
  // Disparity, not depth, is linear along a plane.
  return near(1.0 / ((1.0 - t) / d0 + t / d1));
}

}  // namespace

absl::Status TraceGroundTruth(const RenderScene& scene, const PinholeCamera& camera,
                              double baseline_m, const CancelToken& cancel, View* view) {
  const int width = camera.width_px;
  const int height = camera.height_px;
  view->depth_m = ImageF(width, height);
  view->disparity_px = ImageF(width, height);
  view->objects = ImageU16(width, height);
  view->materials = ImageU16(width, height);
  view->normals = ImageF3(width, height);
  view->masks = ImageU8(width, height);
  const TruthTracer tracer(scene, camera);
  const double focal_times_baseline = camera.fx_px * baseline_m;
  tbb::parallel_for(0, height, [&](int y) {
    if (cancel.cancelled()) return;
    std::array<PixelTruth, TruthTracer::kRun> run;
    for (int x = 0; x < width; ++x) {
      const int k = x % TruthTracer::kRun;
      if (k == 0) tracer.At(x, y, std::min(TruthTracer::kRun, width - x), run.data());
      const PixelTruth& truth = run[static_cast<size_t>(k)];
      view->masks(x, y) = truth.mask;
      if (!truth.surface) continue;
      const auto depth = static_cast<float>(truth.depth);
      view->depth_m(x, y) = depth;
      view->disparity_px(x, y) = static_cast<float>(focal_times_baseline / depth);
      view->objects(x, y) = static_cast<uint16_t>(truth.object);
      view->materials(x, y) = static_cast<uint16_t>(truth.material);
      for (int c = 0; c < 3; ++c) view->normals(x, y, c) = truth.normal[c];
    }
  });
  if (cancel.cancelled()) return Cancelled("render: cancelled");
  return absl::OkStatus();
}

void LookAt(const RenderScene& scene, const PinholeCamera& camera, std::span<Sight> sights) {
  TruthTracer(scene, camera).Judge(sights);
}

void MarkOcclusion(View* left, View* right) {
  const int width = left->depth_m.width();
  const int height = left->depth_m.height();
  View* views[2] = {left, right};
  for (int eye = 0; eye < 2; ++eye) {
    View& view = *views[eye];
    const View& other = *views[1 - eye];
    const double sign = eye == 0 ? -1.0 : 1.0;
    view.occlusion = ImageU8(width, height);
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        const double z = view.depth_m(x, y);
        const bool visible =
            z > 0 ? Visible(other.depth_m, y, x + 0.5 + sign * view.disparity_px(x, y), z)
                  : other.depth_m(x, y) <= 0;
        view.occlusion(x, y) = visible ? 0 : 255;
      }
    });
  }
}

void MarkVeiled(const Haze& haze, const PinholeCamera& camera, View* view) {
  if (haze.clear()) return;
  const Vec3x8 origin(camera.origin.cast<float>());
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; x += kLanes) {
      Vec3x8 to = Vec3x8(Vec3f::UnitZ());
      Float8 depth = Splat(0);
      const int count = std::min(kLanes, camera.width_px - x);
      for (int k = 0; k < count; ++k) {
        const Vec3d along = camera.DirectionAt(x + k + 0.5, y + 0.5);
        to.Set(k, (camera.world_from_camera * along).cast<float>());
        depth[k] = view->depth_m(x + k, y);
      }
      const Float8 length = Norm(to);
      const Float8 passes = haze.Transmittance(origin, to / length, depth * length);
      for (int k = 0; k < count; ++k) {
        if (depth[k] > 0 && passes[k] < 0.05f) view->masks(x + k, y) |= kMaskVeiled;
      }
    }
  });
}

}  // namespace parallax
