// Real sizes of each class, with which tests compare the generators. Read by tests and tools.
#pragma once

#include <string_view>

#include "common/math/types.h"

namespace parallax {

// One row of the table.
struct SizeRange {
  std::string_view name;
  Vec3f least_m, most_m;  // Limits of the bounding box, metres.
};

// nullptr when there is no such row.
const SizeRange* FindSizeRange(std::string_view name);

}  // namespace parallax
