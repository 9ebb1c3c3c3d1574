// Paths in progress as structure of arrays: one row for each quantity, so that eight neighbours are
// loaded into vector lanes at once. Finished walks are removed, and the others compacted in order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "common/math/lanes.h"

namespace parallax {

// As many as fit in the nearest caches, and enough to hide memory latency.
inline constexpr size_t kMostWalks = 256;
inline constexpr size_t kMostBlocks = kMostWalks / kLanes;  // Blocks of eight walks.

// The vector of eight that a row's number type loads into.
namespace lanes {
template <typename T>
struct Eight;
template <>
struct Eight<float> {
  using Type = Float8;
};
template <>
struct Eight<int32_t> {
  using Type = Int8;
};
template <>
struct Eight<uint32_t> {
  using Type = Bits8;
};
}  // namespace lanes

// One quantity of all walks.
template <typename T>
struct alignas(32) Row {
  using Lanes = typename lanes::Eight<T>::Type;
  std::array<T, kMostWalks> of;

  T& operator[](size_t walk) { return of[walk]; }
  const T& operator[](size_t walk) const { return of[walk]; }
  // Returns the lanes of a block. The compiler's vector types may alias their elements.
  Lanes& At(size_t block) { return reinterpret_cast<Lanes*>(of.data())[block]; }
  const Lanes& At(size_t block) const { return reinterpret_cast<const Lanes*>(of.data())[block]; }
  // Stores eight lanes from `walk` on; `walk` need not begin a block.
  void PutFrom(size_t walk, Lanes eight) { std::memcpy(&of[walk], &eight, sizeof(eight)); }
};

// A vector of all walks.
struct Vec3Row {
  Row<float> x, y, z;

  Vec3f operator[](size_t walk) const { return {x[walk], y[walk], z[walk]}; }
  void Set(size_t walk, const Vec3f& v) {
    x[walk] = v.x();
    y[walk] = v.y();
    z[walk] = v.z();
  }
  void PutFrom(size_t walk, const Vec3x8& v) {
    x.PutFrom(walk, v.x);
    y.PutFrom(walk, v.y);
    z.PutFrom(walk, v.z);
  }
  Vec3x8 At(size_t block) const { return {x.At(block), y.At(block), z.At(block)}; }
  void Put(size_t block, const Vec3x8& v) {
    x.At(block) = v.x;
    y.At(block) = v.y;
    z.At(block) = v.z;
  }
};

// The state of all walks that lasts from one step to the next.
struct WalkRows {
  Row<int32_t> path;  // Index of its path.
  // The ray, with its cone.
  Vec3Row origin, direction;
  Row<float> width_m, spread;
  Vec3Row throughput, radiance;
  Vec3Row tint;              // Tint of mirrors and panes before the guiding surface.
  Row<float> transmittance;  // Share of light that passes the haze before the first surface.
  // The last vertex that gathered light, and the density with which the ray left it. Infinity:
  // light sampling could not have found this direction.
  Vec3Row gathered_at;
  Row<int32_t> room, cell;
  Row<float> total, pdf;
  Row<int32_t> bounce, passages, rays;
  Row<int32_t> guided;          // All bits or none.
  Row<int32_t> body, triangle;  // The next hit, where it is known (PathStarts8).
  // The state of its sampler.
  Row<uint32_t> seed, sample, dimension;
};

// The hits of the current rays.
struct HitRows {
  Row<float> u, v;
  Row<int32_t> placed, triangle;
  Vec3Row position;
  Row<float> footprint_m;
  Vec3Row normal;  // Geometric, as RenderScene::Identify gives it.
  Row<float> doubled_area;
  Row<int32_t> slot, material;
  Row<int32_t> lamp;  // Index of the lamp whose face it is, or -1.
};

// Moves the walks that stay to the front, in order, in every row of `Rows`, a struct of rows only.
// `stays`: bits by block; blocks from `blocks` on are not touched.
template <typename Rows>
void CompactRows(const uint8_t* stays, size_t blocks, Rows* rows);

// For each set of staying lanes, the lanes from which the first ones are filled.
const Int8* CompactionOrders();

template <typename Rows>
void CompactRows(const uint8_t* stays, size_t blocks, Rows* rows) {
  static_assert(sizeof(Rows) % sizeof(Row<int32_t>) == 0);
  static const Int8* const orders = CompactionOrders();
  // Nothing moves before the first that leaves.
  size_t begin = 0;
  while (begin < blocks && stays[begin] == 0xff) ++begin;
  auto* const all = reinterpret_cast<char*>(rows);
  for (size_t row = 0; row < sizeof(Rows); row += sizeof(Row<int32_t>)) {
    char* const numbers = all + row;
    char* to = numbers + begin * sizeof(Int8);
    for (size_t block = begin; block < blocks; ++block) {
      const __m256i from =
          _mm256_load_si256(reinterpret_cast<const __m256i*>(numbers + block * sizeof(Int8)));
      // Never beyond what has been read.
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                          _mm256_permutevar8x32_epi32(from, (__m256i)orders[stays[block]]));
      to += sizeof(int32_t) * static_cast<size_t>(__builtin_popcount(stays[block]));
    }
  }
}

}  // namespace parallax
