// Ids and seeds are types, so that one can't be passed for another.
#pragma once

#include <compare>
#include <cstdint>

namespace parallax {

template <typename Tag, typename Value>
struct StrongId {
  Value value{};
  auto operator<=>(const StrongId&) const = default;
};

using SceneSeed = StrongId<struct SceneSeedTag, uint64_t>;
using StudyId = StrongId<struct StudyIdTag, int64_t>;
using JobId = StrongId<struct JobIdTag, int64_t>;
using Fence = StrongId<struct FenceTag, uint64_t>;

}  // namespace parallax
