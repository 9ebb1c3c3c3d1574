// Types of ids and seeds, so that the compiler refuses one in place of another.
#pragma once

#include <compare>
#include <cstdint>

namespace parallax {

template <typename Tag, typename Value>
struct StrongId {
  Value value{};
  auto operator<=>(const StrongId&) const = default;
};

// Seed of the random streams of a scene, or of an asset, material or network; see rng.h.
using SceneSeed = StrongId<struct SceneSeedTag, uint64_t>;
// Row of a study or a job in the coordinator's database, from 1.
using StudyId = StrongId<struct StudyIdTag, int64_t>;
using JobId = StrongId<struct JobIdTag, int64_t>;
// Number of one attempt at a job: each lease gets a larger fence than all leases before it.
using Fence = StrongId<struct FenceTag, uint64_t>;

}  // namespace parallax
