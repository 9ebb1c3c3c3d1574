#include "worker/render/path_tracer.h"

#include "worker/render/bsdf.h"

namespace parallax {
namespace {

constexpr int kMaxPassages = 32;  // Holes and thin panes that a path may pass.
constexpr int kGuideBounces = 3;  // Mirrors that the denoiser's guides follow.
constexpr float kGlintWeight = 0.02f;
constexpr int kRouletteFrom = 2;  // First bounce that may end by chance.

// The shading normal on the viewer's side, bent just enough that the mirror direction does not dip
// below the surface (which would turn glossy relief black).
Vec3f UsableNormal(const Vec3f& shading, const Vec3f& geometric, const Vec3f& out) {
  Vec3f n = shading;
  const float facing = n.dot(out);
  if (facing < 0.01f) n = (n + out * (0.01f - facing) * 1.02f).normalized();
  const Vec3f mirrored = 2.0f * n.dot(out) * n - out;
  const float height = mirrored.dot(geometric);
  if (height < 0.01f) {
    const Vec3f lifted = (mirrored + geometric * (0.01f - height)).normalized();
    const Vec3f bisector = (lifted + out).normalized();
    if (bisector.dot(out) > 0.0f) n = bisector;
  }
  return n;
}

// Where a smooth mesh's face is lit from near its true horizon: rises from 0 to 1 within half the
// angle (its sine squared is `bend2`) by which the shading normal leans away from the true one. So
// coarse faces cast no hard edge, and little light is lost: a factor that reaches further down to
// the face (Chiang et al. 2019) took 0.7 % of a room's.
float TerminatorFactor(float true_cosine, float bend2) {
  if (4.0f * true_cosine * true_cosine >= bend2) return 1.0f;
  const float t = 2.0f * true_cosine / std::sqrt(bend2);
  return t * t * (3.0f - 2.0f * t);
}

Vec3f Clamped(const Vec3f& contribution, float limit) {
  if (limit <= 0.0f) return contribution;
  const float luminance = Luminance(contribution);
  return luminance > limit ? Vec3f(contribution * (limit / luminance)) : contribution;
}

// Part of the sampled light that arrives at `position`; the shadow ray leaves from `start`, clear
// of the surface. It is aimed anew at the light's point and ends clear of that: the start is nearer
// to the light by more than a fixed part of a short way, and the light would shade itself.
Vec3f LightThatPasses(const RenderScene& scene, const Vec3f& position, const Vec3f& start,
                      const LightSample& light) {
  if (!std::isfinite(light.distance)) {
    return scene.Transmittance(start, light.direction, light.distance);
  }
  const Vec3f target = position + light.distance * light.direction;
  const Vec3f to = target - start;
  const float distance = to.norm();
  const float clear = 2.0f * OffsetDistance(target) + 1e-4f * distance;
  if (distance <= clear) return Vec3f::Ones();
  return scene.Transmittance(start, to / distance, distance - clear);
}

// What the denoiser is told about the first surface.
Vec3f GuideAlbedo(const SurfaceSample& s) {
  const float opaque = 1.0f - s.transmission * (1.0f - s.metallic);
  return (s.base_color * opaque + Vec3f::Constant(1.0f - opaque)).cwiseMax(0.0f).cwiseMin(1.0f);
}

// Whether most of what it reflects goes about equally to all sides.
bool ScattersWidely(const SurfaceSample& s) {
  constexpr float kWideRoughness = 0.4f;
  constexpr float kSharpShare = 0.35f;
  const float plastic = (1.0f - s.metallic) * (1.0f - s.transmission);
  const float base = Luminance(s.base_color);
  float wide = plastic * base;
  float sharp = 0.06f * s.clearcoat * (s.clearcoat_roughness < kWideRoughness ? 1.0f : 0.0f) +
                (1.0f - s.metallic) * s.transmission;
  (s.roughness < kWideRoughness ? sharp : wide) += s.metallic * base + plastic * 0.12f * s.specular;
  return sharp <= kSharpShare * (wide + sharp);
}

}  // namespace

PathResult TracePath(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
                     const Ray& camera_ray, Sampler& sampler, PathTrail* trail) {
  PathResult result;
  Ray ray = camera_ray;
  Vec3f throughput = Vec3f::Ones();
  LightReceiver receiver;  // The last vertex that gathered light.
  float pdf =
      kInfinity;  // With which the ray left it; infinity: no light sampling could have done this.
  float min_alpha = 0;
  bool guided = false;
  Vec3f tint = Vec3f::Ones();  // Of the mirrors and panes before the surface that guides.
  int bounce = 0, passages = 0;
  const bool use_lights = options.direct != DirectLight::kBsdfSampling && !lights.empty();
  const auto add = [&](const Vec3f& contribution) {
    if (!contribution.allFinite()) return;
    result.radiance += bounce > 0 ? Clamped(contribution, options.clamp_luminance) : contribution;
  };
  // Density for MIS: single strategies either count whole or not at all.
  const auto found_by_bsdf = [&] {
    return options.direct != DirectLight::kLightSampling || !std::isfinite(pdf);
  };
  const auto mis_pdf = [&] {
    return options.direct == DirectLight::kBsdfSampling ? kInfinity : pdf;
  };

  // What a light's face that the ray met sends back along it, weighted by MIS.
  const auto mesh_light = [&](uint32_t placed, uint16_t slot, const Vec3f& position, float cosine) {
    const Vec3f radiance = lights.MeshRadiance(placed, slot);
    if (!std::isfinite(pdf) || options.direct == DirectLight::kBsdfSampling) return radiance;
    const float distance = (position - receiver.position).norm();
    const float light_pdf = lights.MeshPdf(receiver, placed, slot, distance, cosine);
    return Vec3f(radiance * PowerHeuristic(pdf, light_pdf));
  };

  while (true) {
    RawHit raw;
    ++result.rays;
    const bool met = scene.Intersect(ray, 0.0f, &raw);
    if (bounce > 0 && found_by_bsdf()) {
      const Vec3f spheres = lights.SphereRadiance(receiver, ray.origin, ray.direction,
                                                  met ? raw.distance : kInfinity, mis_pdf());
      if (!spheres.isZero()) add(throughput.cwiseProduct(spheres));
    }
    if (!met) {
      if (found_by_bsdf()) {
        const Vec3f sky = lights.EscapeRadiance(receiver, ray.direction, mis_pdf());
        add(throughput.cwiseProduct(sky));
        if (!guided) result.albedo = sky.cwiseMin(1.0f).cwiseProduct(tint);
      }
      return result;
    }

    // ---- What the cache knows ----
    const Vec2f jitter = options.cache ? sampler.Pair() : Vec2f::Zero();
    const float width = ray.width_m + ray.spread * raw.distance;
    if (options.cache && bounce >= options.cache_from && guided) {
      const SurfaceId id = scene.Identify(raw);
      if (!scene.traits(id.material).needs_tracing) {
        const bool front = ray.direction.dot(id.geometric_normal) < 0.0f;
        const CachePlace place{raw.position,
                               front ? id.geometric_normal : Vec3f(-id.geometric_normal),
                               raw.placed, id.slot};
        Vec3f cached;
        if (options.cache->Lookup(place, jitter, width, &cached)) {
          if (front && found_by_bsdf() && lights.IsMeshLight(raw.placed, id.slot)) {
            add(throughput.cwiseProduct(
                mesh_light(raw.placed, id.slot, raw.position, -ray.direction.dot(place.normal))));
          }
          add(throughput.cwiseProduct(cached));
          return result;
        }
      }
    }

    // ---- The surface ----
    const SurfaceHit hit = scene.Resolve(raw);
    const Vec3f out = -ray.direction;
    const bool outside = out.dot(hit.geometric_normal) > 0.0f;
    const float side = outside ? 1.0f : -1.0f;
    const Vec3f normal = side * hit.geometric_normal;
    const SurfaceSample surface = scene.Evaluate(hit, width);

    // ---- Light that it sends out ----
    if (lights.IsMeshLight(hit.placed, hit.slot)) {
      if (outside && found_by_bsdf()) {
        add(throughput.cwiseProduct(
            mesh_light(hit.placed, hit.slot, hit.position, out.dot(hit.geometric_normal))));
      }
    } else if (surface.emission.maxCoeff() > 0.0f) {
      add(throughput.cwiseProduct(surface.emission));
    }

    const Vec2f choices = sampler.Pair();  // Lobe, Russian roulette.
    const Vec2f through = sampler.Pair();  // Opacity, light.
    if (surface.opacity < 1.0f && through.x() >= surface.opacity) {
      if (++passages > kMaxPassages) return result;
      ray.origin = OffsetPoint(hit.position, -normal);
      ray.width_m = width;
      continue;
    }

    // ---- How it scatters ----
    const ShadingFrame frame(UsableNormal(side * scene.BumpedNormal(hit, width), normal, out));
    if (trail && trail->size < static_cast<int>(trail->vertices.size()) &&
        !scene.traits(hit.material).needs_tracing) {
      trail->vertices[static_cast<size_t>(trail->size++)] = {
          {hit.position, normal, hit.placed, hit.slot},
          ScattersWidely(surface),
          throughput,
          result.radiance};
    }
    const Vec3f o = frame.ToLocal(out);
    const Bsdf bsdf(surface, o, outside, min_alpha);
    const bool last = bounce >= options.max_bounces;
    // What solid glass refracts is torn by its bumps: there the glass itself guides.
    const bool solid_glass = surface.transmission > 0.0f && !surface.thin_walled;
    if (!guided && (last || bounce >= kGuideBounces || !bsdf.mirror_like() || solid_glass)) {
      result.albedo = GuideAlbedo(surface).cwiseProduct(tint);
      result.normal = frame.z;
      guided = true;
    }
    if (last && !(surface.thin_walled && surface.transmission > 0.0f)) return result;
    const float bend2 = 1.0f - Square(frame.z.dot(normal));
    // What is left of light from a direction: none when shading and true normal see it on different
    // sides (it would leak or blacken), and less near the true horizon, so that the coarse faces of
    // smooth meshes cast no hard edge.
    const auto admitted = [&](const Vec3f& world, const Vec3f& local) {
      const float height = normal.dot(world);
      if ((height > 0.0f) != (local.z() > 0.0f)) return 0.0f;
      return local.z() > 0.0f ? TerminatorFactor(height, bend2) : 1.0f;
    };

    // ---- Next-event estimation ----
    const bool gathers = use_lights && !last && !bsdf.mirror_like();
    LightReceiver here;
    if (gathers) {
      here = lights.Receive(hit.position);
      const LightSample light = lights.Sample(here, through.y(), sampler.Pair());
      if (light.pdf > 0.0f && !light.radiance.isZero()) {
        const Vec3f i = frame.ToLocal(light.direction);
        const float part = admitted(light.direction, i);
        BsdfValue value;
        if (part > 0.0f) value = bsdf.Evaluate(i);
        value.f_cos *= part;
        if (!IsBlack(value.f_cos)) {
          const float weight = light.ideal || options.direct == DirectLight::kLightSampling
                                   ? 1.0f
                                   : PowerHeuristic(light.pdf, value.pdf);
          const Vec3f contribution =
              throughput.cwiseProduct(value.f_cos).cwiseProduct(light.radiance) *
              (weight / light.pdf);
          if (contribution.maxCoeff() > 1e-7f) {
            const float leave = i.z() > 0.0f ? 1.0f : -1.0f;
            const Vec3f start = OffsetPoint(hit.position, leave * normal);
            ++result.rays;
            add(contribution.cwiseProduct(LightThatPasses(scene, hit.position, start, light)));
          }
        }
      }
    } else {
      sampler.Pair();
    }

    // ---- The next ray ----
    const std::optional<BsdfSample> next = bsdf.Sample(choices.x(), sampler.Pair());
    if (!next) return result;
    if (!guided) {
      tint = tint.cwiseProduct(next->weight.cwiseMin(1.0f));
      const bool glint =
          surface.transmission > 0.0f && !next->straight && next->direction.z() > 0.0f;
      if (glint) result.guide_weight = kGlintWeight;
    }
    const Vec3f direction = frame.ToWorld(next->direction).normalized();
    if (next->straight) {
      if (++passages > kMaxPassages) return result;
      throughput = throughput.cwiseProduct(next->weight);
      ray.origin = OffsetPoint(hit.position, -normal);
      ray.width_m = width;
      continue;
    }
    const float part = last ? 0.0f : admitted(direction, next->direction);
    if (part <= 0.0f) return result;
    throughput = throughput.cwiseProduct(next->weight) * part;
    if (!throughput.allFinite() || IsBlack(throughput)) return result;
    ++bounce;
    if (bounce >= kRouletteFrom) {
      const float survive = std::min(0.95f, throughput.maxCoeff());
      if (choices.y() >= survive) return result;
      throughput /= survive;
    }
    pdf = gathers ? next->pdf : kInfinity;
    receiver = here;
    if (options.regularise && next->blur > 0.1f) min_alpha = 0.09f;
    ray.origin = OffsetPoint(hit.position, next->direction.z() > 0.0f ? normal : Vec3f(-normal));
    ray.direction = direction;
    ray.width_m = width;
    ray.spread = std::min(1.0f, ray.spread + next->blur);
  }
}

}  // namespace parallax
