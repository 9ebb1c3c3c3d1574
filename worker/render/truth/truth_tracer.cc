#include "worker/render/truth/truth_tracer.h"

namespace parallax {
namespace {

constexpr int kMaxHoles = 64;

bool IsWater(const MaterialSlot& slot) {
  return !slot.families.empty() && slot.families.front() == "water";
}

// The distance from which on a ray meets what is behind a hit.
float Beyond(const RawHit& raw) { return raw.distance + 1e-5f + 2e-6f * raw.distance; }

}  // namespace

void TruthTracer::At(int x, int y, int count, PixelTruth* truths,
                     std::array<SurfaceHit, kRun>* hits) const {
  Rays8 rays{Vec3x8(camera_.origin.cast<float>()), Vec3x8::Zero()};
  for (int k = 0; k < count; ++k) {
    SurfaceHit& hit = (*hits)[static_cast<size_t>(k)];
    hit.in_world = camera_.world_from_camera * camera_.DirectionAt(x + k + 0.5, y + 0.5);
    rays.direction.Set(k, hit.in_world.normalized().cast<float>());
  }
  Hits8 met;
  scene_.trees().Intersect(kTree, rays, FirstLanes(count), true, &met);
  HitBatch8 batch{};
  std::array<size_t, kRun> pixel;
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<size_t>(k);
    SurfaceHit& hit = (*hits)[i];
    hit.raw = met.Get(k);
    hit.ray = {rays.origin.Get(k), rays.direction.Get(k)};
    truths[i] = Look(hit.ray, met.met[k] != 0, &hit.raw, &hit.id);
    if (!truths[i].surface) continue;
    pixel[static_cast<size_t>(batch.count)] = i;
    batch.Add(hit.raw, hit.id, 0);
  }
  if (batch.count == 0) return;
  const Vec3x8 normals = scene_.Interpolate(batch).shading_normal;
  for (int seen = 0; seen < batch.count; ++seen) {
    const size_t i = pixel[static_cast<size_t>(seen)];
    truths[i].normal = NormalOf((*hits)[i], normals.Get(seen));
    Measure((*hits)[i], &truths[i]);
  }
}

PixelTruth TruthTracer::Behind(SurfaceHit* hit) const {
  const bool met = scene_.trees().Intersect(kTree, hit->ray, Beyond(hit->raw), &hit->raw);
  PixelTruth truth = Look(hit->ray, met, &hit->raw, &hit->id);
  if (truth.surface) Measure(*hit, &truth);
  return truth;
}

void TruthTracer::Judge(std::span<Sight> sights) const {
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

PixelTruth TruthTracer::Look(const Ray& ray, bool met, RawHit* raw, SurfaceId* id) const {
  PixelTruth truth;
  const auto spread = static_cast<float>(1.0 / camera_.fx_px);
  for (int hole = 0; hole <= kMaxHoles && met; ++hole) {
    *id = scene_.Identify(*raw);
    const MaterialTraits& traits = scene_.traits(id->material);
    if (traits.may_be_open || traits.may_be_transmissive || traits.may_be_mirror) {
      const SurfaceSample s = scene_.Evaluate(*raw, *id, spread * raw->distance);
      if (s.opacity < 0.5f) {
        met = scene_.trees().Intersect(kTree, ray, Beyond(*raw), raw);
        continue;
      }
      if (s.transmission * (1.0f - s.metallic) > 0.25f) {
        truth.mask |= kMaskTransparent;
        truth.clear = s.thin_walled ? Clearness::kThinGlass : Clearness::kSolidGlass;
      }
      if (s.metallic >= 0.5f && s.roughness <= 0.1f) truth.mask |= kMaskMirror;
    }
    truth.surface = true;
    return truth;
  }
  truth.mask = kMaskSky;
  return truth;
}

Vec3f TruthTracer::NormalOf(const SurfaceHit& hit, const Vec3f& shading_normal) const {
  const Vec3f out = -hit.in_world.normalized().cast<float>();
  const float side = hit.id.geometric_normal.dot(out) >= 0.0f ? 1.0f : -1.0f;
  Vec3f n = side * shading_normal;
  // At silhouettes of smooth meshes the interpolated normal may face away: bend it perpendicular
  // to the line of sight.
  const float facing = n.dot(out);
  if (facing < 0.0f) n = (n - facing * out).normalized();
  const Vec3f normal = camera_.world_from_camera.transpose().cast<float>() * n;
  if (normal.allFinite()) return normal;
  return camera_.world_from_camera.transpose().cast<float>() * out;
}

void TruthTracer::Measure(const SurfaceHit& hit, PixelTruth* measured) const {
  PixelTruth& truth = *measured;
  const RawHit& raw = hit.raw;
  Vec3f corners[3];
  scene_.Corners(raw.placed, raw.triangle, corners);
  const Vec3d a = corners[0].cast<double>();
  const Vec3d plane = (corners[1].cast<double>() - a).cross(corners[2].cast<double>() - a);
  const double along = plane.dot(hit.in_world);
  truth.depth = along != 0 ? plane.dot(a - camera_.origin) / along : 0;
  // Edge-on, the plane has no usable intersection: use the ray's own distance.
  const double by_ray = raw.distance / hit.in_world.norm();
  if (!(std::abs(truth.depth - by_ray) <= 1e-3 * by_ray)) truth.depth = by_ray;
  truth.object = scene_.ObjectIndex(raw.placed);
  truth.material = hit.id.material;
  // Water shows its bed and reflections, though its material is opaque.
  if (IsWater(scene_.MeshOf(raw.placed).slots[hit.id.slot])) {
    truth.mask |= kMaskTransparent | kMaskMirror;
    truth.clear = Clearness::kWater;
  }
  const Vec3f out = -hit.in_world.normalized().cast<float>();
  const float side = hit.id.geometric_normal.dot(out) >= 0.0f ? 1.0f : -1.0f;
  // A step back towards the viewer: the face of a wall belongs to the side from which it is seen.
  const Vec3f at = raw.position + side * 2e-3f * hit.id.geometric_normal;
  if (surroundings_.IsExterior(at)) truth.mask |= kMaskExterior;
}

}  // namespace parallax
