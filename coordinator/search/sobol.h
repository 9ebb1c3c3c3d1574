// Scrambled points of Sobol's sequence. Any number of them covers the unit cube more evenly than
// random points, and later ones fill the gaps, so that a search may get more trials at any time.
// Pure and thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace parallax {

// The most dimensions, those of the table of direction numbers.
inline constexpr size_t kMostSobolDimensions = 3667;

// Returns the first `count` points in (0, 1)^dimensions, 1 <= dimensions <= kMostSobolDimensions.
// The first 2^k of them have one coordinate in each of the 2^k equal intervals, in each dimension.
// More points begin with the same ones; another seed gives others.   Source: Joe and Kuo,
// "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30,
// 2008 (direction numbers); Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020.
std::vector<std::vector<double>> SobolPoints(uint64_t seed, size_t count, size_t dimensions);

}  // namespace parallax
