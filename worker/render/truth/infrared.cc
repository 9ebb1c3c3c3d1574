#include "worker/render/truth/infrared.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/status.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/film/exposure.h"
#include "worker/render/surface/bsdf.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr int kAcross = 3;             // Samples of a pixel: kAcross^2.
constexpr int kMostSurfaces = 8;       // That a sample follows through glass and mirrors.
constexpr float kLeastWeight = 1e-3f;  // A way that counts less is not followed.
constexpr float kSharp = 0.06f;        // Blur, in radians, of what shows a picture.
constexpr float kFlattest = 0.05f;     // Cosine up to which footprints stretch.

// A sample on its way from the eye.
struct EyePath {
  Ray ray;
  // Sides of its footprint across the ray, for each metre of the way.
  Vec3f across = Vec3f::Zero(), down = Vec3f::Zero();
  float travelled_m = 0;
  float weight = 1;
  Sampler sampler{0, 0, 0, 0};
};

class ProjectorTracer {
 public:
  ProjectorTracer(const RenderScene& scene, const PinholeCamera& camera, const DotPattern& pattern,
                  const Vec3d& origin, uint32_t stream)
      : scene_(scene),
        camera_(camera),
        rays_(camera),
        pattern_(pattern),
        origin_(origin.cast<float>()),
        projector_from_world_(camera.world_from_camera.transpose().cast<float>()),
        stream_(stream) {}

  // Eight pixels of a row, from x on; `count` of them are wanted.
  void Row(int x, int y, int count, float* out) const {
    std::array<float, kLanes> sums{};
    for (int sample = 0; sample < kAcross * kAcross; ++sample) {
      const float u = (static_cast<float>(sample % kAcross) + 0.5f) / kAcross;
      const float v = (static_cast<float>(sample / kAcross) + 0.5f) / kAcross;
      Float8 at_x = Splat(static_cast<float>(x) + u);
      for (int k = 0; k < kLanes; ++k) at_x[k] += static_cast<float>(std::min(k, count - 1));
      const Rays8 rays = rays_.Through(at_x, Splat(static_cast<float>(y) + v));
      Hits8 hits;
      scene_.trees().Intersect(RayTrees::Tree::kFast, rays, FirstLanes(count), true, &hits);
      for (int k = 0; k < count; ++k) {
        if (hits.met[k] == 0) continue;
        const EyePath path = Start(x + k, y, sample, rays.direction.Get(k));
        sums[static_cast<size_t>(k)] += Follow(path, hits.Get(k));
      }
    }
    for (int k = 0; k < count; ++k) out[k] = sums[static_cast<size_t>(k)] / (kAcross * kAcross);
  }

 private:
  EyePath Start(int x, int y, int sample, const Vec3f& direction) const {
    EyePath path;
    path.ray = {rays_.origin(), direction, 0, rays_.spread()};
    // A unit vector turns by the part of a step that is across it, over the step's depth.
    const float depth = direction.dot(projector_from_world_.row(2).transpose());
    const auto side = [&](int axis, double focal_px) {
      const Vec3f step =
          projector_from_world_.row(axis).transpose() / (static_cast<float>(focal_px) * kAcross);
      return Vec3f((step - direction * direction.dot(step)) * depth);
    };
    path.across = side(0, camera_.fx_px);
    path.down = side(1, camera_.fy_px);
    path.sampler = Sampler(stream_, static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                           static_cast<uint32_t>(sample));
    return path;
  }

  // Radiance that comes back along the path, which has met `hit`.
  float Follow(EyePath path, RawHit hit) const {
    float sum = 0;
    for (int surface = 0; surface < kMostSurfaces; ++surface) {
      path.travelled_m += hit.distance;
      const SurfaceId id = scene_.Identify(hit);
      const MaterialTraits& traits = scene_.traits(id.material);
      const SampleFootprint footprint = FootprintOn(path, id.geometric_normal);
      const Vec3f to_projector = origin_ - hit.position;
      const float intensity = pattern_.Intensity(projector_from_world_ * -to_projector, footprint);
      const bool leads_on =
          traits.may_be_open || traits.may_be_transmissive || traits.may_be_mirror;
      if (!(intensity > 0) && !leads_on) return sum;

      HitBatch8 batch{};
      batch.Add(hit, id, path.travelled_m * path.ray.spread);
      const MaterialSample8 eight = scene_.EvaluateMaterial(batch, id.material);
      const SurfaceSample look = eight.surface.Get(0);
      const Vec3f out = -path.ray.direction;
      const bool outside = out.dot(id.geometric_normal) > 0;
      const Vec3f normal = outside ? id.geometric_normal : Vec3f(-id.geometric_normal);
      const ShadingFrame frame(ShadingNormal(eight.shading_normal.Get(0), normal, out, outside));
      const Bsdf bsdf(look, frame.ToLocal(out), outside);
      const float opacity = std::clamp(look.opacity, 0.0f, 1.0f);
      if (intensity > 0) {
        sum += path.weight * opacity * intensity *
               Scattered(bsdf, frame, hit.position, normal, to_projector);
      }
      if (!leads_on || !GoOn(look, bsdf, frame, normal, opacity, hit.position, &path)) return sum;
      if (!scene_.trees().Intersect(RayTrees::Tree::kFast, path.ray, 0, &hit)) return sum;
    }
    return sum;
  }

  static SampleFootprint FootprintOn(const EyePath& path, const Vec3f& normal) {
    const Vec3f& direction = path.ray.direction;
    float facing = direction.dot(normal);
    if (std::abs(facing) < kFlattest) facing = std::copysign(kFlattest, facing);
    const auto laid = [&](const Vec3f& side) {
      const Vec3f there = side * path.travelled_m;
      return Vec3f(there - direction * (there.dot(normal) / facing));
    };
    return {laid(path.across), laid(path.down)};
  }

  // On the viewer's side; where a smooth mesh's turns away from the viewer, the true one.
  static Vec3f ShadingNormal(const Vec3f& shading, const Vec3f& normal, const Vec3f& out,
                             bool outside) {
    const Vec3f turned = outside ? shading : Vec3f(-shading);
    return turned.dot(out) > 1e-3f ? turned : normal;
  }

  // Infrared radiance for an intensity of 1 W/sr.
  float Scattered(const Bsdf& bsdf, const ShadingFrame& frame, const Vec3f& position,
                  const Vec3f& normal, const Vec3f& to_projector) const {
    const float distance = to_projector.norm();
    if (!(distance > 1e-3f)) return 0;
    const Vec3f way = to_projector / distance;
    const Vec3f local = frame.ToLocal(way);
    const bool above = way.dot(normal) > 0;
    if ((local.z() > 0) != above) return 0;  // The true and the bent surface differ.
    const Vec3f f_cos = bsdf.Evaluate(local).f_cos;
    if (IsBlack(f_cos) || !f_cos.allFinite()) return 0;
    const Vec3f from = OffsetPoint(position, above ? normal : Vec3f(-normal));
    const Vec3f passes = scene_.Transmittance(from, way, distance * (1 - 1e-5f));
    return InfraredOf(f_cos.cwiseProduct(passes)) / Square(distance);
  }

  // Sends the path on through a hole, a pane or by a mirror; false: it ends here. The surface's own
  // light was weighted by its opacity; what lies behind is seen with the chance that is left.
  bool GoOn(const SurfaceSample& look, const Bsdf& bsdf, const ShadingFrame& frame,
            const Vec3f& normal, float opacity, const Vec3f& position, EyePath* path) const {
    if (opacity < 1 && path->sampler.Pair().x() >= opacity) {
      path->ray.origin = OffsetPoint(position, -normal);
      return true;
    }
    const bool mirror = look.metallic >= 0.4f && look.roughness <= 0.15f;
    if (!mirror && !(look.transmission * (1 - look.metallic) > 0)) return false;
    const float lobe = path->sampler.Pair().x();
    const auto next = bsdf.Sample(lobe, path->sampler.Pair());
    if (!next || (!next->straight && next->blur > kSharp)) return false;
    path->weight *= InfraredOf(next->weight);
    if (!(path->weight > kLeastWeight) || !std::isfinite(path->weight)) return false;
    const Vec3f direction = next->straight ? path->ray.direction : frame.ToWorld(next->direction);
    const Eigen::Quaternionf turn =
        Eigen::Quaternionf::FromTwoVectors(path->ray.direction, direction);
    path->across = turn * path->across;
    path->down = turn * path->down;
    const bool back = direction.dot(normal) > 0;
    path->ray.origin = OffsetPoint(position, back ? normal : Vec3f(-normal));
    path->ray.direction = direction;
    return true;
  }

  const RenderScene& scene_;
  const PinholeCamera& camera_;
  const CameraRays rays_;
  const DotPattern& pattern_;
  const Vec3f origin_;
  const Mat3f projector_from_world_;
  const uint32_t stream_;
};

// The room's light and the projector's, as automatic exposure takes pictures: in three channels, at
// the level of the room's visible light.
ImageF3 InfraredLight(const ImageF3& radiance, const ImageF& projector) {
  ImageF3 light(radiance.width(), radiance.height());
  for (size_t i = 0; i < radiance.pixels(); ++i) {
    const float* rgb = &radiance.values()[3 * i];
    float value = InfraredOf(Vec3f(rgb[0], rgb[1], rgb[2]));
    if (!projector.empty()) value += projector.values()[i] / kAmbientInfrared;
    std::fill_n(&light.values()[3 * i], 3, value);
  }
  return light;
}

ImageU8 ToGrey(const ImageF3& light, float exposure) {
  ImageU8 grey(light.width(), light.height());
  for (size_t i = 0; i < grey.pixels(); ++i) {
    grey.values()[i] = static_cast<uint8_t>(DisplayLevel(light.values()[3 * i] * exposure) + 0.5f);
  }
  return grey;
}

}  // namespace

absl::StatusOr<ImageF> TraceProjector(const RenderScene& scene, const PinholeCamera& camera,
                                      const DotPattern& pattern, const Vec3d& origin,
                                      const SampleStream& stream, const CancelToken& cancel) {
  ImageF radiance(camera.width_px, camera.height_px);
  const ProjectorTracer tracer(scene, camera, pattern, origin, stream.Hash());
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    if (cancel.cancelled()) return;
    for (int x = 0; x < camera.width_px; x += kLanes) {
      tracer.Row(x, y, std::min(kLanes, camera.width_px - x), radiance.At(x, y));
    }
  });
  if (cancel.cancelled()) return Cancelled("render: cancelled");
  return radiance;
}

absl::Status RenderInfrared(const RenderScene& scene, const StereoCamera& stereo,
                            const v1::Rig& rig, const SampleStream streams[2], bool by_left,
                            const CancelToken& cancel, StereoFrame* frame) {
  View* views[2] = {&frame->left, &frame->right};
  ImageF projector[2];
  if (rig.has_projector() && rig.projector().power_w() > 0) {
    ASSIGN_OR_RETURN(const DotPattern pattern, DotPattern::Make(rig.projector()));
    const PinholeCamera& left = stereo.eyes[0];
    const Vec3d origin = left.origin + rig.projector().place_m() * left.world_from_camera.col(0);
    for (int eye = 0; eye < 2; ++eye) {
      ASSIGN_OR_RETURN(projector[eye], TraceProjector(scene, stereo.eyes[eye], pattern, origin,
                                                      streams[eye], cancel));
    }
  }
  ImageF3 light[2];
  for (int eye = 0; eye < 2; ++eye) {
    light[eye] = InfraredLight(views[eye]->radiance, projector[eye]);
  }
  frame->infrared_exposure = AutomaticExposure(light[0], light[by_left ? 0 : 1]);
  for (int eye = 0; eye < 2; ++eye) {
    views[eye]->infrared = ToGrey(light[eye], frame->infrared_exposure);
  }
  return absl::OkStatus();
}

}  // namespace parallax
