// Vectors of eight numbers (lanes), each of another ray, point or path that is computed together
// with seven more. Operators work lane by lane (GCC's and Clang's vector extensions). Comparisons
// give masks, and `mask ? a : b` selects by lane. A lane's result never depends on the other lanes.
#pragma once

#include <immintrin.h>

#include <cmath>
#include <cstdint>
#include <cstring>

#include "common/math/types.h"

// Put it before a function that computes in lanes. The function is compiled twice, for AVX2 and for
// AVX-512, which has twice as many registers, and the loader takes the one for the processor. Both
// give the same bits. Empty for Clang, and under sanitizers, whose runtime starts after the
// loader's resolvers.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define PARALLAX_LANE_CLONES __attribute__((target_clones("arch=x86-64-v4", "default")))
#else
#define PARALLAX_LANE_CLONES
#endif

namespace parallax {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));
using Bits4 = uint32_t __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int32_t __attribute__((vector_size(32)));
using Bits8 = uint32_t __attribute__((vector_size(32)));
using Mask8 = Int8;  // Each lane: all bits set, or none.

inline constexpr int kLanes = 8;

inline Float8 Splat(float x) { return Float8{x, x, x, x, x, x, x, x}; }
inline Float8 Min(Float8 a, Float8 b) { return _mm256_min_ps(a, b); }
inline Float8 Max(Float8 a, Float8 b) { return _mm256_max_ps(a, b); }
inline Float8 Min(Float8 a, float b) { return Min(a, Splat(b)); }
inline Float8 Max(Float8 a, float b) { return Max(a, Splat(b)); }
inline Float8 Min(float a, Float8 b) { return Min(Splat(a), b); }
inline Float8 Max(float a, Float8 b) { return Max(Splat(a), b); }
inline Float8 Clamp(Float8 x, Float8 low, Float8 high) { return Min(Max(x, low), high); }
inline Float8 Clamp(Float8 x, float low, float high) { return Clamp(x, Splat(low), Splat(high)); }
inline Float8 Sqrt(Float8 x) { return _mm256_sqrt_ps(x); }
inline Float8 Abs(Float8 x) {
  return _mm256_and_ps(x, _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff)));
}
inline Float8 CopySign(float magnitude, Float8 sign) {
  const __m256 bit = _mm256_castsi256_ps(_mm256_set1_epi32(INT32_MIN));
  return _mm256_or_ps(_mm256_and_ps(sign, bit), _mm256_andnot_ps(bit, Splat(magnitude)));
}
inline Float8 Square(Float8 x) { return x * x; }
inline Float8 Floor(Float8 x) { return _mm256_floor_ps(x); }
inline Float8 ToFloat(Int8 x) { return __builtin_convertvector(x, Float8); }
inline Int8 ToInt(Float8 x) { return __builtin_convertvector(x, Int8); }  // Towards zero.

inline float Sum(Float4 x) {
  const Float4 pairs = _mm_add_ps(x, _mm_movehdup_ps(x));
  return _mm_cvtss_f32(_mm_add_ss(pairs, _mm_movehl_ps(pairs, pairs)));
}
inline float Sum(Float8 x) {
  return Sum(Float4(_mm256_castps256_ps128(x)) + Float4(_mm256_extractf128_ps(x, 1)));
}
// Returns the mask of the first `count` lanes.
inline Mask8 FirstLanes(int count) { return Int8{0, 1, 2, 3, 4, 5, 6, 7} < count; }
// Returns the mask as an integer: lane i is bit i.
inline uint32_t BitsOf(Mask8 mask) {
  return static_cast<uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps((__m256i)mask)));
}
inline bool Any(Mask8 mask) { return _mm256_movemask_ps(_mm256_castsi256_ps((__m256i)mask)) != 0; }
inline Mask8 IsFinite(Float8 x) { return Abs(x) < Splat(INFINITY); }

// Returns table[index] for each lane.
inline Float8 Gather(const float* table, Int8 index) {
  const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  return _mm256_mask_i32gather_ps(_mm256_setzero_ps(), table, (__m256i)index, all, 4);
}
// Sets out[k] to table[stride * index + k] for each lane, k = 0 to 3. Four neighbours cost one load
// a lane.
inline void GatherFours(const float* table, Int8 index, int stride, Float8 out[4]) {
  __m256 rows[4];
  for (int k = 0; k < 4; ++k) {
    rows[k] = _mm256_set_m128(_mm_loadu_ps(table + stride * index[k + 4]),
                              _mm_loadu_ps(table + stride * index[k]));
  }
  const __m256 ab = _mm256_unpacklo_ps(rows[0], rows[1]), cd = _mm256_unpackhi_ps(rows[0], rows[1]);
  const __m256 ab2 = _mm256_unpacklo_ps(rows[2], rows[3]),
               cd2 = _mm256_unpackhi_ps(rows[2], rows[3]);
  out[0] = _mm256_shuffle_ps(ab, ab2, 0x44);
  out[1] = _mm256_shuffle_ps(ab, ab2, 0xee);
  out[2] = _mm256_shuffle_ps(cd, cd2, 0x44);
  out[3] = _mm256_shuffle_ps(cd, cd2, 0xee);
}

// Transposes eight rows into eight columns, in place.
inline void Transpose(Float8 rows[kLanes]) {
  __m256 pairs[kLanes], fours[kLanes];
  for (int k = 0; k < kLanes; k += 2) {
    pairs[k] = _mm256_unpacklo_ps(rows[k], rows[k + 1]);
    pairs[k + 1] = _mm256_unpackhi_ps(rows[k], rows[k + 1]);
  }
  for (int k = 0; k < kLanes; k += 4) {
    fours[k] = _mm256_shuffle_ps(pairs[k], pairs[k + 2], 0x44);
    fours[k + 1] = _mm256_shuffle_ps(pairs[k], pairs[k + 2], 0xee);
    fours[k + 2] = _mm256_shuffle_ps(pairs[k + 1], pairs[k + 3], 0x44);
    fours[k + 3] = _mm256_shuffle_ps(pairs[k + 1], pairs[k + 3], 0xee);
  }
  for (int k = 0; k < 4; ++k) {
    rows[k] = _mm256_permute2f128_ps(fours[k], fours[k + 4], 0x20);
    rows[k + 4] = _mm256_permute2f128_ps(fours[k], fours[k + 4], 0x31);
  }
}

// Applies a function of Eigen arrays to the eight lanes.
template <typename Function>
inline Float8 Apply(Float8 x, Function function) {
  using Array = Eigen::Array<float, kLanes, 1>;
  alignas(32) Array values;
  std::memcpy(values.data(), &x, sizeof(x));
  values = function(values);
  std::memcpy(&x, values.data(), sizeof(x));
  return x;
}
inline Float8 Sin(Float8 x) {
  return Apply(x, [](const auto& a) { return a.sin(); });
}
inline Float8 Cos(Float8 x) {
  return Apply(x, [](const auto& a) { return a.cos(); });
}
inline Float8 Exp(Float8 x) {
  return Apply(x, [](const auto& a) { return a.exp(); });
}
inline Float8 Log1p(Float8 x) {
  return Apply(x, [](const auto& a) { return a.log1p(); });
}

// Returns the arc cosine of x in [-1, 1], to 2e-8.   Source: Abramowitz and Stegun, 4.4.46.
inline Float8 Acos(Float8 x) {
  const Float8 a = Abs(x);
  Float8 sum = Splat(-0.0012624911f);
  for (const float c : {0.0066700901f, -0.0170881256f, 0.0308918810f, -0.0501743046f, 0.0889789874f,
                        -0.2145988016f, 1.5707963050f}) {
    sum = sum * a + c;
  }
  const Float8 angle = Sqrt(1.0f - a) * sum;
  return x < 0.0f ? 3.14159265f - angle : angle;
}

// Eight vectors or colours, one in each lane.
struct Vec3x8 {
  Float8 x, y, z;

  Vec3x8() = default;
  Vec3x8(Float8 x_, Float8 y_, Float8 z_) : x(x_), y(y_), z(z_) {}
  // Makes the same vector in all lanes.
  Vec3x8(const Vec3f& v) : x(Splat(v.x())), y(Splat(v.y())), z(Splat(v.z())) {}

  static Vec3x8 Zero() { return {Splat(0), Splat(0), Splat(0)}; }
  static Vec3x8 All(Float8 value) { return {value, value, value}; }

  void Set(int lane, const Vec3f& v) {
    x[lane] = v.x();
    y[lane] = v.y();
    z[lane] = v.z();
  }
  Vec3f Get(int lane) const { return {x[lane], y[lane], z[lane]}; }
};

inline Vec3x8 operator+(const Vec3x8& a, const Vec3x8& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3x8 operator-(const Vec3x8& a, const Vec3x8& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x8 operator-(const Vec3x8& a) { return {-a.x, -a.y, -a.z}; }
// Multiplies component by component, as colours do.
inline Vec3x8 operator*(const Vec3x8& a, const Vec3x8& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3x8 operator*(const Vec3x8& a, Float8 s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3x8 operator*(const Vec3x8& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3x8 operator*(const Vec3f& a, Float8 s) { return {a.x() * s, a.y() * s, a.z() * s}; }
inline Vec3x8& operator*=(Vec3x8& a, Float8 s) { return a = a * s; }
inline Vec3x8 operator/(const Vec3x8& a, Float8 s) { return {a.x / s, a.y / s, a.z / s}; }
inline Vec3x8 operator/(const Vec3x8& a, float s) { return {a.x / s, a.y / s, a.z / s}; }
inline Float8 Dot(const Vec3x8& a, const Vec3x8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
// Returns the dot product, summed in Eigen's order: gives the same bits as Vec3f::dot().
inline Float8 Inner(const Vec3x8& a, const Vec3x8& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}
inline Float8 Norm(const Vec3x8& a) { return Sqrt(Inner(a, a)); }
inline Vec3x8 Cross(const Vec3x8& a, const Vec3x8& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3x8 Normalized(const Vec3x8& a) { return a * (1.0f / Sqrt(Dot(a, a))); }
inline Vec3x8 Select(Mask8 mask, const Vec3x8& a, const Vec3x8& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
inline Vec3x8 Sqrt(const Vec3x8& a) { return {Sqrt(a.x), Sqrt(a.y), Sqrt(a.z)}; }
inline Float8 MaxCoeff(const Vec3x8& a) { return Max(Max(a.x, a.y), a.z); }
inline Mask8 IsFinite(const Vec3x8& a) { return IsFinite(a.x) & IsFinite(a.y) & IsFinite(a.z); }
// Returns the relative luminance.   Source: ITU-R BT.709.
inline Float8 Luminance(const Vec3x8& rgb) {
  return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}

}  // namespace parallax
