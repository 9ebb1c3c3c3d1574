// Trees: broadleaf and conifer rows of the species tables, standing dead wood, stumps, logs.
// The maker's level of detail comes from the thread's scope (nature/detail.h); the woody frame does
// not depend on it. The trunk's foot is the origin.
#pragma once

#include "worker/assets/asset.h"
#include "worker/assets/nature/species.h"

namespace parallax {

// A broadleaf tree with its leaves for the season.
struct BroadleafParams {
  size_t species = 0;  // A row of BroadleafTable().
  float height_m = 9;
  Season season = Season::kSummer;
  uint64_t seed = 0;
};
Asset MakeBroadleafTree(const BroadleafParams& params);
Asset SampleBroadleafTree(Rng& rng);

// A conifer.
struct ConiferParams {
  size_t species = 0;  // A row of ConiferTable().
  float height_m = 11;
  Season season = Season::kSummer;
  uint64_t seed = 0;
};
Asset MakeConifer(const ConiferParams& params);
Asset SampleConifer(Rng& rng);

// A standing dead tree.
struct SnagParams {
  float height_m = 5;
  float radius_m = 0.16f;  // At breast height.
  bool conifer = false;
  uint64_t seed = 0;
};
// A dead trunk that still stands, broken off above, with stubs of limbs.
Asset MakeSnag(const SnagParams& params);
Asset SampleSnag(Rng& rng);

// A stump with its roots.
struct StumpParams {
  float radius_m = 0.22f, height_m = 0.35f;
  bool splintered = false;  // Broken by wind instead of cut.
  uint64_t seed = 0;
};
Asset MakeStump(const StumpParams& params);
Asset SampleStump(Rng& rng);

// A log or a fallen trunk.
struct LogParams {
  float length_m = 3, radius_m = 0.14f;
  bool cut = true;        // By a saw at both ends; false: a fallen trunk with torn ends and limbs.
  bool bleached = false;  // Driftwood: without bark.
  uint64_t seed = 0;
};
// Lies along x on the ground.
Asset MakeLog(const LogParams& params);
Asset SampleLog(Rng& rng);
Asset SampleFallenTrunk(Rng& rng);
Asset SampleDriftwood(Rng& rng);

}  // namespace parallax
