// Radiance along camera rays: unidirectional path tracing with next-event estimation, multiple
// importance sampling and Russian roulette. Without clamp and cache the estimate is unbiased up to
// `max_bounces`.
//
// Many paths advance together, one step at a time and eight in vector lanes: all rays are traced,
// then all hits identified, all surfaces shaded, all shadow rays traced. Each step prefetches the
// data of the next while other paths take theirs, so that few wait for memory. A path's result does
// not depend on the others.
#pragma once

#include <array>
#include <span>

#include "worker/render/lights/light_learning.h"
#include "worker/render/lights/light_sampler.h"
#include "worker/render/paths/radiance_cache.h"
#include "worker/render/paths/walks.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/surface/sampler.h"

namespace parallax {

class IrradianceVolume;
class Scatter8;
struct BsdfSample8;
struct SurfaceInteraction8;

// Estimators of direct light. With kSunByLightSampling, light sampling finds lamps and the sun, and
// rays find the sky. Tests compare the first three; an irradiance volume goes with the last.
enum class DirectLight { kBoth, kLightSampling, kBsdfSampling, kSunByLightSampling };

// How paths are traced.
struct PathOptions {
  int max_bounces = 6;
  // Contributions after the first surface are cut at this luminance. 0 = never (unbiased).
  float clamp_luminance = 0;
  DirectLight direct = DirectLight::kBoth;
  // Ends paths that have scattered `cache_from` times or more; null: no cache. Borrowed.
  const RadianceCache* cache = nullptr;
  int cache_from = 1;
  // The least width of a path's footprint, in cells, for it to end in the cache, so that
  // reflections in mirrors and corners are traced.
  float cache_footprint = 1.5f;
  // Ends paths at rough surfaces with the light that arrives there; null: no volume. Borrowed.
  const IrradianceVolume* volume = nullptr;
  // Paths end once the denoiser's guides are known, and gather no light.
  bool only_guides = false;
};

// A surface on a path, as the cache learns it.
struct PathVertex {
  CachePlace place;
  bool rough = false;                // Scatters nearly alike in all directions.
  Vec3f throughput = Vec3f::Ones();  // From here to the path's start.
  Vec3f before = Vec3f::Zero();      // The path's radiance without what is scattered here.
  LightTrial trial;                  // Outcome of the light sample taken here.
};

// The first surfaces of a path, for the cache.
struct PathTrail {
  std::array<PathVertex, 12> vertices;
  int size = 0;
};

// The result of one path.
struct PathResult {
  Vec3f radiance = Vec3f::Zero();
  // Guides of the denoiser, from the first surface that is neither mirror nor clear glass, or from
  // the second mirror, so that reflections keep their detail. The sky has its clamped radiance as
  // albedo and no normal.
  Vec3f albedo = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();  // World.
  // Weight of this path's guides among its pixel's: small where the path takes the less likely way
  // at a pane (through it or back), which would make the pixel's guides noisy.
  float guide_weight = 1;
  uint32_t rays = 0;  // Traced, shadow rays included.
  // Distance from the eye to the first surface that is no hole; 0: none.
  float distance = 0;
  bool met_pane = false;  // The path goes on straight through that surface.
};

// Up to eight paths, from their camera rays on.
struct PathStarts8 {
  Rays8 rays;
  Float8 spread;           // As Ray's; the cones begin as points.
  Bits8 seed, sample;      // Sampler seeds and sample indices.
  uint32_t dimension = 0;  // Pairs drawn so far.
  // The triangles that the rays meet first, as Rasteriser finds them; no ray is traced where they
  // are known.
  static constexpr int32_t kUnknown = -1;  // Body: a ray is traced.
  static constexpr int32_t kNothing = -2;  // Body: the ray meets no surface.
  Int8 body = Int8{} + kUnknown, triangle{};
};

// One path, from its camera ray on.
struct Path {
  explicit Path(const Sampler& draws, const Ray& start = {}) : ray(start), sampler(draws) {}

  Ray ray;
  Sampler sampler;
  PathTrail* trail = nullptr;  // Its surfaces are written there. Borrowed.
  // Whether the ray starts at a surface whose light samples have found lamps and the sun.
  bool lights_sampled = false;
  PathResult result;  // Once traced.
};

// Traces paths. Reuses its scratch memory between calls, so it is not thread-safe. `scene`,
// `lights` and the options' cache must outlive it.
class PathTracer {
 public:
  static constexpr size_t kTogether = kMostWalks;

  PathTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options);
  ~PathTracer();

  // Traces one path for each result; each start holds eight paths, the last may hold fewer. New
  // paths join where others have ended, so that the lanes stay full.
  void Trace(std::span<const PathStarts8> starts, std::span<PathResult> results);
  void Trace(std::span<Path> paths);
  PathResult Trace(const Ray& ray, const Sampler& sampler);

 private:
  struct State;
  struct PathVertex8;

  void Begin(std::span<PathResult> results);
  // Adds paths from start `next` on while there is room; returns the first that still waits.
  size_t AddPaths(std::span<const PathStarts8> starts, size_t next);
  // Resets the next eight walks to paths from `path` on.
  void AddPaths(size_t path);
  void Step();

  // The parts of a step, in this order; each prefetches what the next one reads.
  void Intersect();
  void TakeKnownHits(size_t block, const Rays8& rays, Mask8 known);
  // Adds light that rays met outside of surfaces, and identifies the surfaces that the others met.
  void LoadHits();
  void QueryCache();
  // Ends the paths for which the cache knows the radiance.
  void EndPathsInCache();
  // Removes finished paths and compacts the rest. With `all`, always compacts and keeps the hit
  // rows; otherwise only when at least one path in eight has finished.
  void CompactPaths(bool all);
  void DrawSamples();
  void EvaluateMaterials();
  void ChooseLights();
  // Emission, holes, direct light, guides and the next ray of each path at its surface.
  void ShadeSurfaces();
  void TraceShadowRays();

  // Helpers of a step. `walk`: one path; `block`: eight.
  size_t blocks() const;
  Mask8 Live(size_t block) const;     // Lanes with a path.
  Mask8 Staying(size_t block) const;  // Paths that have not ended.
  void End(size_t block, Mask8 walks);
  void Add(size_t walk, const Vec3f& contribution);
  void Add(size_t block, Mask8 walks, const Vec3x8& contribution);
  bool FoundByBsdf(size_t walk) const;
  Mask8 FoundByBsdf8(size_t block) const;
  float MisPdf(size_t walk) const;
  LightReceiver ReceiverOf(size_t walk) const;
  void Escape(size_t walk);
  void PassHaze(size_t block, const Hits8& hits);
  Vec3f MeshLight(size_t walk, float cosine) const;
  CachePlace PlaceOf(size_t walk, const Vec3f& normal) const;
  void EvaluateMaterial(uint32_t material);
  void ShadeBlock(size_t block);
  void LoadInteraction(PathVertex8* vertex) const;
  void AddEmission(size_t block, const SurfaceInteraction8& at);
  void PassHoles(PathVertex8* vertex);
  void Pass(size_t block, Mask8 walks, const Vec3x8& normal);
  void RecordTrail(const PathVertex8& vertex);
  void SampleLights(PathVertex8* vertex) const;
  void RecordGuides(const PathVertex8& vertex, const Scatter8& scatter);
  void MakeShadowRays(const PathVertex8& vertex, const Scatter8& scatter);
  void EndInVolume(PathVertex8* vertex, const Scatter8& scatter);
  void TintGuides(const PathVertex8& vertex, const Scatter8& scatter, const BsdfSample8& next);
  void ContinuePaths(const PathVertex8& vertex, const BsdfSample8& next);
  void SpawnRays(const PathVertex8& vertex, Mask8 walks, const BsdfSample8& next);

  const RenderScene& scene_;
  const LightTable& lights_;
  const LightSampler light_sampler_;
  const PathOptions options_;
  const std::unique_ptr<State> state_;
};

}  // namespace parallax
