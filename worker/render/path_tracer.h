// Radiance along camera rays: unidirectional path tracing with next-event estimation, multiple
// importance sampling and Russian roulette. Without clamp and cache the estimate is unbiased up to
// `max_bounces`.
//
// Many paths go forward together, a step at a time: all rays are traced, then all hits named, all
// surfaces shaded, all shadow rays traced. What a path reads next is fetched while the others take
// their step, so that few wait for memory. A path does not depend on its company.
#pragma once

#include <array>
#include <span>

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
  DirectLight direct = DirectLight::kBoth;
  // Ends paths that have scattered `cache_from` times or more; nullptr: none is used. Borrowed.
  const RadianceCache* cache = nullptr;
  int cache_from = 1;
  // A path's footprint must be this many cells wide: what mirrors show and what lies in corners is
  // traced.
  float cache_footprint = 1.5f;
  // Paths end where the denoiser's guides are known; they gather no light.
  bool only_guides = false;
};

// A surface on a path, as the cache is to learn it.
struct PathVertex {
  CachePlace place;
  bool rough = false;                // Scatters about alike to all sides.
  Vec3f throughput = Vec3f::Ones();  // From here to the path's start.
  Vec3f before = Vec3f::Zero();      // The path's radiance without what is scattered here.
  LightTrial trial;                  // Of the light that was sampled here.
};

struct PathTrail {
  std::array<PathVertex, 12> vertices;
  int size = 0;
};

struct PathResult {
  Vec3f radiance = Vec3f::Zero();
  // For the denoiser, of the first surface that is neither mirror nor clear glass, or of the second
  // mirror, so that what these show keeps its detail; the sky has its clamped radiance as albedo
  // and no normal.
  Vec3f albedo = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();  // World.
  // What this path's guides count among a pixel's: little where it goes the way of a pane, through
  // or back, that fewer paths go, or the pixel's guides would be noise.
  float guide_weight = 1;
  uint32_t rays = 0;  // Traced, shadow rays included.
};

// A path from its camera ray on.
struct Path {
  explicit Path(const Sampler& draws, const Ray& start = {}) : ray(start), sampler(draws) {}

  Ray ray;
  Sampler sampler;
  PathTrail* trail = nullptr;  // Its surfaces are written there. Borrowed.
  PathResult result;           // Once traced.
};

// Keeps its scratch memory from one call to the next: not thread-safe. What it is given must
// outlive it.
class PathTracer {
 public:
  // Paths that fit in the nearest caches together and are enough to hide memory's latency.
  static constexpr size_t kTogether = 256;

  PathTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options);
  ~PathTracer();

  void Trace(std::span<Path> paths);
  PathResult Trace(const Ray& ray, const Sampler& sampler);

 private:
  class Walk;  // A path under way.
  struct Here;
  struct Alike;
  struct Meeting;
  struct Reached;
  struct Group;
  void TraceTogether(std::span<Path> paths);
  void LookAtSurfaces();
  void Look(Alike* alike);
  void ScatterGroup();

  const RenderScene& scene_;
  const LightTable& lights_;
  const PathOptions options_;
  std::vector<Walk> walks_;
  std::vector<Walk*> under_way_;
  // Of the walks that are being shaded.
  std::unique_ptr<Meeting> meeting_;
  std::unique_ptr<Group> group_;
};

}  // namespace parallax
