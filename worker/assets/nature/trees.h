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
Asset SampleSnag(Rng& rng);
Asset SampleStump(Rng& rng);
Asset SampleLog(Rng& rng);
Asset SampleFallenTrunk(Rng& rng);
Asset SampleDriftwood(Rng& rng);

}  // namespace parallax
