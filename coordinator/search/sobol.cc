#include "coordinator/search/sobol.h"

#include <boost/random/sobol.hpp>

#include "common/base/rng.h"

namespace parallax {
namespace {

uint32_t ReversedBits(uint32_t bits) {
  bits = ((bits >> 1) & 0x55555555u) | ((bits & 0x55555555u) << 1);
  bits = ((bits >> 2) & 0x33333333u) | ((bits & 0x33333333u) << 2);
  bits = ((bits >> 4) & 0x0f0f0f0fu) | ((bits & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(bits);
}

// Nested uniform scrambling: each bit is flipped or not as the seed and the bits above it say.
uint32_t Scrambled(uint32_t bits, uint32_t seed) {
  bits = ReversedBits(bits) + seed;
  bits ^= bits * 0x6c50b47cu;
  bits ^= bits * 0xb82f1e52u;
  bits ^= bits * 0xc7afe638u;
  bits ^= bits * 0x8d22f6e6u;
  return ReversedBits(bits);
}

}  // namespace

std::vector<std::vector<double>> SobolPoints(uint64_t seed, size_t count, size_t dimensions) {
  boost::random::sobol engine(dimensions);
  std::vector<uint32_t> seeds(dimensions);
  const Rng rng(SceneSeed{seed}, "search/sobol");
  for (size_t d = 0; d < dimensions; ++d) seeds[d] = rng.Child("dimension", d).Bits32();
  std::vector<std::vector<double>> points(count, std::vector<double>(dimensions));
  for (size_t i = 0; i < count; ++i) {
    for (size_t d = 0; d < dimensions; ++d) {
      // The engine leaves out the first point, which is 0.
      const auto bits = i == 0 ? 0u : static_cast<uint32_t>(engine() >> 32);
      points[i][d] = (Scrambled(bits, seeds[d]) + 0.5) / 4294967296.0;
    }
  }
  return points;
}

}  // namespace parallax
