// A hash of one number, for draws that are too many for streams of `Rng`.
#pragma once

#include <cstdint>

namespace parallax {

// Returns all bits of `x` mixed.   Source: "splitmix64", Steele et al., OOPSLA 2014.
constexpr uint64_t MixBits(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace parallax
