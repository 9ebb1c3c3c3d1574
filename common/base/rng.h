// Random numbers by address: every decision draws from its own counter-based stream, named by the
// scene's seed and a path ("scene/floating/7/material"). So adding a chair does not change the
// walls, and results do not depend on the number or order of threads.
//
// A stream is Philox4x32-10 whose 64-bit key and upper 64 counter bits are 128 bits of
// SHA-256(seed, path); the lower 64 counter bits count blocks.   Source: Salmon et al., "Parallel
// random numbers: as easy as 1, 2, 3", SC 2011; test vectors: Random123's kat_vectors.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "common/base/ids.h"

namespace parallax {

using PhiloxCounter = std::array<uint32_t, 4>;
using PhiloxKey = std::array<uint32_t, 2>;

// Returns the block of four random words for (counter, key), by ten rounds.
PhiloxCounter Philox4x32(PhiloxCounter counter, PhiloxKey key);

// One stream. A copyable value: a copy continues from the same place. Not thread-safe.
class Rng {
 public:
  explicit Rng(SceneSeed seed, std::string_view path = "");

  // Returns the stream at this one's address + "/" + name (+ "/" + index). It does not depend on
  // how much was drawn from this stream.
  Rng Child(std::string_view name) const;
  Rng Child(std::string_view name, uint64_t index) const;

  // Draws uniformly distributed bits.
  uint32_t Bits32();
  uint64_t Bits64();
  double Uniform();                         // [0, 1), 53 bits.
  double Uniform(double low, double high);  // [low, high); requires low <= high.
  int UniformInt(int low, int high);        // Both ends included; requires low <= high.
  double Normal();                          // Mean 0, standard deviation 1.
  double Normal(double mean, double std) { return mean + std * Normal(); }
  bool Bernoulli(double probability) { return Uniform() < probability; }

  // Returns one of `items`, each with equal probability. Requires that there is one.
  template <typename Container>
  const auto& Pick(const Container& items) {
    return items[static_cast<size_t>(UniformInt(0, static_cast<int>(std::size(items)) - 1))];
  }
  // Puts `items` into a random order.   Source: Fisher-Yates.
  template <typename Container>
  void Shuffle(Container& items) {
    for (int i = static_cast<int>(std::size(items)) - 1; i > 0; --i) {
      std::swap(items[static_cast<size_t>(i)], items[static_cast<size_t>(UniformInt(0, i))]);
    }
  }

  // Draws a seed for something that has its own streams (an asset, a material).
  uint64_t Seed() { return Bits64(); }

 private:
  using Address = std::array<uint32_t, 4>;
  explicit Rng(Address address) : address_(address) {}

  Address address_;
  uint64_t block_ = 0;
  PhiloxCounter words_{};
  int next_word_ = 4;
};

}  // namespace parallax
