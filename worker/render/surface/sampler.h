// Low-discrepancy points: each pair of dimensions is an Owen-scrambled Sobol' (0,2)-sequence,
// shuffled so that pairs are independent of one another. Either every pixel has its own sequence;
// or the pixels of an image share one, taken along a Z-curve: then the samples of every 2^n x 2^n
// neighbourhood are well distributed together, the remaining error differs from pixel to pixel, and
// a denoiser averages it away. Points depend on stream, pixel and sample only: images do not depend
// on threads or tiles, and two eyes with different streams have independent noise.
//
// Source: Burley, "Practical hash-based Owen scrambling", JCGT 2020; Ahmed and Wonka, "Screen-space
// blue-noise diffusion of Monte Carlo sampling error via hierarchical ordering of pixels", 2020.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/math/lanes.h"

namespace parallax {

// Returns a bijective mix of 32 bits; Bits is a number or a vector of them.
template <typename Bits>
inline Bits MixBits(Bits x) {
  x ^= x >> 16;
  x *= 0x21f0aaadu;
  x ^= x >> 15;
  x *= 0xd35a2d97u;
  x ^= x >> 15;
  return x;
}
// Returns a hash of `value` under `seed`.
template <typename Bits>
inline Bits CombineHash(Bits seed, Bits value) {
  return MixBits(seed ^ (value * 0x9e3779b9u + 0x7f4a7c15u + (seed << 6) + (seed >> 2)));
}

// The image that a sampler belongs to. Its points depend on this, the pixel and the sample only.
struct SampleStream {
  uint64_t scene_seed = 0;
  uint32_t rig = 0;
  uint32_t eye = 0;   // 0 left, 1 right.
  uint32_t pass = 0;  // 0 image, 1 pilot, 2 cache, 3 edges of what is overexposed,
                      // 4 guides, 5 infrared.

  uint32_t Hash() const {
    uint32_t h = MixBits(static_cast<uint32_t>(scene_seed) + 0x5bd1e995u);
    h = CombineHash(h, static_cast<uint32_t>(scene_seed >> 32));
    h = CombineHash(h, rig);
    h = CombineHash(h, eye);
    return CombineHash(h, pass);
  }
};

// The points of one sample of one pixel, drawn in order. Not thread-safe; cheap to make.
class Sampler {
 public:
  Sampler(uint32_t stream_hash, uint32_t x, uint32_t y, uint32_t sample)
      : seed_(SeedOfPixel(stream_hash, x, y)), sample_(sample) {}
  // Returns a sampler of an image whose pixels share one sequence: 2^log2_samples samples a pixel.
  // Where x, y < 2^k, 2 k + log2_samples must not be above 32.
  static Sampler OfImage(uint32_t stream_hash, uint32_t x, uint32_t y, int log2_samples,
                         uint32_t sample) {
    return Sampler(stream_hash, NumberInImage(x, y, log2_samples, sample));
  }
  // Return the seed and the sample number of a sampler of either kind, for one sampler or for eight
  // lanes.
  template <typename Bits>
  static Bits SeedOfPixel(Bits stream_hash, Bits x, Bits y) {
    return CombineHash(CombineHash(stream_hash, x), y);
  }
  template <typename Bits>
  static Bits NumberInImage(Bits x, Bits y, int log2_samples, Bits sample) {
    return ((Spread(x) | Spread(y) << 1) << log2_samples) | sample;
  }

  // Returns the next pair of dimensions, in [0, 1).
  Vec2f Pair() {
    const uint32_t seed = CombineHash(seed_, dimension_++);
    const uint32_t first = Permute(Reverse(sample_), seed);  // The shuffled index, bit-reversed.
    return {ToUnit(Scramble(first, MixBits(seed + 1))),
            ToUnit(Scramble(SecondDimension(first), MixBits(seed + 2)))};
  }

  // Sets `u` and `v` to the pairs that Pair would return for eight samplers with these seeds and
  // samples, at these dimensions.
  static void Pairs(Bits8 seed, Bits8 sample, Bits8 dimension, Float8* u, Float8* v) {
    Points(Reverse(sample), CombineHash(seed, dimension), u, v);
  }
  // Passes the next `count` pairs of each of eight samplers to `put`. Hashes are computed once
  // where all eight lanes have one seed and dimension, as the pixels of an image do at first.
  template <typename PutPair>
  [[gnu::always_inline]] static void Draw(Bits8 seed, Bits8 sample, Bits8 dimension, uint32_t count,
                                          PutPair put) {
    const bool alike = !Any((Mask8)((seed ^ seed[0]) | (dimension ^ dimension[0])) != 0);
    const Bits8 reversed = Reverse(sample);
    for (uint32_t pair = 0; pair < count; ++pair) {
      Float8 u, v;
      if (alike) {
        Points(reversed, CombineHash(seed[0], dimension[0] + pair), &u, &v);
      } else {
        Points(reversed, CombineHash(seed, dimension + pair), &u, &v);
      }
      put(pair, u, v);
    }
  }

  // Returns a random number in [0, 1) for each of eight samplers, for uses that need no good
  // distribution. `use` distinguishes several numbers of one dimension. Costs a third of a pair.
  static Float8 Random(Bits8 seed, Bits8 sample, Bits8 dimension, uint32_t use) {
    return ToUnit(MixBits(CombineHash(seed + use, dimension) ^ (sample * 0x9e3779b9u)));
  }

  uint32_t seed() const { return seed_; }
  uint32_t sample() const { return sample_; }
  uint32_t dimension() const { return dimension_; }

  // Returns the Sobol' sequence's second dimension, from the bit-reversed index. Its matrix is
  // Pascal's triangle modulo 2, so the product is a sum over supersets of bit positions: five
  // shifts.
  template <typename Bits>
  static Bits SecondDimension(Bits reversed) {
    Bits x = reversed;
    x ^= (x << 1) & 0xaaaaaaaau;
    x ^= (x << 2) & 0xccccccccu;
    x ^= (x << 4) & 0xf0f0f0f0u;
    x ^= (x << 8) & 0xff00ff00u;
    x ^= (x << 16) & 0xffff0000u;
    return x;
  }

 private:
  // Sets `u` and `v` to eight points. `seeds` is one seed for all or eight seeds; `reversed` are
  // the bit-reversed sample numbers.
  template <typename Seeds>
  [[gnu::always_inline]] static void Points(Bits8 reversed, Seeds seeds, Float8* u, Float8* v) {
    // The shuffled index. Both dimensions are scrambled from its lowest bit up, so the second one's
    // matrix is mirrored instead of its index.
    const Bits8 index = Reverse(Permute(reversed, seeds));
    *u = ToUnit(Reverse(Permute(index, MixBits(seeds + 1))));
    *v = ToUnit(Reverse(Permute(MirroredSecondDimension(index), MixBits(seeds + 2))));
  }
  // Returns the bit-reversed SecondDimension of the bit-reversed `x`.
  static Bits8 MirroredSecondDimension(Bits8 x) {
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 16) & 0x0000ffffu;
    return x;
  }

  Sampler(uint32_t seed, uint32_t index) : seed_(seed), sample_(index) {}
  // Moves the 16 low bits to the even places.
  template <typename Bits>
  static Bits Spread(Bits x) {
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
  }
  static uint32_t Reverse(uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  }
  // Reverses bytes by a shuffle, their halves by tables.
  static Bits8 Reverse(Bits8 x) {
    const __m256i low = _mm256_set1_epi8(0x0f);
    const __m256i reversed = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
    const __m256i swap = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
    const __m256i bytes = _mm256_shuffle_epi8((__m256i)x, swap);
    const __m256i high = _mm256_and_si256(_mm256_srli_epi16(bytes, 4), low);
    const __m256i first =
        _mm256_slli_epi16(_mm256_shuffle_epi8(reversed, _mm256_and_si256(bytes, low)), 4);
    return (Bits8)_mm256_or_si256(first, _mm256_shuffle_epi8(reversed, high));
  }
  // Returns the nested uniform scramble (Owen's) of a value: each bit is flipped by a hash of the
  // bits above it.
  template <typename Bits>
  static Bits Scramble(Bits x, Bits seed) {
    return Reverse(Permute(Reverse(x), seed));
  }
  // Returns a permutation of x in which each bit depends only on the bits at and below
  // it.   Source: Laine and Karras 2011; Burley's constants.
  template <typename Bits, typename Seed>
  static Bits Permute(Bits x, Seed seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
  }
  static float ToUnit(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }
  static Float8 ToUnit(Bits8 x) { return ToFloat((Int8)(x >> 8)) * 0x1p-24f; }

  uint32_t seed_;
  uint32_t sample_;
  uint32_t dimension_ = 0;
};

}  // namespace parallax
