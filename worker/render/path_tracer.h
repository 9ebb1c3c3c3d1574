// Radiance along a camera ray: unidirectional path tracing with next-event estimation, multiple
// importance sampling and Russian roulette. Without `clamp` and `regularise` the estimate is
// unbiased up to `max_bounces`. Stateless; thread-safe.
#pragma once

#include "worker/render/lights.h"
#include "worker/render/render_scene.h"
#include "worker/render/sampler.h"

namespace parallax {

// Which estimators of direct light are used; tests compare them, everything else uses both.
enum class DirectLight { kBoth, kLightSampling, kBsdfSampling };

struct PathOptions {
  int max_bounces = 6;
  // Contributions after the first surface are cut at this luminance. 0 = never (unbiased).
  float clamp_luminance = 0;
  // Rough up what follows a rough bounce: trades caustics that a few samples can't find for less
  // noise.
  bool regularise = false;
  DirectLight direct = DirectLight::kBoth;
};

struct PathResult {
  Vec3f radiance = Vec3f::Zero();
  // Of the first surface, for the denoiser; the sky has albedo 1 clamped radiance and no normal.
  Vec3f albedo = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();  // World.
  uint32_t rays = 0;             // Traced, shadow rays included.
};

PathResult TracePath(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
                     const Ray& camera_ray, Sampler& sampler);

}  // namespace parallax
