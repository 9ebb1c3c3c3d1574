#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "worker/assets/kernel/primitives.h"

namespace parallax::kernel {

// Edges of a shape that are not run through once each way: 0 for a closed, consistently oriented
// one.
inline int OpenEdges(const Shape& shape) {
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (const Face& f : shape.faces) {
    for (int k = 0; k < f.corners; ++k) {
      const uint32_t a = f.v[k], b = f.v[(k + 1) % f.corners];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  int open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return open;
}

}  // namespace parallax::kernel
