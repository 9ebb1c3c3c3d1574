// Radiance along a camera ray: unidirectional path tracing with next-event estimation, multiple
// importance sampling and Russian roulette. Without `clamp` and `regularise` the estimate is
// unbiased up to `max_bounces`. Stateless; thread-safe.
#pragma once

#include <array>

#include "worker/render/lights.h"
#include "worker/render/radiance_cache.h"
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
  // Ends paths that have scattered `cache_from` times or more; nullptr: none is used. Borrowed.
  const RadianceCache* cache = nullptr;
  int cache_from = 1;
};

// A surface on a path, as the cache is to learn it.
struct PathVertex {
  CachePlace place;
  bool rough = false;                // Scatters about alike to all sides.
  Vec3f throughput = Vec3f::Ones();  // From here to the path's start.
  Vec3f before = Vec3f::Zero();      // The path's radiance without what is scattered here.
};

struct PathTrail {
  std::array<PathVertex, 12> vertices;
  int size = 0;
};

struct PathResult {
  Vec3f radiance = Vec3f::Zero();
  // For the denoiser, of the first surface that is neither mirror nor clear glass, so that what
  // these show keeps its detail; the sky has its clamped radiance as albedo and no normal.
  Vec3f albedo = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();  // World.
  // What this path's guides count among a pixel's: little where it is one of the few that glass
  // reflects, or the pixel's guides would be noise.
  float guide_weight = 1;
  uint32_t rays = 0;  // Traced, shadow rays included.
};

// With a `trail`, the path's surfaces are written there.
PathResult TracePath(const RenderScene& scene, const LightTable& lights, const PathOptions& options,
                     const Ray& camera_ray, Sampler& sampler, PathTrail* trail = nullptr);

}  // namespace parallax
