// The state on which the path tracer's steps work. Only for path_tracer.cc and path_surfaces.cc.
#pragma once

#include "worker/render/path_tracer.h"
#include "worker/render/scatter.h"

namespace parallax {

// Walks on the same material, to be looked at together.
struct Alike {
  int count = 0;
  std::array<uint32_t, kLanes> walks;
};

// Light on its way to eight walks, should nothing stand between.
struct ShadowRays8 {
  Shadow8 rays;
  Mask8 clamped;  // Whether their light may be cut.
};

// Light whose luminance is above the limit is cut to it, where it may be; limit 0: nowhere.
inline Vec3x8 Clamped(const Vec3x8& light, Mask8 may, float limit) {
  if (limit <= 0.0f) return light;
  const Float8 luminance = Luminance(light);
  return Select(may & (luminance > limit), light * (limit / luminance), light);
}

// Evaluated materials: written by material, read by walk.
class MaterialSamples {
 public:
  void Put(const std::array<uint32_t, kLanes>& walks, int count, const MaterialSample8& look);
  // Reads those of the eight walks from `first` on.
  void Get(size_t first, SurfaceSample8* surface, Vec3x8* shading_normal) const;

 private:
  static constexpr int kParts = 3;  // Parts of a surface, eight floats each.
  std::array<Float8, kMostWalks * kParts> of_;
};

struct PathTracer::State {
  std::span<PathResult> results;                   // Results of all paths.
  std::array<PathResult, kMostWalks> own_results;  // Where nobody else keeps them.
  bool learning = false;  // Some leave a trail; then trails are of all paths.
  std::array<PathTrail*, kMostWalks> trails;
  size_t count = 0;                        // Number of walks.
  std::array<uint8_t, kMostBlocks> stays;  // Which of a block have not ended, as bits.
  WalkRows walks;
  HitRows hits;

  size_t path(size_t walk) const { return static_cast<size_t>(walks.path[walk]); }
  PathResult& result(size_t walk) { return results[path(walk)]; }

  // State of the current step.
  std::array<Hits8, kMostBlocks> met;
  std::array<uint64_t, kMostWalks> questions;  // To the cache.
  // Random numbers: lobe and light; the light's point; the way on.
  std::array<Row<float>, 3> u, v;
  enum class Chance : uint32_t { kHole = 1, kRoulette = 2 };
  Float8 Random(size_t block, Chance chance) const;
  std::vector<Alike> alike;         // By material; empty between steps.
  std::vector<uint32_t> materials;  // That some wait at.
  MaterialSamples materials_seen;
  std::array<LightReceivers8, kMostBlocks> receivers;
  std::array<LightChoices8, kMostBlocks> lights;
  std::vector<Float8> scratch;
  std::array<ShadowRays8, kMostBlocks> shadows;
  std::array<LightTrial*, kMostWalks> trials;  // Where the cache's filler wants to know of them.
};

}  // namespace parallax
