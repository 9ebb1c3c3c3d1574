// How many pairs a scene has: each of its left eyes makes one with each of its right eyes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Returns the number of right eyes of each left one (rigs.baselines_m); 1 without a list.
inline int32_t EyesOfLeft(const v1::RigConfig& rigs) {
  return std::max<int32_t>(1, rigs.baselines_m_size());
}

// Returns the number of pairs of a scene; rigs.count counts left eyes.
inline int64_t PairsOfScene(const v1::RigConfig& rigs) {
  return int64_t{rigs.count()} * EyesOfLeft(rigs);
}

}  // namespace parallax
