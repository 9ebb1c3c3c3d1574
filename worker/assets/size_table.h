// The sizes that real things of each class have: what tests hold the generators to. Read by tests
// and tools.
#pragma once

#include <string_view>

#include "common/math/types.h"

namespace parallax {

struct SizeRange {
  std::string_view name;
  Vec3f least_m, most_m;  // Limits of the bounding box, metres.
};

// nullptr when there is no such row.
const SizeRange* FindSizeRange(std::string_view name);

}  // namespace parallax
