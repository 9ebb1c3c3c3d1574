// The state on which the path tracer's steps work. Only for path_tracer.cc and path_surfaces.cc.
#pragma once

#include "worker/render/paths/path_tracer.h"
#include "worker/render/paths/scattering.h"

namespace parallax {

// Walks on the same material, to be evaluated together.
struct Alike {
  int count = 0;
  std::array<uint32_t, kLanes> walks;
};

// Light on its way to eight walks, to be added if nothing is in between.
struct ShadowRays8 {
  Shadow8 rays;
  Mask8 clamped;  // Lanes whose light may be clamped.
};

// Scales light down to luminance `limit` in the lanes `may`; limit 0 clamps nothing.
inline Vec3x8 Clamped(const Vec3x8& light, Mask8 may, float limit) {
  if (limit <= 0.0f) return light;
  const Float8 luminance = Luminance(light);
  return Select(may & (luminance > limit), light * (limit / luminance), light);
}

// Evaluated materials: written by material, read by walk.
class MaterialSamples {
 public:
  // Stores the samples of `count` walks.
  void Put(const std::array<uint32_t, kLanes>& walks, int count, const MaterialSample8& look);
  // Loads the samples of the eight walks from `first` on.
  void Get(size_t first, SurfaceSample8* surface, Vec3x8* shading_normal) const;

 private:
  static constexpr int kParts = 3;  // Parts of a sample, eight floats each.
  std::array<Float8, kMostWalks * kParts> of_;
};

// All that changes while paths are traced.
struct PathTracer::State {
  std::span<PathResult> results;                   // Results of all paths.
  std::array<PathResult, kMostWalks> own_results;  // Storage if the caller wants none.
  bool learning = false;                           // Whether some paths leave a trail.
  std::array<PathTrail*, kMostWalks> trails;
  size_t count = 0;                        // Number of walks.
  std::array<uint8_t, kMostBlocks> stays;  // Unfinished lanes of each block, as bits.
  WalkRows walks;
  HitRows hits;

  size_t path(size_t walk) const { return static_cast<size_t>(walks.path[walk]); }
  PathResult& result(size_t walk) { return results[path(walk)]; }

  // State of the current step.
  std::array<Hits8, kMostBlocks> met;
  std::array<uint64_t, kMostWalks> questions;  // Keys for the cache.
  // Random numbers: lobe and light; point on the light; next direction.
  std::array<Row<float>, 3> u, v;
  enum class Chance : uint32_t { kHole = 1, kRoulette = 2 };
  Float8 Random(size_t block, Chance chance) const;
  std::vector<Alike> alike;         // By material; empty between steps.
  std::vector<uint32_t> materials;  // Materials with waiting walks.
  MaterialSamples materials_seen;
  std::array<LightReceivers8, kMostBlocks> receivers;
  std::array<LightChoices8, kMostBlocks> lights;
  std::vector<Float8> scratch;
  std::array<ShadowRays8, kMostBlocks> shadows;
  std::array<LightTrial*, kMostWalks> trials;  // Trials that the cache's filler wants.
};

}  // namespace parallax
