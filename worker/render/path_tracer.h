// Radiance along camera rays: unidirectional path tracing with next-event estimation, multiple
// importance sampling and Russian roulette. Without clamp and cache the estimate is unbiased up to
// `max_bounces`.
//
// Many paths go forward together, a step at a time and eight in vector lanes: all rays are traced,
// then all hits named, all surfaces shaded, all shadow rays traced. What a path reads next is
// fetched while the others take their step, so that few wait for memory. A path does not depend on
// its company.
#pragma once

#include <array>
#include <span>

#include "worker/render/lights.h"
#include "worker/render/radiance_cache.h"
#include "worker/render/render_scene.h"
#include "worker/render/sampler.h"
#include "worker/render/walks.h"

namespace parallax {

class Scatter8;
struct BsdfSample8;
struct SurfaceInteraction8;

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
  LightTrial trial;                  // Outcome of the light sample taken here.
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
  // Weight of this path's guides among its pixel's: small where the path takes the less likely way
  // at a pane (through it or back), which would make the pixel's guides noisy.
  float guide_weight = 1;
  uint32_t rays = 0;  // Traced, shadow rays included.
  // From the eye to the first surface that is no hole; 0: none.
  float distance = 0;
};

// Up to eight paths from their camera rays on.
struct PathStarts8 {
  Rays8 rays;
  Float8 spread;           // As Ray's; their cones begin as points.
  Bits8 seed, sample;      // Seeds and indices of their samplers,
  uint32_t dimension = 0;  // which have drawn so many pairs.
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
  static constexpr size_t kTogether = kMostWalks;

  PathTracer(const RenderScene& scene, const LightTable& lights, const PathOptions& options);
  ~PathTracer();

  // As many paths as results, eight of each start and fewer of the last. New ones join where others
  // have ended, so that company stays numerous.
  void Trace(std::span<const PathStarts8> starts, std::span<PathResult> results);
  void Trace(std::span<Path> paths);
  PathResult Trace(const Ray& ray, const Sampler& sampler);

 private:
  struct State;
  struct PathVertex8;

  void Begin(std::span<PathResult> results);
  // From `next` on, where there is room; returns the first that still waits.
  size_t AddPaths(std::span<const PathStarts8> starts, size_t next);
  // The next eight walks start afresh, as paths from `path` on.
  void AddPaths(size_t path);
  void Step();

  // A step of all paths, in this order; each part begins to fetch what the next reads.
  void Intersect();
  // Adds light of what rays met outside of surfaces, and reads which surfaces the others met.
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

  // Parts of a step. `walk`: one path; `block`: eight.
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
  void TintGuides(const PathVertex8& vertex, const Scatter8& scatter, const BsdfSample8& next);
  void ContinuePaths(const PathVertex8& vertex, const BsdfSample8& next);
  void SpawnRays(const PathVertex8& vertex, Mask8 walks, const BsdfSample8& next);

  const RenderScene& scene_;
  const LightTable& lights_;
  const PathOptions options_;
  const std::unique_ptr<State> state_;
};

}  // namespace parallax
